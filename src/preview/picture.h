// picture.h — 8-bit sRGB pictures and the few things the preview does to them.
//
// Frame   rows from the top, x to the right, y down; pixels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace malus::preview {

struct Color {
    std::uint8_t r = 0, g = 0, b = 0;
    friend bool operator==(const Color&, const Color&) = default;
};
inline constexpr Color kWhite{255, 255, 255};

struct Picture {
    int width = 0, height = 0;
    std::vector<Color> pixels;

    Picture() = default;
    Picture(int w, int h, Color fill = kWhite);
    Color& at(int x, int y);
    const Color& at(int x, int y) const;
};

/// Paints [x, x + width) × [y, y + height), cut at the edges of the picture.
void fill(Picture& picture, int x, int y, int width, int height, Color color);

/// Copies `from` with its upper left corner at (x, y), cut at the edges of `onto`.
void paste(Picture& onto, int x, int y, const Picture& from);

/// Each pixel as a square of `times` × `times`.
Picture enlarged(const Picture& picture, int times);

/// The mean, linear in light, of each square of `times` × `times`; squares at the edges are
/// smaller.
Picture reduced(const Picture& picture, int times);

}  // namespace malus::preview
