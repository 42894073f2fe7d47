// sampling_plan.h — where the next samples go.
//
//   e_i = max over wavelengths of max(SE(DoLP), SE(S0)/S0)    error of pixel i (pixel_error, film.h)
//   s_i = root of the mean of min(e, 3 e_i)² over 3 × 3 pixels, weights 1 2 1 across and down
//
// A fixed number of samples is reached in rounds over the whole picture: of each replicate 1, 4, 8, 16, …
// With a target or a time limit, a round serves the pixels with s_i above a goal, which falls from
// round to round down to the target, which is met when 95 % of max(e_i, 1.35 s_i) are at or below it.
// The hardest 2.5 % of the pixels get no more samples than the mean of all.
//
// No bias worth the name: whether a pixel goes on is decided by the spread of nine pixels, of which
// its own counts a quarter.
// Both   only of pixels that show a surface; those beside them that have not met it yet keep pace
//        with them. One that was dark in all of its first samples is believed to be dark.
// A plan depends on exposure and film alone, so that a render that goes on decides as one that never
// stopped.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "malus/render/render.h"

namespace malus {

/// Pixels [x0,x1) × [y0,y1).
struct Tile {
    int x0, y0, x1, y1;
};

class SamplingPlan {
  public:
    SamplingPlan(const RenderSettings& settings, const Exposure& exposure);

    std::size_t tile_count() const { return tiles_.size(); }
    const Tile& tile(std::size_t t) const { return tiles_[t]; }

    /// Takes notice of a pixel of the film; to be called whenever its samples have changed.
    void measure(const Film& film, std::size_t pixel);

    /// Sets exposure.wanted for the next round; says why when there is none.
    std::optional<StoppedBy> plan_round(Exposure& exposure) const;
    /// Tiles with pixels that want samples.
    std::vector<std::size_t> round(const Exposure& exposure) const;
    /// Samples that will be wanted beyond this round, as far as can be told.
    double left_after_round(const Exposure& exposure) const;

  private:
    bool adaptive() const { return settings_.target_error > 0 || settings_.time_limit_s > 0; }
    std::optional<StoppedBy> plan_evenly(Exposure& exposure, std::uint32_t least) const;
    std::optional<StoppedBy> plan_adaptively(Exposure& exposure, std::uint32_t least) const;
    std::vector<std::size_t> above(double goal, const std::vector<double>& smoothed,
                                   const Exposure& exposure) const;
    void keep_pace(Exposure& exposure) const;
    bool beyond_help(const Exposure& exposure) const;
    template <class Visit>
    void for_neighbours(int x, int y, Visit visit) const;
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(x);
    }
    std::vector<double> smoothed_errors() const;
    double error_of_most(const std::vector<double>& smoothed) const;

    const RenderSettings& settings_;
    int width_, height_;
    std::uint32_t cap_;  // samples a replicate
    std::vector<Tile> tiles_;
    std::vector<float> error_;  // e_i; −1 where no surface shows
};

}  // namespace malus
