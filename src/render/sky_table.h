// sky_table.h — the light of the open sky, known beside the paths.
//
//   ⟨X⟩ = ⟨X + α (T − C)⟩
//   X   what a path brings
//   C = Σ f(n,wo,wi) L(wi) cosθi / pdf(wi): what its first vertex would reflect of the directions
//       drawn there, were nothing in the sky's way: X − C is what hides the sky and what is seen instead
//   T = ∫ f(n,wo,wi) L(wi) cosθi dωi: the mean of C, between nodes with many samples that trace no rays
//   α   how much of C reaches the pixel, as the first samples of its other replicates found: 1 in
//       the open, where X and C hardly differ; 0 under cover
//
// Nodes    of SkyGrid, and cells that pixels show; none where that would take more nodes than pixels are
//          worth.
// Errors   of the interpolation: error(), added to the variances. Each replicate has a T of its own, so that
//          the error of its samples, which pixels share, is in the spread of the replicates.
// Cost     T has samples in proportion to those of the pixels that use it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "render/sky_grid.h"

namespace malus {

/// Where a vertex lies among nodes.
inline constexpr std::size_t kCorners = SkyGrid::kCorners;
struct SkySpot {
    int cell = -1;                       ///< −1: T is not known there
    std::array<float, kCorners> weight;  ///< of its corners
};

class SkyTable {
  public:
    SkyTable(const PreparedScene::Impl& scene, const Camera& camera,
             const RenderSettings& settings);

    /// The middle of a pixel shows this surface. Pixels in order, each once at most.
    void look(int pixel_x, int pixel_y, int instance, const Vec3& n);
    /// After all have been looked at: makes the nodes.
    void settle();

    /// Is T known in the middle of a pixel?
    bool knows(int pixel_x, int pixel_y) const { return seen_[pixel(pixel_x, pixel_y)] >= 0; }
    /// Of a surface with normal n seen from wo at (x, y) of the picture, in a pixel.
    SkySpot find(int pixel_x, int pixel_y, double x, double y, int instance, const Vec3& n,
                 const Vec3& wo) const;

    /// What T may be off by between exact nodes, in S0 to S3, as a part of S0.
    double error(int pixel_x, int pixel_y) const;

    std::size_t node_count() const { return nodes_.size(); }
    const SkyNode& node(std::size_t index) const { return nodes_[index]; }

    /// Samples a replicate that T of each node should have, by what its pixels want; never 0.
    std::vector<std::uint32_t> goals(const Exposure& exposure) const;
    std::uint32_t samples(std::size_t node) const { return samples_[node]; }
    /// Adds a sample of each replicate, [S0..S3][wavelength][replicate].
    void add(std::size_t node, const float* C);
    /// After samples were added: T is their mean.
    void develop(std::size_t node);

    /// Nodes of a cell at a pixel, [row][column]: T cosθo, in image frames: [S0..S3][wavelength][replicate].
    using Corners = std::array<const float*, kCorners>;
    /// `space`: for what they are put together in, where they are.
    Corners corners(int cell, int pixel_x, int pixel_y, std::vector<float>& space) const;

  private:
    using Key = SkyGrid::Key;
    struct Cell {
        Key key;
        std::size_t first;  // of cell_nodes_
        std::size_t count;
    };
    struct CellCount {
        Key key;
        std::uint32_t pixels;
    };
    struct Look {
        int instance = -1;
        Vec3f n;
    };

    std::size_t pixel(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(x);
    }
    Key key_at(int pixel_x, int pixel_y) const;
    std::optional<std::uint32_t> fewest_pixels(const std::vector<CellCount>& cells) const;
    double count_nodes(const std::vector<CellCount>& cells, std::uint32_t fewest,
                       double most) const;
    void add_cell(Key cell, std::unordered_map<Key, int>& node_index);
    bool needs(const Exposure& exposure, std::size_t pixel) const;

    SkyGrid grid_;
    Picture picture_;
    int width_;
    std::size_t replicates_, row_;
    std::vector<Look> looks_;             // by pixel, until settled
    std::unordered_map<Key, int> index_;  // of cells
    std::vector<Cell> cells_;
    std::vector<int> cell_nodes_;  // [view][row][column] of each cell
    std::vector<SkyNode> nodes_;
    std::vector<int> seen_;               // by pixel: its cell, −1: none
    std::vector<double> sums_;            // [node][S0..S3][wavelength][replicate]
    std::vector<float> means_;            // the same, times cosθo
    std::vector<std::uint32_t> samples_;  // [node], of each replicate
};

}  // namespace malus
