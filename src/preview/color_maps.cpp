// color_maps.cpp — OKLab to sRGB, and the maps.
// SPDX-License-Identifier: Apache-2.0
#include "preview/color_maps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace malus::preview {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

OkLab from_lch(double L, double C, double hue_deg) {
    return {L, C * std::cos(hue_deg * kDegree), C * std::sin(hue_deg * kDegree)};
}

double cube(double x) {
    return x * x * x;
}

// From 0 at `none` to 1 at `full`; NaN gives 0.
double ramp(double x, double none, double full) {
    const double t = (x - none) / (full - none);
    return t > 0 ? std::min(t, 1.0) : 0.0;
}

std::uint8_t to_byte(double linear) {
    return static_cast<std::uint8_t>(
        std::lround(255 * srgb_from_linear(std::clamp(linear, 0.0, 1.0))));
}

}  // namespace

// Ottosson's "oklab_to_linear_srgb": inverse of M2, cube, inverse of M1 times XYZ to sRGB.
LinearRgb linear_rgb(const OkLab& c) {
    const double l = cube(c.L + 0.3963377774 * c.a + 0.2158037573 * c.b);
    const double m = cube(c.L - 0.1055613458 * c.a - 0.0638541728 * c.b);
    const double s = cube(c.L - 0.0894841775 * c.a - 1.2914855480 * c.b);
    return {+4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
            -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
            -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

bool in_gamut(const LinearRgb& c) {
    constexpr double kRounding = 1e-9;  // the matrices have ten digits
    const auto [low, high] = std::minmax({c.r, c.g, c.b});
    return low >= -kRounding && high <= 1 + kRounding;
}

double srgb_from_linear(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double linear_from_srgb(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

Color to_color(const LinearRgb& c) {
    return {to_byte(c.r), to_byte(c.g), to_byte(c.b)};
}

OkLab fit_to_gamut(double L, double C, double hue_deg) {
    if (in_gamut(linear_rgb(from_lch(L, C, hue_deg)))) return from_lch(L, C, hue_deg);
    double fits = 0, too_much = C;
    for (int halving = 0; halving < 20; ++halving) {  // to a millionth: far below 8 bits
        const double middle = (fits + too_much) / 2;
        (in_gamut(linear_rgb(from_lch(L, middle, hue_deg))) ? fits : too_much) = middle;
    }
    return from_lch(L, fits, hue_deg);
}

OkLab sequential(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return fit_to_gamut(0.15 + 0.80 * t, 0.155, 280 + 190 * t);
}

OkLab cyclic(double aolp_deg, double vividness) {
    // The most chroma that every hue can have at its best common lightness: 0.1258 at L = 0.74.
    return from_lch(0.74, 0.125 * std::clamp(vividness, 0.0, 1.0), 29 + 2 * aolp_deg);
}

OkLab diverging(double t) {
    t = std::clamp(t, -1.0, 1.0);
    return fit_to_gamut(0.97 - 0.42 * std::abs(t), 0.19 * std::abs(t), t < 0 ? 260 : 29);
}

OkLab combined(double aolp_deg, double strength, double lightness) {
    const double p = std::clamp(strength, 0.0, 1.0), l = std::clamp(lightness, 0.0, 1.0);
    // Between L = 0.59 and 0.80 every hue can have a chroma of 0.1.
    return from_lch(0.97 * (1 - p) * l + p * (0.59 + 0.21 * l), 0.1 * p, 29 + 2 * aolp_deg);
}

double vividness(double stderr_aolp_deg, double dolp, double stderr_dolp) {
    // Three standard errors of DoLP are an angle known to 9.5°, six to 4.8°: the two ramps agree.
    const double by_angle = ramp(stderr_aolp_deg, 30, 5);
    const double by_degree = stderr_dolp == 0 ? 1 : ramp(dolp / stderr_dolp, 3, 6);
    return std::min(by_angle, by_degree);
}

}  // namespace malus::preview
