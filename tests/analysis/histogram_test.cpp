// histogram_test.cpp — counts and distances against values worked out by hand.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/histogram.h"

#include "support/catch.h"
#include "support/statistics.h"

using namespace malus;

namespace {

Histogram counts(std::vector<double> of_bins, double low = 0, double high = 1) {
    const std::size_t n = of_bins.size();
    return {{low, high, n}, std::move(of_bins), 0, 0, 0};
}

}  // namespace

TEST_CASE("Histogram: each value stands in one place, edges and strays included") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<float> values{
        -0.1f, 0, 0.24f, 0.25f, 0.5f, 1, 1.1f, nan, 0.6f, std::numeric_limits<float>::infinity()};
    Mask mask(values.size(), 1);
    mask[8] = 0;
    const Histogram h = histogram(values, mask, {0, 1, 4});
    CHECK(h.counts == std::vector<double>{2, 1, 1, 1});
    CHECK(h.below == 1);
    CHECK(h.above == 2);
    CHECK(h.unknown == 1);
    CHECK(h.total() == 5);
    CHECK(normalized(h).counts[0] == 0.4);
    CHECK(normalized(counts({0, 0})).counts == std::vector<double>{0, 0});
}

TEST_CASE("Histogram: angles are counted round the circle") {
    const std::vector<float> angles{-1, 179, 180, 0, 361};
    const Histogram h = histogram(angles, Mask(angles.size(), 1), {0, 180, 180}, 180);
    CHECK(h.counts[179] == 2);
    CHECK(h.counts[0] == 2);
    CHECK(h.counts[1] == 1);
    CHECK(h.total() == 5);
}

TEST_CASE("Histogram distances: OpenCV's formulas, by hand") {
    // compareHist's documentation, worked out for H1 = (1, 2, 3), H2 = (3, 2, 2).
    const HistogramDistances d = distances(counts({1, 2, 3}), counts({3, 2, 2}));
    // Means 2 and 7/3: deviations (−1, 0, 1) and (2, −1, −1)/3; of their products −2/3 + 0 − 1/3.
    CHECK(d.correlation == near(-1 / std::sqrt(2 * 2.0 / 3), 1e-12));
    CHECK(d.chi_square == near(4.0 / 1 + 0 + 1.0 / 3, 1e-12));
    CHECK(d.intersection == near(1 + 2 + 2, 1e-12));
    CHECK(d.hellinger ==
          near(std::sqrt(1 - (std::sqrt(3.0) + 2 + std::sqrt(6.0)) / std::sqrt(6.0 * 7.0)), 1e-12));
    CHECK(d.kullback_leibler == near(std::log(1.0 / 3) + 3 * std::log(1.5), 1e-12));
    const HistogramDistances same = distances(counts({1, 0, 3}), counts({1, 0, 3}));
    CHECK(same.correlation == near(1, 1e-12));
    CHECK(same.chi_square == 0);
    CHECK(same.intersection == 4);
    CHECK(same.hellinger == near(0, 1e-12));
    CHECK(same.kullback_leibler == 0);
    CHECK(same.earth_movers == 0);
    // An empty bin beside a full one: 1·ln(1/1e-10).
    CHECK(distances(counts({1, 0}), counts({0, 1})).kullback_leibler ==
          near(10 * std::log(10.0), 1e-12));
    CHECK(distances(counts({1, 0}), counts({0, 1})).hellinger == 1);
}

TEST_CASE("Histogram distances: earth is moved the shorter way, in the unit of the values") {
    // All of it by three bins of 0.5; on a circle of four bins by one.
    CHECK(distances(counts({2, 0, 0, 0}, 0, 2), counts({0, 0, 0, 5}, 0, 2)).earth_movers ==
          near(1.5, 1e-12));
    CHECK(distances(counts({2, 0, 0, 0}, 0, 2), counts({0, 0, 0, 5}, 0, 2), true).earth_movers ==
          near(0.5, 1e-12));
    // Two Gaussians of one width lie as far apart as their means: here 0.7, to a bin's rounding.
    Uniform u(5);
    std::vector<float> a, b;
    for (int i = 0; i < 100000; ++i) {
        const double x = std::sqrt(-2 * std::log(u())) * std::cos(2 * 3.14159265358979 * u());
        a.push_back(static_cast<float>(x));
        b.push_back(static_cast<float>(x + 0.7));
    }
    const Bins bins{-8, 8, 1600};
    const Mask all(a.size(), 1);
    CHECK(distances(histogram(a, all, bins), histogram(b, all, bins)).earth_movers ==
          near(0.7, 1e-4));
    CHECK(std::isnan(distances(counts({0, 0}), counts({1, 0})).earth_movers));
}
