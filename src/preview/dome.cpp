// dome.cpp — projection of the dome, and what is drawn on it.
// SPDX-License-Identifier: Apache-2.0
#include "preview/dome.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "malus/core/frame.h"

namespace malus::preview {
namespace {

constexpr Color kInk{35, 35, 35}, kBlack{0, 0, 0};
constexpr double kSunRadius = 8, kPointRadius = 7, kSunDot = 2;  // pixels
constexpr int kLetterWidth = 9;                                  // at most, of a name; pixels

Point center(const DomeView& view) {
    return {view.size / 2.0, view.size / 2.0};
}

bool is_up(const Mark& mark) {
    return mark.zenith <= kPi / 2;
}

void draw_ticks(Picture& picture, const DomeView& view) {
    for (int azimuth = 0; azimuth < 360; azimuth += 30) {
        const Point rim = place_of(view, kPi / 2, to_radians(azimuth));
        const Point c = center(view);
        const double out = 6 / view.radius;
        blend_line(picture, rim, {rim.x + out * (rim.x - c.x), rim.y + out * (rim.y - c.y)}, 1.5,
                   kInk);
    }
}

// Black and white, to be seen on every colour. A ring leaves open what is there.
void draw_symbol(Picture& picture, const DomeView& view, const Mark& mark) {
    const Point at = place_of(view, mark.zenith, mark.azimuth);
    const bool sun = mark.symbol == Symbol::kSun;
    const double radius = sun ? kSunRadius : kPointRadius;
    blend_ring(picture, at, radius - 1, radius + 1, kBlack);
    blend_ring(picture, at, sun ? 0 : radius - 2.5, radius - 0.5, kWhite);
    if (sun) blend_ring(picture, at, 0, kSunDot, kBlack);
}

// Marks stand along the sun's vertical, in haze close to each other. So the sun's name stands on one
// side of it and the others' on the other: where it is steep in the picture, toward the middle, as
// there is room; where it is flat, away from it, clear of the letters E and W.
Word name_of(const DomeView& view, const Mark& mark, const Point& sun) {
    const Point at = place_of(view, mark.zenith, mark.azimuth);
    const int x = static_cast<int>(std::lround(at.x)), y = static_cast<int>(std::lround(at.y));
    const bool is_sun = mark.symbol == Symbol::kSun;
    Word word{x, y + 5, mark.name, {15, kWhite, Align::kLeft, 1}};
    if (std::abs(std::cos(mark.azimuth)) > 0.45) {
        const bool right = (at.x < center(view).x) != is_sun;
        word.x += right ? 13 : -13;
        word.style.align = right ? Align::kLeft : Align::kRight;
        return word;
    }
    const bool below = (at.y > center(view).y) != is_sun;
    word.y += below ? 18 : -17;
    if (is_sun) {
        word.style.align = Align::kCenter;
    } else {
        const bool right = at.x > sun.x;
        const int room = kLetterWidth * static_cast<int>(mark.name.size());
        word.x = right ? std::min(x - 8, view.size - room) : std::max(x + 8, room);
        word.style.align = right ? Align::kLeft : Align::kRight;
    }
    return word;
}

// Whether dark letters can be read wherever the word reaches.
bool stands_on_light(const Picture& picture, const Word& word) {
    const int width = kLetterWidth * static_cast<int>(word.text.size());
    const int left = word.style.align == Align::kLeft     ? word.x
                     : word.style.align == Align::kCenter ? word.x - width / 2
                                                          : word.x - width;
    for (int y = std::max(0, word.y - word.style.size); y < std::min(picture.height, word.y); ++y)
        for (int x = std::max(0, left); x < std::min(picture.width, left + width); ++x) {
            const Color& c = picture.at(x, y);
            if (0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b < 128) return false;  // luma, BT.709
        }
    return true;
}

// Where the sun is seen, if it is marked, else the middle.
Point sun_in(const DomeView& view, const std::vector<Mark>& marks) {
    for (const Mark& mark : marks)
        if (mark.symbol == Symbol::kSun) return place_of(view, mark.zenith, mark.azimuth);
    return center(view);
}

}  // namespace

Point place_of(const DomeView& view, double zenith, double azimuth) {
    const double r = view.radius * zenith / (kPi / 2);
    return {center(view).x - r * std::sin(azimuth), center(view).y - r * std::cos(azimuth)};
}

Vec3 direction_at(const DomeView& view, const Point& place) {
    const double east = center(view).x - place.x, north = center(view).y - place.y;
    const double zenith = std::min(1.0, std::hypot(east, north) / view.radius) * kPi / 2;
    return direction(zenith, std::atan2(east, north));
}

Layers dome_layers(const SkyDome& dome, std::size_t wavelength, double wavelength_nm,
                   const DomeView& view) {
    Layers layers;
    layers.width = layers.height = view.size;
    layers.wavelength_nm = wavelength_nm;
    layers.aolp_zero = AolpZero::kMeridian;
    layers.covered = "the sky";
    for (int y = 0; y < view.size; ++y)
        for (int x = 0; x < view.size; ++x) {
            const Point place{x + 0.5, y + 0.5};
            const Stokes<double> S =
                dome.radiance_in(meridian_frame(direction_at(view, place)), wavelength);
            layers.s0.push_back(static_cast<float>(S.s0));
            layers.dolp.push_back(static_cast<float>(dolp(S)));
            layers.aolp_deg.push_back(static_cast<float>(to_degrees(aolp(S))));
            layers.s1_s0.push_back(static_cast<float>(S.s0 > 0 ? S.s1 / S.s0 : 0));
            layers.s2_s0.push_back(static_cast<float>(S.s0 > 0 ? S.s2 / S.s0 : 0));
            const bool up = distance(place, center(view)) <= view.radius;
            layers.coverage.push_back(up ? 1.0f : 0.0f);
        }
    return layers;
}

void draw_dome(Picture& picture, const DomeView& view, const std::vector<Mark>& marks) {
    blend_ring(picture, center(view), view.radius, 2.0 * view.size, kWhite);
    draw_ticks(picture, view);
    blend_ring(picture, center(view), view.radius - 0.75, view.radius + 0.75, kInk);
    for (const Mark& mark : marks)
        if (is_up(mark)) draw_symbol(picture, view, mark);
}

std::vector<Word> dome_words(const Picture& picture, const DomeView& view,
                             const std::vector<Mark>& marks) {
    const Lettering style{20, kInk, Align::kCenter};
    const int middle = view.size / 2, far = static_cast<int>(std::lround(view.radius)) + 20;
    std::vector<Word> words{{middle, middle - far + 8, "N", style},
                            {middle - far, middle + 7, "E", style},
                            {middle, middle + far + 7, "S", style},
                            {middle + far, middle + 7, "W", style}};
    const Point sun = sun_in(view, marks);
    for (const Mark& mark : marks) {
        if (!is_up(mark)) continue;
        Word name = name_of(view, mark, sun);
        if (stands_on_light(picture, name)) name.style.color = kInk, name.style.halo = 0;
        words.push_back(std::move(name));
    }
    return words;
}

}  // namespace malus::preview
