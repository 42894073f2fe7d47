// panels.cpp — from numbers to colours, and what the legends say of it.
// SPDX-License-Identifier: Apache-2.0
#include "preview/panels.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "malus/optics/wavelengths.h"
#include "preview/color_maps.h"

namespace malus::preview {
namespace {

constexpr double kWhitePercentile = 99.5;
constexpr double kLogDecades = 3;
constexpr double kLeastDolp = 1e-6;  // below this, 32-bit rounding decides the angle
constexpr Color kNoLight{30, 30, 30};

std::string short_text(double x, int digits = 4) {
    std::array<char, 32> text;
    const auto end =
        std::to_chars(text.data(), text.data() + text.size(), x, std::chars_format::general, digits)
            .ptr;
    return {text.data(), end};
}

std::string at_wavelength(const Layers& layers) {
    return to_text(layers.wavelength_nm) + " nm";
}

template <class ColorOfPixel>
Picture paint(const Layers& layers, ColorOfPixel color_of_pixel) {
    Picture picture(layers.width, layers.height);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] = color_of_pixel(i);
    return picture;
}

bool is_polarization_known(const Layers& layers, std::size_t pixel) {
    return layers.s0[pixel] > 0 && std::isfinite(layers.dolp[pixel]) &&
           std::isfinite(layers.aolp_deg[pixel]);
}

bool is_anything_covered(const Layers& layers) {
    return std::any_of(layers.coverage.begin(), layers.coverage.end(),
                       [](float a) { return a > 0; });
}

// S0 shown as white: the percentile over what is covered, or over all pixels if nothing is.
double white_of(const Layers& layers) {
    const bool some = is_anything_covered(layers);
    std::vector<float> values;
    for (std::size_t i = 0; i < layers.s0.size(); ++i)
        if (std::isfinite(layers.s0[i]) && (!some || layers.coverage[i] > 0))
            values.push_back(layers.s0[i]);
    if (values.empty()) return 1;
    const double place = kWhitePercentile / 100 * static_cast<double>(values.size() - 1);
    const auto nth = values.begin() + std::lround(place);
    std::nth_element(values.begin(), nth, values.end());
    const float white = *nth > 0 ? *nth : *std::max_element(values.begin(), values.end());
    return white > 0 ? white : 1;
}

Color grey(double encoded) {
    const auto code = static_cast<std::uint8_t>(std::lround(255 * std::clamp(encoded, 0.0, 1.0)));
    return {code, code, code};
}

// Linear: the screen's light is proportional to S0. Log: each decade has the same range of codes.
Color grey_of(double fraction_of_white, GreyScale scale) {
    if (!(fraction_of_white > 0)) return grey(0);
    if (scale == GreyScale::kLinear)
        return grey(srgb_from_linear(std::min(1.0, fraction_of_white)));
    return grey(1 + std::log10(fraction_of_white) / kLogDecades);
}

struct Unit {
    double size = 1;
    std::string name = "W m^-2 sr^-1 nm^-1";
};

// A power of 1000 that leaves ticks without exponents of their own.
Unit radiance_unit(double white) {
    if (white >= 1e-2 && white < 1e4) return {};
    const int power = 3 * static_cast<int>(std::floor(std::log10(white) / 3));
    return {std::pow(10, power), "10^" + std::to_string(power) + " W m^-2 sr^-1 nm^-1"};
}

// Round numbers 0, step, 2 step … up to `upper`, three to six of them.
std::vector<Tick> even_ticks(double upper) {
    const double least = upper / 5 * (1 - 1e-9);
    const double power = std::pow(10, std::floor(std::log10(least)));
    double step = 10 * power;
    for (const double factor : {5.0, 2.5, 2.0, 1.0})
        if (factor * power >= least) step = factor * power;
    std::vector<Tick> ticks;
    for (int i = 0; i * step <= upper * (1 + 1e-9); ++i)
        ticks.push_back({i * step / upper, short_text(i * step)});
    return ticks;
}

// The whole decades of the scale.
std::vector<Tick> log_ticks(double white) {
    std::vector<Tick> ticks;
    const double top = std::log10(white);
    for (double decade = std::ceil(top - kLogDecades); decade <= top; ++decade)
        ticks.push_back({1 + (decade - top) / kLogDecades, "10^" + short_text(decade)});
    return ticks;
}

double vividness_at(const Layers& layers, std::size_t pixel) {
    if (!(layers.dolp[pixel] >= kLeastDolp)) return 0;
    if (!layers.has_errors()) return 1;
    return vividness(layers.stderr_aolp_deg[pixel], layers.dolp[pixel], layers.stderr_dolp[pixel]);
}

std::string aolp_sense(const Layers& layers) {
    switch (layers.aolp_zero) {
        case AolpZero::kImageRight:
            return "counter-clockwise from image right";
        case AolpZero::kMeridian:
            return "from the vertical plane, counter-clockwise looking up";
        case AolpZero::kUnknown:
            break;
    }
    return "counter-clockwise from the file's own axis";
}

Legend aolp_legend(const Layers& layers) {
    Legend legend;
    legend.color = [](double t) { return to_color(linear_rgb(cyclic(180 * t))); };
    for (int degrees = 0; degrees <= 180; degrees += 45)
        legend.ticks.push_back({degrees / 180.0, std::to_string(degrees) + "^o"});
    legend.captions = {aolp_sense(layers),
                       layers.has_errors() ? "grey: the angle is uncertain" : "grey: unpolarized"};
    // No wheel for a dome: the vertical has another direction at each azimuth.
    if (layers.aolp_zero == AolpZero::kImageRight) legend.wheel_from_deg = 0;
    if (layers.aolp_zero == AolpZero::kMeridian)
        legend.captions.back() = "0^o along the radius, 90^o across it; grey: unpolarized";
    return legend;
}

}  // namespace

