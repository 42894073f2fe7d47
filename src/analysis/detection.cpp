// detection.cpp — moments, ranks and curves of two populations.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/detection.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "malus/core/contract.h"
#include "malus/optics/stokes.h"

namespace malus {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// A mean resultant length that sums of doubles leave where directions cancel.
constexpr double kNoDirection = 1e-9;

double mean_of(std::span<const double> values) {
    double sum = 0;
    for (double v : values) sum += v;
    return sum / static_cast<double>(values.size());
}

double mean_direction(std::span<const double> values, double period) {
    const double turn = 2 * std::numbers::pi / period;
    double x = 0, y = 0;
    for (double v : values) {
        x += std::cos(turn * v);
        y += std::sin(turn * v);
    }
    if (std::hypot(x, y) < kNoDirection * static_cast<double>(values.size())) return kNaN;
    const double direction = std::atan2(y, x) / turn;
    return direction < 0 ? std::fmod(direction + period, period) : direction;
}

double variance(std::span<const double> values) {
    const double mean = mean_of(values);
    double sum = 0;
    for (double v : values) sum += sqr(v - mean);
    return sum / static_cast<double>(values.size() - 1);
}

// Places in ascending order of the values.
std::vector<std::size_t> order_of(std::span<const double> values) {
    std::vector<std::size_t> order(values.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
    return order;
}

// The ranks of values, counted from 1; equal values share the mean of theirs.
std::vector<double> midranks(std::span<const double> values) {
    const std::vector<std::size_t> order = order_of(values);
    std::vector<double> ranks(values.size());
    for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
        while (end < order.size() && values[order[end]] == values[order[first]]) ++end;
        for (std::size_t i = first; i < end; ++i)
            ranks[order[i]] = 0.5 * static_cast<double>(first + 1 + end);
    }
    return ranks;
}

// What a mask picks of a quantity.
struct Picked {
    std::vector<double> values;
    Population population;
};

Picked pick(const Quantity& q, const Mask& mask, const Mask& known) {
    EXPECT(mask.size() == q.value.size() && (known.empty() || known.size() == mask.size()));
    Picked picked;
    double noise = 0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        if (!mask[i]) continue;
        if (!std::isfinite(q.value[i]) || !(known.empty() || known[i])) {
            ++picked.population.unknown;
            continue;
        }
        picked.values.push_back(static_cast<double>(q.value[i]));
        noise += q.error.empty() ? kNaN : sqr(static_cast<double>(q.error[i]));
    }
    Population& p = picked.population;
    p.pixels = picked.values.size();
    const Moments m = moments(picked.values, q.period);
    p.mean = m.mean;
    p.spread = m.spread;
    p.noise = std::sqrt(noise / static_cast<double>(p.pixels));
    return picked;
}

// How far each lies from a direction.
void take_deviations(std::vector<double>& angles, double from, double period) {
    for (double& angle : angles) angle = std::abs(difference(angle, from, period));
}

}  // namespace

Moments moments(std::span<const double> values, double period) {
    if (values.empty()) return {kNaN, kNaN};
    const double mean = period > 0 ? mean_direction(values, period) : mean_of(values);
    if (values.size() < 2) return {mean, kNaN};
    double sum = 0;
    for (double v : values) sum += sqr(difference(v, mean, period));
    return {mean, std::sqrt(sum / static_cast<double>(values.size() - 1))};
}

Separation separation(const Moments& t, const Moments& b, double period) {
    const double d = difference(t.mean, b.mean, period), squares = sqr(t.spread) + sqr(b.spread);
    return {d, d / b.mean, std::abs(d) / b.spread, sqr(d) / squares,
            0.25 * sqr(d) / squares + 0.5 * std::log(squares / (2 * t.spread * b.spread))};
}

RocArea roc_area(std::span<const double> target, std::span<const double> background) {
    const std::size_t targets = target.size(), backgrounds = background.size();
    if (targets < 2 || backgrounds < 2) return {kNaN, kNaN};
    const double n_t = static_cast<double>(targets), n_b = static_cast<double>(backgrounds);
    std::vector<double> all(target.begin(), target.end());
    all.insert(all.end(), background.begin(), background.end());
    // A value's rank among all less that among its own: how many of the others lie below it.
    const std::vector<double> ranks = midranks(all), own_t = midranks(target),
                              own_b = midranks(background);
    std::vector<double> v10(targets), v01(backgrounds);
    for (std::size_t i = 0; i < targets; ++i) v10[i] = (ranks[i] - own_t[i]) / n_b;
    for (std::size_t j = 0; j < backgrounds; ++j)
        v01[j] = 1 - (ranks[targets + j] - own_b[j]) / n_t;
    return {mean_of(v10), std::sqrt(variance(v10) / n_t + variance(v01) / n_b)};
}

std::vector<RocPoint> roc_curve(std::span<const double> target,
                                std::span<const double> background) {
    if (target.empty() || background.empty()) return {};
    std::vector<double> t(target.begin(), target.end()), b(background.begin(), background.end());
    std::sort(t.begin(), t.end(), std::greater<>());
    std::sort(b.begin(), b.end(), std::greater<>());
    std::vector<RocPoint> curve{{0, 0}};
    for (std::size_t i = 0, j = 0; i < t.size() || j < b.size();) {
        const double threshold = j == b.size() || (i < t.size() && t[i] > b[j]) ? t[i] : b[j];
        while (i < t.size() && t[i] == threshold) ++i;
        while (j < b.size() && b[j] == threshold) ++j;
        curve.push_back({static_cast<double>(j) / static_cast<double>(b.size()),
                         static_cast<double>(i) / static_cast<double>(t.size())});
    }
    return curve;
}

std::vector<RocPoint> thinned(const std::vector<RocPoint>& curve, double step) {
    std::vector<RocPoint> kept;
    for (std::size_t i = 0; i < curve.size(); ++i)
        if (i == 0 || i + 1 == curve.size() ||
            curve[i].false_alarms - kept.back().false_alarms >= step ||
            curve[i].detections - kept.back().detections >= step)
            kept.push_back(curve[i]);
    return kept;
}

Detection detect(const Quantity& q, const Mask& target, const Mask& background, const Mask& known) {
    Picked t = pick(q, target, known), b = pick(q, background, known);
    Detection result{t.population, b.population, {}, {kNaN, kNaN}, {}};
    const Moments of_t{t.population.mean, t.population.spread},
        of_b{b.population.mean, b.population.spread};
    result.separation = separation(of_t, of_b, q.period);
    if (q.period > 0) {
        // Without a direction of the background nothing lies far from it or near.
        if (std::isnan(of_b.mean)) return result;
        take_deviations(t.values, of_b.mean, q.period);
        take_deviations(b.values, of_b.mean, q.period);
    }
    result.roc_area = roc_area(t.values, b.values);
    result.roc = roc_curve(t.values, b.values);
    return result;
}

Mask aolp_known(const Image& image, double wavelength_nm) {
    const Quantity dolp = read_quantity(image, "DoLP", wavelength_nm),
                   aolp = read_quantity(image, "AoLP", wavelength_nm);
    Mask known(dolp.value.size());
    for (std::size_t i = 0; i < known.size(); ++i)
        known[i] = dolp.value[i] > 0 &&
                   (dolp.error.empty() || dolp.value[i] >= 3 * dolp.error[i]) &&
                   (aolp.error.empty() || aolp.error[i] < 90);
    return known;
}

Mask inside(const Mask& mask, int width, int height, double border) {
    const Mask all(mask.size(), 1), other = without(all, mask);
    return without(mask, ring_around(other, width, height, 0, border));
}

}  // namespace malus
