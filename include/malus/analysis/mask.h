// mask.h — which pixels of an image are meant.
//
// Rows    from the top, as the image's channels; 1 = meant, 0 = not.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "malus/io/exr.h"

namespace malus {

using Mask = std::vector<std::uint8_t>;

/// Pixels with coverage A > 0, all pixels of an image without A.
Mask surface_mask(const Image& image);

/// Pixels that show most of all a node of this name or one below it in the scene, or a material of
/// this name. Throws Error (without a file name) if the header knows no such name, or has no ids.
Mask node_mask(const Image& image, const std::string& name);
Mask material_mask(const Image& image, const std::string& name);

/// Pixels outside `inner` whose distance, between the middles, to the nearest pixel of it is greater
/// than `from` and at most `to` pixels.
Mask ring_around(const Mask& inner, int width, int height, double from, double to);

Mask both(const Mask& a, const Mask& b);     ///< in a and in b
Mask without(const Mask& a, const Mask& b);  ///< in a, not in b
std::size_t count(const Mask& mask);

}  // namespace malus