Panel s0_panel(const Layers& layers, GreyScale scale) {
    const double white = white_of(layers);
    const bool linear = scale == GreyScale::kLinear;
    const std::string pixels = is_anything_covered(layers) ? layers.covered : "all pixels";
    Panel panel;
    panel.quantity = "S0";
    panel.title = "S0, " + at_wavelength(layers);
    panel.description = "radiance S0 at " + at_wavelength(layers) + ", " +
                        (linear ? "linear grey from 0 to white at "
                                : "logarithmic grey, three decades up to white at ") +
                        short_text(white) + " W m^-2 sr^-1 nm^-1, the 99.5th percentile of " +
                        pixels;
    panel.picture =
        paint(layers, [&](std::size_t i) { return grey_of(layers.s0[i] / white, scale); });
    panel.legend.color = [scale](double t) {
        return grey_of(scale == GreyScale::kLinear ? t : std::pow(10, kLogDecades * (t - 1)),
                       scale);
    };
    const Unit unit = linear ? radiance_unit(white) : Unit{};
    panel.legend.ticks = linear ? even_ticks(white / unit.size) : log_ticks(white);
    panel.legend.captions = {
        unit.name + (linear ? "" : ", logarithmic"),
        "white: " + short_text(white / unit.size) + ", 99.5th percentile of " + pixels};
    return panel;
}

Panel dolp_panel(const Layers& layers, double upper_dolp) {
    const std::string upper = short_text(upper_dolp);
    Panel panel;
    panel.quantity = "DoLP";
    panel.title = "DoLP, " + at_wavelength(layers);
    panel.description = "degree of linear polarization at " + at_wavelength(layers) +
                        ", 0 (dark) to " + upper + " (bright)";
    panel.picture = paint(layers, [&](std::size_t i) {
        if (!is_polarization_known(layers, i)) return kNoLight;
        return to_color(linear_rgb(sequential(layers.dolp[i] / upper_dolp)));
    });
    panel.legend.color = [](double t) { return to_color(linear_rgb(sequential(t))); };
    panel.legend.ticks = even_ticks(upper_dolp);
    panel.legend.captions = {"degree of linear polarization"};
    if (upper_dolp < 1)
        panel.legend.captions.push_back("more than " + upper + " looks like " + upper);
    return panel;
}

Panel aolp_panel(const Layers& layers) {
    Panel panel;
    panel.quantity = "AoLP";
    panel.title = "AoLP, " + at_wavelength(layers);
    panel.description =
        "angle of linear polarization at " + at_wavelength(layers) + ", hue for 0 to 180 degrees " +
        aolp_sense(layers) +
        (layers.has_errors() ? ", grey where it is uncertain" : ", grey where unpolarized");
    panel.picture = paint(layers, [&](std::size_t i) {
        if (!is_polarization_known(layers, i)) return kNoLight;
        return to_color(linear_rgb(cyclic(layers.aolp_deg[i], vividness_at(layers, i))));
    });
    panel.legend = aolp_legend(layers);
    return panel;
}

}  // namespace malus::preview
