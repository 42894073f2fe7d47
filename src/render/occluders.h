// occluders.h — in which directions something is in the way of the sky, found before the paths.
//
// With the light of the open sky known (sky_table.h) a path's direction toward free sky tells nothing
// new: what is left to find lies where the sky is hidden. For each square of the picture some rays
// from its surfaces, even over the dome, say where that is, and paths draw the first vertex's light
// from there instead of by the sky's brightness. So in squares of rough paint of which occluders hide a
// small part of the sky: sharp lobes find themselves what they can see, and where much is hidden the
// sky's light is not so well known.
//
//   p(ω) ∝ H(ω) + kDefence mean H,   H: cosθ of the directions met hidden, 0 of those met free,
//   mean over the square's pixels and bilinear over the cells of the dome
//
// No bias  p > 0 over the whole dome, and the balance heuristic weighs p as it does the sky's density.
// Memory   some 8 KiB a square of 256 pixels that has an occluder.
// Cost     2048 rays a square, as of one or two samples a pixel.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "render/prepared_scene.h"

namespace malus {

class Occluders {
  public:
    static constexpr int kSquare = 16;  ///< pixels along a side

    /// Of a picture of this size; at first none are known.
    Occluders(const PreparedScene::Impl& scene, int width, int height);

    /// Follows rays from what the middles of a square's pixels show, by rows of kSquare, nothing for the
    /// sky. Different squares may be looked around at once. Returns the rays.
    std::uint64_t look(int square_x, int square_y, std::span<const std::optional<Hit>> seen);

    /// Draws directions toward what hides the sky at a pixel, azimuths from where the sky's begin; null
    /// where that is not worth its while.
    const SkyDensity* find(int pixel_x, int pixel_y) const;

  private:
    std::size_t index(int square_x, int square_y) const {
        return static_cast<std::size_t>(square_y) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(square_x);
    }
    const PreparedScene::Impl& scene_;
    int columns_;
    std::vector<SkyDensity> toward_;  // by square; dark where nothing hides sky
};

}  // namespace malus
