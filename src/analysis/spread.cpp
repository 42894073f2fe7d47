// spread.cpp — moments of values on a line and on a circle.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/spread.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "malus/core/contract.h"

namespace malus {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kTwoPi = 2 * std::numbers::pi;

struct Moments {
    double mean, deviation;
};

Moments on_line(const std::vector<double>& values) {
    const auto n = static_cast<double>(values.size());
    double mean = 0, squares = 0;
    for (double x : values) mean += x / n;
    for (double x : values) squares += (x - mean) * (x - mean);
    return {mean, values.size() > 1 ? std::sqrt(squares / (n - 1)) : kNaN};
}

Moments on_circle(const std::vector<double>& values, double period) {
    double x = 0, y = 0;
    for (double v : values) {
        x += std::cos(kTwoPi * v / period);
        y += std::sin(kTwoPi * v / period);
    }
    const double length = std::hypot(x, y) / static_cast<double>(values.size());
    const double turns = std::atan2(y, x) / kTwoPi;
    // Rounding may leave R a little above 1, and a turn of −1e-17 is a turn of 1 once floored.
    const double mean = std::fmod(turns - std::floor(turns), 1.0) * period;
    const double deviation = std::sqrt(std::max(0.0, -2 * std::log(length))) * period / kTwoPi;
    return {mean, values.size() > 1 ? deviation : kNaN};
}

Moments moments(const std::vector<double>& values, double period) {
    if (values.empty()) return {kNaN, kNaN};
    return period > 0 ? on_circle(values, period) : on_line(values);
}

// The middle one, or the mean of the two in the middle.
double median(std::vector<double> values) {
    if (values.empty()) return kNaN;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (values.size() % 2 == 1) return *middle;
    return (*std::max_element(values.begin(), middle) + *middle) / 2;
}

double circular_median(std::vector<double> values, double mean, double period) {
    for (double& x : values) x = difference(x, mean, period);
    const double x = mean + median(std::move(values));
    return x - period * std::floor(x / period);
}

// What errors alone would make of equal values.
double deviation_of(const std::vector<double>& errors, double period) {
    if (errors.empty()) return kNaN;
    const auto n = static_cast<double>(errors.size());
    double squares = 0, length = 0;
    for (double e : errors) {
        squares += e * e / n;
        const double phase = kTwoPi * e / (period > 0 ? period : 1);
        length += std::exp(-phase * phase / 2) / n;
    }
    return period > 0 ? std::sqrt(std::max(0.0, -2 * std::log(length))) * period / kTwoPi
                      : std::sqrt(squares);
}

}  // namespace

Spread spread(std::span<const float> values, const Mask& mask, double period) {
    EXPECT(mask.size() == values.size());
    std::vector<double> finite;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (mask[i] && std::isfinite(values[i])) finite.push_back(values[i]);
    const Moments m = moments(finite, period);
    const std::size_t n = finite.size();
    return {
        n, m.mean,
        period > 0 ? circular_median(std::move(finite), m.mean, period) : median(std::move(finite)),
        m.deviation};
}

NoiseShare noise_share(std::span<const float> values, std::span<const float> errors,
                       const Mask& mask, double period, double unknown) {
    EXPECT(mask.size() == values.size() && errors.size() == values.size());
    std::vector<double> known, known_errors;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (mask[i] && std::isfinite(values[i]) && errors[i] < unknown) {  // NaN is not less
            known.push_back(values[i]);
            known_errors.push_back(errors[i]);
        }
    NoiseShare s;
    s.count = known.size();
    s.observed = moments(known, period).deviation;
    s.noise = deviation_of(known_errors, period);
    const double variance = s.observed * s.observed, noise = s.noise * s.noise;
    // std::max would make a 0 of NaN.
    s.truth = variance < noise ? 0 : std::sqrt(variance - noise);
    s.of_variance = noise / variance;
    return s;
}

double unknown_error(const Quantity& quantity) {
    if (quantity.period > 0) return quantity.period / 2;
    return quantity.name == "DoLP" ? 1 : std::numeric_limits<double>::infinity();
}

}  // namespace malus
