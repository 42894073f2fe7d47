// picture.cpp — painting and enlarging pictures.
// SPDX-License-Identifier: Apache-2.0
#include "preview/picture.h"

#include <algorithm>
#include <cmath>

namespace malus::preview {
namespace {

std::size_t place(const Picture& picture, int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
           static_cast<std::size_t>(x);
}

// The pixels that a shape within `reach` of the middle can touch.
template <class Coverage>
void blend_shape(Picture& picture, const Point& middle, double reach, Color color,
                 Coverage coverage) {
    const auto first = [&](double c) { return std::max(0, static_cast<int>(c - reach - 1)); };
    const auto end = [&](double c, int size) {
        return std::min(size, static_cast<int>(c + reach + 2));
    };
    for (int y = first(middle.y); y < end(middle.y, picture.height); ++y)
        for (int x = first(middle.x); x < end(middle.x, picture.width); ++x)
            blend(picture, x, y, color, coverage(Point{x + 0.5, y + 0.5}));
}

}  // namespace

double distance(const Point& a, const Point& b) {
    return std::hypot(a.x - b.x, a.y - b.y);
}

Picture::Picture(int w, int h, Color fill)
    : width(w),
      height(h),
      pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill) {}

Color& Picture::at(int x, int y) {
    return pixels[place(*this, x, y)];
}

const Color& Picture::at(int x, int y) const {
    return pixels[place(*this, x, y)];
}

void fill(Picture& picture, int x, int y, int width, int height, Color color) {
    for (int v = std::max(0, y); v < std::min(picture.height, y + height); ++v)
        for (int u = std::max(0, x); u < std::min(picture.width, x + width); ++u)
            picture.at(u, v) = color;
}

void blend(Picture& picture, int x, int y, Color color, double covered) {
    if (covered == 0) return;
    Color& pixel = picture.at(x, y);
    const auto mix = [covered](std::uint8_t under, std::uint8_t over) {
        return static_cast<std::uint8_t>(std::lround((1 - covered) * under + covered * over));
    };
    pixel = {mix(pixel.r, color.r), mix(pixel.g, color.g), mix(pixel.b, color.b)};
}

double ring_coverage(double r, double inner, double outer) {
    const double within = std::clamp(outer - r + 0.5, 0.0, 1.0);
    return inner > 0 ? within * std::clamp(r - inner + 0.5, 0.0, 1.0) : within;
}

void blend_ring(Picture& picture, const Point& middle, double inner, double outer, Color color) {
    blend_shape(picture, middle, outer, color,
                [&](const Point& p) { return ring_coverage(distance(p, middle), inner, outer); });
}

void blend_line(Picture& picture, const Point& from, const Point& to, double width, Color color) {
    const double length = distance(from, to);
    const Point along{(to.x - from.x) / length, (to.y - from.y) / length};
    const Point middle{(from.x + to.x) / 2, (from.y + to.y) / 2};
    const auto within = [](double offset, double extent) {
        return std::clamp(extent / 2 - std::abs(offset) + 0.5, 0.0, 1.0);
    };
    blend_shape(picture, middle, (length + width) / 2, color, [&](const Point& p) {
        const double x = p.x - middle.x, y = p.y - middle.y;
        return within(x * along.x + y * along.y, length) * within(x * along.y - y * along.x, width);
    });
}

void paste(Picture& onto, int x, int y, const Picture& from) {
    for (int v = std::max(0, -y); v < std::min(from.height, onto.height - y); ++v)
        for (int u = std::max(0, -x); u < std::min(from.width, onto.width - x); ++u)
            onto.at(x + u, y + v) = from.at(u, v);
}

Picture enlarged(const Picture& picture, int times) {
    Picture large(picture.width * times, picture.height * times);
    for (int y = 0; y < large.height; ++y)
        for (int x = 0; x < large.width; ++x) large.at(x, y) = picture.at(x / times, y / times);
    return large;
}

}  // namespace malus::preview
