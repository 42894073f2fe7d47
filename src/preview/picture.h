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

/// A place in a picture; the middle of its upper left pixel is (0.5, 0.5).
struct Point {
    double x, y;
};
double distance(const Point& a, const Point& b);

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

/// Mixes the color over the pixel, `covered` of which it hides, [0,1].
void blend(Picture& picture, int x, int y, Color color, double covered);

/// How much of a pixel at distance r from the middle lies in the ring, [0,1]: soft edges one pixel
/// wide. A ring without inner radius is a disc.
double ring_coverage(double r, double inner, double outer);

/// A ring, and a line with square ends, with soft edges, cut at the edges of the picture.
void blend_ring(Picture& picture, const Point& middle, double inner, double outer, Color color);
void blend_line(Picture& picture, const Point& from, const Point& to, double width, Color color);

/// Copies `from` with its upper left corner at (x, y), cut at the edges of `onto`.
void paste(Picture& onto, int x, int y, const Picture& from);

/// Each pixel as a square of `times` × `times`.
Picture enlarged(const Picture& picture, int times);

}  // namespace malus::preview
