// error_curve.h — how far pictures are from a reference, and how fast that falls with work.
//
//   error = a xᵖ with x samples or seconds: p the slope of log error against log x, by least squares
//   figure of merit = 1/(σ²T): σ the error after T seconds; constant where σ falls as T^-½
//
// Range   errors of S0 are relative, of DoLP absolute, over the pixels that show a surface, but those of
//         which the reference knows nothing (film.h): one sample carries all of their light.
// Checked in tests/tools/error_curve_test.cpp.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "malus/render/film.h"

namespace malus {

/// What one number is made of the deviations of all pixels.
inline constexpr std::array<const char*, 6> kMeasures{"S0_rms",   "S0_median",   "S0_p95",
                                                      "DoLP_rms", "DoLP_median", "DoLP_p95"};
using Errors = std::array<double, kMeasures.size()>;

/// |ΔS0|/S0 and |ΔDoLP| of pixels, of one picture or of several.
struct Deviations {
    std::vector<double> s0, dolp;
};

/// Adds those of wavelength w of the film from the reference, which has that wavelength, too.
void add_deviations(const Film& film, std::size_t w, const Film& reference, Deviations& to);

/// Pixels that show a surface of which the film knows nothing at some wavelength.
std::size_t unknown_pixels(const Film& film);

/// Those a film should have from the truth: normal deviates of its own error bars, 16 a pixel.
Deviations expected_deviations(const Film& film, std::size_t w);

Errors summarize(Deviations deviations);

/// The largest of each measure, such as over wavelengths.
Errors worst(const std::vector<Errors>& errors);

/// The error of one measure after some work.
struct CurvePoint {
    double samples, seconds, error;
};
using ErrorCurve = std::vector<CurvePoint>;  // by ascending work

/// The points before the first whose error is below `least`.
ErrorCurve cut_below(ErrorCurve curve, double least);

struct Slope {
    double value, error;  ///< error: one standard error, from the scatter about the line
};

/// Of the asymptotic part: the last half of the points, at least four. None of fewer than three.
std::optional<Slope> slope(const ErrorCurve& curve, double CurvePoint::*work);

double figure_of_merit(const CurvePoint& point);

struct TimeTo {
    enum class Kind { kMeasured, kExtrapolated, kSooner, kUnknown } kind;
    double seconds;  ///< kSooner: it takes less than that
};

/// When the error falls below `error` for good: between points along the line of their logarithms,
/// beyond the last by the slope against seconds. Unknown where that is not below kFlattest.
TimeTo time_to(const ErrorCurve& curve, double error);
inline constexpr double kFlattest = -0.25;

}  // namespace malus
