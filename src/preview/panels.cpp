// panels.cpp — from numbers to colours, and what the legends say of it.
// SPDX-License-Identifier: Apache-2.0
#include "preview/panels.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "malus/optics/wavelengths.h"
#include "preview/color_maps.h"

namespace malus::preview {
namespace {

constexpr double kPercentile = 99.5;
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

// The percentile over what is covered, or over all pixels if nothing is; of the finite ones.
double percentile(const Layers& layers, const std::vector<float>& of) {
    const bool some = is_anything_covered(layers);
    std::vector<float> values;
    for (std::size_t i = 0; i < of.size(); ++i)
        if (std::isfinite(of[i]) && (!some || layers.coverage[i] > 0)) values.push_back(of[i]);
    if (values.empty()) return 0;
    const double place = kPercentile / 100 * static_cast<double>(values.size() - 1);
    const auto nth = values.begin() + std::lround(place);
    std::nth_element(values.begin(), nth, values.end());
    return *nth > 0 ? *nth : *std::max_element(values.begin(), values.end());
}

// Of √(S1² + S2²)/S0, which neither |S1/S0| nor |S2/S0| exceeds, where there is light.
double percentile_of_ratios(const Layers& layers) {
    std::vector<float> both(layers.s0.size());
    for (std::size_t i = 0; i < both.size(); ++i)
        both[i] = layers.s0[i] > 0 ? std::hypot(layers.s1_s0[i], layers.s2_s0[i])
                                   : std::numeric_limits<float>::quiet_NaN();
    return percentile(layers, both);
}

// The next number of a few times a power of ten, at most 1.
double rounded_up(double x) {
    if (!(x > 0)) return 1;
    const double power = std::pow(10, std::floor(std::log10(x)));
    for (const double factor : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0})
        if (factor * power >= x * (1 - 1e-6)) return std::min(1.0, factor * power);
    return std::min(1.0, 10 * power);
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

// The whole decades of a scale that ends there.
std::vector<Tick> log_ticks(double upper, double decades) {
    std::vector<Tick> ticks;
    const double top = std::log10(upper);
    for (double decade = std::ceil(top - decades - 1e-9); decade <= top + 1e-9; ++decade)
        ticks.push_back({1 + (decade - top) / decades, "10^" + short_text(decade)});
    return ticks;
}

// −R, −R/2, 0, R/2, R.
std::vector<Tick> signed_ticks(double ratio) {
    std::vector<Tick> ticks;
    for (int i = -2; i <= 2; ++i) ticks.push_back({(i + 2) / 4.0, short_text(ratio * i / 2)});
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
    legend.color = [](double t, double) { return to_color(linear_rgb(cyclic(180 * t))); };
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

// What is polarized along the first is red, along the second blue.
std::string ratio_sense(const Layers& layers, bool diagonal) {
    switch (layers.aolp_zero) {
        case AolpZero::kImageRight:
            return diagonal ? "red: along 45^o (right and up), blue: along 135^o"
                            : "red: along image right, blue: along image up";
        case AolpZero::kMeridian:
            return diagonal ? "red: along 45^o from the vertical, blue: 135^o"
                            : "red: along the vertical plane, blue: across it";
        case AolpZero::kUnknown:
            break;
    }
    return diagonal ? "red: AoLP 45^o, blue: 135^o" : "red: AoLP 0^o, blue: 90^o";
}

Panel ratio_panel(const Layers& layers, const Scales& scales, const std::vector<float>& ratios,
                  const std::string& component) {
    const std::string limit = short_text(scales.ratio);
    Panel panel;
    panel.quantity = component + "_S0";
    panel.title = component + "/S0, " + at_wavelength(layers);
    panel.description = component + "/S0 at " + at_wavelength(layers) + ", -" + limit +
                        " (blue) over 0 (white) to " + limit + " (red)";
    panel.picture = paint(layers, [&](std::size_t i) {
        if (!is_polarization_known(layers, i)) return kNoLight;
        return to_color(linear_rgb(diverging(ratios[i] / scales.ratio)));
    });
    panel.legend.color = [](double t, double) {
        return to_color(linear_rgb(diverging(2 * t - 1)));
    };
    panel.legend.ticks = signed_ticks(scales.ratio);
    panel.legend.captions = {ratio_sense(layers, component == "S2")};
    if (scales.ratio < 1)
        panel.legend.captions.push_back("beyond " + limit + " looks like " + limit);
    return panel;
}

// The lightness of a grey (OKLab's L), from its light.
double lightness_of(double s0, const Scales& scales) {
    return std::cbrt(linear_from_srgb(grey_of(s0 / scales.white, scales.grey).r / 255.0));
}

/// One of the three errors.
struct ErrorScale {
    std::string quantity, name, unit;  ///< for file names, in words, of the numbers
    double upper, decades;
};

Panel error_panel(const Layers& layers, const Scales& scales, const ErrorScale& scale,
                  const std::vector<float>& errors) {
    const auto color = [scale, table = scales.sequential](double error) {
        const double t = error > 0 ? 1 + std::log10(error / scale.upper) / scale.decades : 0;
        return color_at(table, t);
    };
    const std::string lower = short_text(scale.upper / std::pow(10, scale.decades)),
                      upper = short_text(scale.upper);
    Panel panel;
    panel.quantity = "StdErr_" + scale.quantity;
    panel.title = "error of " + scale.quantity + ", " + at_wavelength(layers);
    panel.description = scale.name + " at " + at_wavelength(layers) + ", logarithmic, " + lower +
                        " (dark) to " + upper + " (bright)" + scale.unit;
    panel.picture = paint(
        layers, [&](std::size_t i) { return layers.s0[i] > 0 ? color(errors[i]) : kNoLight; });
    panel.legend.color = [color, scale](double t, double) {
        return color(scale.upper * std::pow(10, scale.decades * (t - 1)));
    };
    panel.legend.ticks = log_ticks(scale.upper, scale.decades);
    panel.legend.captions = {scale.name + scale.unit,
                             "logarithmic; " + upper + ": nothing is known"};
    return panel;
}

}  // namespace

Scales scales_of(const Layers& layers, GreyScale grey, std::optional<double> upper_dolp) {
    const double white = percentile(layers, layers.s0);
    Scales scales;
    scales.grey = grey;
    scales.white = white > 0 ? white : 1;
    scales.upper_dolp = upper_dolp.value_or(1);
    scales.ratio = upper_dolp.value_or(rounded_up(percentile_of_ratios(layers)));
    return scales;
}

Color color_at(const std::vector<Color>& table, double t) {
    // NaN gives the start.
    const double place = t > 0 ? std::min(t, 1.0) * static_cast<double>(table.size() - 1) : 0;
    const auto first = static_cast<std::size_t>(place);
    const Color &a = table[first], &b = table[std::min(first + 1, table.size() - 1)];
    const auto mix = [part = place - static_cast<double>(first)](std::uint8_t x, std::uint8_t y) {
        return static_cast<std::uint8_t>(std::lround((1 - part) * x + part * y));
    };
    return {mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b)};
}

Panel s0_panel(const Layers& layers, const Scales& scales) {
    const double white = scales.white;
    const GreyScale grey = scales.grey;
    const bool linear = grey == GreyScale::kLinear;
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
        paint(layers, [&](std::size_t i) { return grey_of(layers.s0[i] / white, grey); });
    panel.legend.color = [grey, linear](double t, double) {
        return grey_of(linear ? t : std::pow(10, kLogDecades * (t - 1)), grey);
    };
    const Unit unit = linear ? radiance_unit(white) : Unit{};
    panel.legend.ticks = linear ? even_ticks(white / unit.size) : log_ticks(white, kLogDecades);
    panel.legend.captions = {
        unit.name + (linear ? "" : ", logarithmic"),
        "white: " + short_text(white / unit.size) + ", 99.5th percentile of " + pixels};
    return panel;
}

Panel dolp_panel(const Layers& layers, const Scales& scales) {
    const double upper_dolp = scales.upper_dolp;
    const std::string upper = short_text(upper_dolp);
    Panel panel;
    panel.quantity = "DoLP";
    panel.title = "DoLP, " + at_wavelength(layers);
    panel.description = "degree of linear polarization at " + at_wavelength(layers) +
                        ", 0 (dark) to " + upper + " (bright)";
    panel.picture = paint(layers, [&](std::size_t i) {
        if (!is_polarization_known(layers, i)) return kNoLight;
        return color_at(scales.sequential, layers.dolp[i] / upper_dolp);
    });
    panel.legend.color = [table = scales.sequential](double t, double) {
        return color_at(table, t);
    };
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

Panel s1_panel(const Layers& layers, const Scales& scales) {
    return ratio_panel(layers, scales, layers.s1_s0, "S1");
}

Panel s2_panel(const Layers& layers, const Scales& scales) {
    return ratio_panel(layers, scales, layers.s2_s0, "S2");
}

Panel combined_panel(const Layers& layers, const Scales& scales) {
    const std::string full = short_text(scales.ratio);
    Panel panel;
    panel.quantity = "combined";
    panel.title = "AoLP, DoLP and S0, " + at_wavelength(layers);
    panel.description = "combined picture at " + at_wavelength(layers) +
                        ": hue AoLP, strength of the colour DoLP (full from " + full +
                        " on), brightness S0, of strongly polarized pixels less";
    panel.picture = paint(layers, [&](std::size_t i) {
        if (!is_polarization_known(layers, i)) return kNoLight;
        const double strength = std::min(1.0, layers.dolp[i] / scales.ratio);
        return to_color(linear_rgb(combined(layers.aolp_deg[i], strength * vividness_at(layers, i),
                                            lightness_of(layers.s0[i], scales))));
    });
    panel.legend = aolp_legend(layers);
    panel.legend.color = [](double t, double up) {
        return to_color(linear_rgb(combined(180 * t, up, 0.6)));
    };
    panel.legend.captions = {"hue: AoLP; upward: DoLP, 0 to " + full,
                             "brightness: S0, the less the stronger DoLP"};
    return panel;
}

std::vector<Panel> error_panels(const Layers& layers, const Scales& scales) {
    if (!layers.has_errors()) return {};
    std::vector<float> relative(layers.s0.size());
    for (std::size_t i = 0; i < relative.size(); ++i)
        relative[i] = layers.s0[i] > 0 ? layers.stderr_s0[i] / layers.s0[i] : 0;
    return {error_panel(layers, scales, {"S0", "standard error of S0 by S0", "", 1, 4}, relative),
            error_panel(layers, scales, {"DoLP", "standard error of DoLP", "", 1, 4},
                        layers.stderr_dolp),
            error_panel(layers, scales, {"AoLP", "standard error of AoLP", ", degrees", 90, 3},
                        layers.stderr_aolp_deg)};
}

}  // namespace malus::preview
