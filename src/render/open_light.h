// open_light.h — T − C of a pixel's paths (sky_table.h), for all replicates side by side.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/path_tracer.h"
#include "render/sky_table.h"

namespace malus {

/// Reused from pixel to pixel.
class OpenLight {
  public:
    OpenLight(std::size_t wavelengths, std::size_t replicates)
        : wavelengths_(wavelengths),
          light_(4 * wavelengths * replicates),
          spots_(replicates),
          weights_(kCorners * replicates) {}

    void begin(const SkyTable& table, int pixel_x, int pixel_y);

    /// T of the paths of a sample, 0 where it is not known; false where it is of none.
    bool find(const Paths& paths, std::size_t sample);
    /// Makes it T − C.
    void subtract(const Paths& paths, std::size_t sample);
    /// [S0..S3][wavelength][replicate]
    const float* light() const { return light_.data(); }

  private:
    // A cell of the table as the pixel sees it.
    struct Cell {
        int index;
        SkyTable::Corners corners;
        std::vector<float> space;
    };
    const SkyTable::Corners& corners(int cell);
    void add_weighted(const SkyTable::Corners& corners);

    std::size_t wavelengths_;
    const SkyTable* table_ = nullptr;
    int pixel_x_ = 0, pixel_y_ = 0;
    std::vector<Cell> cells_;  // those in use, and room of pixels before
    std::size_t used_ = 0;
    std::vector<float> light_;
    std::vector<const SkySpot*> spots_;  // by replicate; null: T is not known
    std::vector<float> weights_;         // of a cell's nodes, [node][replicate]
};

}  // namespace malus
