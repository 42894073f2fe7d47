// error_curve.cpp — deviations from a reference, and lines through the logarithms of errors.
// SPDX-License-Identifier: Apache-2.0
#include "tools/error_curve.h"

#include <algorithm>
#include <random>

#include "malus/core/contract.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

bool unknown(const PixelStokes& pixel) {
    return stderr_dolp(pixel) == 1;
}

// Can others be judged by this pixel?
bool tells(const Film& reference, std::size_t pixel, std::size_t w) {
    return reference.coverage[pixel] > 0 && !unknown(reference.at(pixel, w));
}

double rms(const std::vector<double>& x) {
    double squares = 0;
    for (double each : x) squares += sqr(each);
    return std::sqrt(squares / static_cast<double>(x.size()));
}

// The points that the slope is taken of.
ErrorCurve asymptotic_part(const ErrorCurve& curve) {
    const std::size_t count = std::min(curve.size(), std::max<std::size_t>(4, curve.size() / 2));
    return {curve.end() - static_cast<std::ptrdiff_t>(count), curve.end()};
}

double interpolated(const CurvePoint& a, const CurvePoint& b, double error) {
    const double t = std::log(error / a.error) / std::log(b.error / a.error);
    return a.seconds * std::pow(b.seconds / a.seconds, t);
}

}  // namespace

void add_deviations(const Film& film, std::size_t w, const Film& reference, Deviations& to) {
    const auto same = find_wavelength(reference.wavelengths_nm, film.wavelengths_nm[w]);
    EXPECT(same && film.pixel_count() == reference.pixel_count());
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        if (!tells(reference, i, *same)) continue;
        const Stokes<double>&S = film.at(i, w).mean, &truth = reference.at(i, *same).mean;
        to.dolp.push_back(std::abs(dolp(S) - dolp(truth)));
        if (truth.s0 > 0) to.s0.push_back(std::abs(S.s0 / truth.s0 - 1));
    }
}

std::size_t unknown_pixels(const Film& film) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        bool all_known = true;
        for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w)
            all_known = all_known && !unknown(film.at(i, w));
        count += film.coverage[i] > 0 && !all_known ? 1 : 0;
    }
    return count;
}

Deviations expected_deviations(const Film& film, std::size_t w) {
    constexpr int kDraws = 16;
    std::mt19937_64 engine(1);
    std::normal_distribution<double> normal;
    Deviations expected;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        if (!tells(film, i, w)) continue;
        const PixelStokes& pixel = film.at(i, w);
        const double dolp_error = stderr_dolp(pixel), s0 = pixel.mean.s0;
        const double s0_error = std::sqrt(static_cast<double>(pixel.covariance[0]));
        for (int draw = 0; draw < kDraws; ++draw) {
            expected.dolp.push_back(std::abs(normal(engine)) * dolp_error);
            if (s0 > 0) expected.s0.push_back(std::abs(normal(engine)) * s0_error / s0);
        }
    }
    return expected;
}

Errors summarize(Deviations deviations) {
    Errors errors{};
    for (auto [x, at] : {std::pair{&deviations.s0, 0u}, std::pair{&deviations.dolp, 3u}}) {
        if (x->empty()) continue;
        errors[at] = rms(*x);
        errors[at + 1] = quantile(*x, 0.5);
        errors[at + 2] = quantile(*x, 0.95);
    }
    return errors;
}

Errors worst(const std::vector<Errors>& errors) {
    Errors largest{};
    for (const Errors& each : errors)
        for (std::size_t m = 0; m < largest.size(); ++m) largest[m] = std::max(largest[m], each[m]);
    return largest;
}

ErrorCurve cut_below(ErrorCurve curve, double least) {
    const auto below = [&](const CurvePoint& point) { return point.error < least; };
    curve.erase(std::find_if(curve.begin(), curve.end(), below), curve.end());
    return curve;
}

std::optional<Slope> slope(const ErrorCurve& curve, double CurvePoint::*work) {
    const ErrorCurve part = asymptotic_part(curve);
    const auto n = static_cast<double>(part.size());
    if (n < 3) return std::nullopt;
    double mean_x = 0, mean_y = 0;
    for (const CurvePoint& p : part)
        mean_x += std::log(p.*work) / n, mean_y += std::log(p.error) / n;
    double xx = 0, xy = 0, yy = 0;
    for (const CurvePoint& p : part) {
        const double x = std::log(p.*work) - mean_x, y = std::log(p.error) - mean_y;
        xx += x * x, xy += x * y, yy += y * y;
    }
    return Slope{xy / xx, std::sqrt(std::max(0.0, yy - xy * xy / xx) / (n - 2) / xx)};
}

double figure_of_merit(const CurvePoint& point) {
    return 1 / (sqr(point.error) * point.seconds);
}

TimeTo time_to(const ErrorCurve& curve, double error) {
    using Kind = TimeTo::Kind;
    const auto above = std::find_if(curve.rbegin(), curve.rend(),
                                    [&](const CurvePoint& point) { return point.error > error; });
    if (curve.empty()) return {Kind::kUnknown, 0};
    if (above == curve.rend()) return {Kind::kSooner, curve.front().seconds};
    if (above != curve.rbegin())
        return {Kind::kMeasured, interpolated(*above, *std::prev(above), error)};
    const auto line = slope(curve, &CurvePoint::seconds);
    if (!line || !(line->value < kFlattest)) return {Kind::kUnknown, 0};
    return {Kind::kExtrapolated, above->seconds * std::pow(error / above->error, 1 / line->value)};
}

}  // namespace malus
