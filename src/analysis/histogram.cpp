// histogram.cpp — counting, and distances by OpenCV's formulas.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/histogram.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <limits>
#include <numeric>

#include "malus/core/contract.h"

namespace malus {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
    const double n = static_cast<double>(a.size());
    const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n,
                 mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ab += (a[i] - mean_a) * (b[i] - mean_b);
        aa += (a[i] - mean_a) * (a[i] - mean_a);
        bb += (b[i] - mean_b) * (b[i] - mean_b);
    }
    return aa * bb > 0 ? ab / std::sqrt(aa * bb) : (a == b ? 1 : 0);
}

// ∫ |F_a − F_b − offset|, the offset 0 on a line and the median on a circle.
double earth_movers(const Histogram& a, const Histogram& b, bool circular) {
    const double total_a = a.total(), total_b = b.total();
    if (!(total_a > 0 && total_b > 0)) return kNaN;
    std::vector<double> ahead(a.counts.size());
    double sum = 0;
    for (std::size_t i = 0; i < ahead.size(); ++i)
        ahead[i] = sum += a.counts[i] / total_a - b.counts[i] / total_b;
    double offset = 0;
    if (circular) {
        std::vector<double> sorted = ahead;
        const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
        std::nth_element(sorted.begin(), middle, sorted.end());
        offset = *middle;
    }
    double work = 0;
    for (double f : ahead) work += std::abs(f - offset);
    return work * a.bins.width();
}

}  // namespace

double Histogram::total() const {
    return std::accumulate(counts.begin(), counts.end(), 0.0);
}

Histogram histogram(std::span<const float> values, const Mask& mask, const Bins& bins,
                    double period) {
    EXPECT(bins.count > 0 && bins.high > bins.low && mask.size() == values.size());
    Histogram h{bins, std::vector<double>(bins.count), 0, 0, 0};
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!mask[i]) continue;
        double x = values[i];
        if (std::isnan(x)) {
            ++h.unknown;
            continue;
        }
        if (period > 0 && std::isfinite(x)) x -= period * std::floor((x - bins.low) / period);
        if (x < bins.low) {
            ++h.below;
        } else if (x > bins.high) {
            ++h.above;
        } else {
            const auto bin = static_cast<std::size_t>((x - bins.low) / bins.width());
            h.counts[std::min(bin, bins.count - 1)] += 1;
        }
    }
    return h;
}

Histogram normalized(Histogram h) {
    const double total = h.total();
    if (total > 0)
        for (double& count : h.counts) count /= total;
    return h;
}

HistogramDistances distances(const Histogram& a, const Histogram& b, bool circular) {
    EXPECT(a.bins == b.bins);
    HistogramDistances d{};
    d.correlation = correlation(a.counts, b.counts);
    double shared = 0;
    for (std::size_t i = 0; i < a.counts.size(); ++i) {
        const double x = a.counts[i], y = b.counts[i];
        if (std::abs(x) > DBL_EPSILON) {
            d.chi_square += (x - y) * (x - y) / x;
            d.kullback_leibler += x * std::log(x / (std::abs(y) > DBL_EPSILON ? y : 1e-10));
        }
        d.intersection += std::min(x, y);
        shared += std::sqrt(x * y);
    }
    const double both = std::sqrt(a.total() * b.total());
    d.hellinger = both > 0 ? std::sqrt(std::max(0.0, 1 - shared / both)) : kNaN;
    d.earth_movers = earth_movers(a, b, circular);
    return d;
}

}  // namespace malus
