// sampler_test.cpp — Sobol' points and their scrambling.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/sampler.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "support/catch.h"
#include "support/statistics.h"

using namespace malus;

namespace {

// A product over all dimensions, with mean 1 and variance (1 + 1/12)^8 − 1 for random points.
double product(const SamplePoint& u) {
    double f = 1;
    for (double x : u) f *= 0.5 + x;
    return f;
}
const double kProductVariance = std::pow(13.0 / 12, 8) - 1;

}  // namespace

TEST_CASE("Sobol': the first eight points are those that Joe and Kuo list") {
    // Their page's example of three dimensions, in eighths; we visit them in another order.
    const std::set<std::array<int, 3>> listed{{0, 0, 0}, {4, 4, 4}, {6, 2, 2}, {2, 6, 6},
                                              {3, 3, 5}, {7, 7, 1}, {5, 1, 7}, {1, 5, 3}};
    std::set<std::array<int, 3>> found;
    for (std::uint32_t i = 0; i < 8; ++i) {
        const auto x = sobol(i, 0);
        found.insert({static_cast<int>(x[0] >> 29), static_cast<int>(x[1] >> 29),
                      static_cast<int>(x[2] >> 29)});
    }
    CHECK(found == listed);
}

TEST_CASE("Sobol': sixteen dimensions have Sobol's property A") {
    // Joe and Kuo chose their numbers so that 2^16 points fall one into each of the 2^16 boxes that
    // halving every dimension makes.
    std::vector<bool> filled(1u << 16, false);
    for (std::uint32_t i = 0; i < 1u << 16; ++i) {
        std::size_t box = 0;
        for (std::uint32_t block : {0u, 1u})
            for (std::uint32_t x : sobol(i, block)) box = 2 * box + (x >> 31);
        REQUIRE_FALSE(filled[box]);
        filled[box] = true;
    }
}

TEST_CASE("Sobol': sixteen dimensions of two points are those of SciPy") {
    // scipy.stats.qmc.Sobol(16, scramble=False, bits=32) of SciPy 1.10.1, points 54321 and 65535:
    // ours 48681 and 32768, since it visits them in the order of Gray's code.
    const std::array<std::uint32_t, 16> a{0x947d0000, 0x972b0000, 0xbb910000, 0x31710000,
                                          0x67e70000, 0x92470000, 0xaf6b0000, 0x73050000,
                                          0xf2a90000, 0x7e510000, 0x14e30000, 0x3ee30000,
                                          0x9d8b0000, 0xe3bd0000, 0xa8630000, 0xd8750000};
    const std::array<std::uint32_t, 16> b{0x00010000, 0xffff0000, 0x90550000, 0xc3050000,
                                          0x40bb0000, 0x8bbb0000, 0x84670000, 0xba490000,
                                          0xe5250000, 0x29f50000, 0x2c0f0000, 0x12670000,
                                          0xef370000, 0x54090000, 0x75df0000, 0x7ab10000};
    for (std::uint32_t block : {0u, 1u})
        for (std::size_t d = 0; d < 8; ++d) {
            CHECK(sobol(48681, block)[d] == a[8 * block + d]);
            CHECK(sobol(32768, block)[d] == b[8 * block + d]);
        }
}

TEST_CASE("Owen scrambling: every dimension of every block stays stratified") {
    const Sampler sampler(7, 1234, 3);
    constexpr std::uint32_t kCount = 1024;
    for (std::uint32_t block : {0u, 1u, 2u, 9u})
        for (std::size_t d = 0; d < kBlockDimensions; ++d) {
            std::vector<int> cells(kCount, 0);
            for (std::uint32_t i = 0; i < kCount; ++i)
                ++cells[static_cast<std::size_t>(sampler.point(i, block)[d] * kCount)];
            CHECK(std::count(cells.begin(), cells.end(), 1) == kCount);
        }
}

TEST_CASE("Owen scrambling: the first two dimensions stay a (0,m,2)-net") {
    const Sampler sampler(1, 5, 0);
    for (int log_x = 0; log_x <= 8; ++log_x) {
        std::vector<int> cells(256, 0);
        const int nx = 1 << log_x, ny = 256 / nx;
        for (std::uint32_t i = 0; i < 256; ++i) {
            const SamplePoint u = sampler.point(i, 2);
            ++cells[static_cast<std::size_t>(static_cast<int>(u[0] * nx) * ny +
                                             static_cast<int>(u[1] * ny))];
        }
        CHECK(std::count(cells.begin(), cells.end(), 1) == 256);
    }
}

TEST_CASE("Sampler: numbers depend on seed, pixel, replicate, sample and block alone") {
    for (Sampling sampling : {Sampling::kSobol, Sampling::kIndependent}) {
        const SamplePoint a = Sampler(1, 2, 3, sampling).point(4, 5);
        CHECK(a == Sampler(1, 2, 3, sampling).point(4, 5));
        CHECK(a != Sampler(9, 2, 3, sampling).point(4, 5));
        CHECK(a != Sampler(1, 9, 3, sampling).point(4, 5));
        CHECK(a != Sampler(1, 2, 9, sampling).point(4, 5));
        CHECK(a != Sampler(1, 2, 3, sampling).point(9, 5));
        CHECK(a != Sampler(1, 2, 3, sampling).point(4, 9));
    }
}

TEST_CASE("Sampler: scrambles are unbiased and independent", "[statistical]") {
    constexpr int kScrambles = 20000;
    double sum = 0, squares = 0, lagged = 0, previous = 0;
    for (int r = 0; r < kScrambles; ++r) {
        double mean = 0;
        const Sampler sampler(11, static_cast<std::uint64_t>(r / 8),
                              static_cast<std::uint32_t>(r % 8));
        for (std::uint32_t i = 0; i < 16; ++i) mean += product(sampler.point(i, 1)) / 16;
        sum += mean - 1;
        squares += (mean - 1) * (mean - 1);
        lagged += (mean - 1) * previous;
        previous = mean - 1;
    }
    const double sigma = std::sqrt(squares / kScrambles);
    // |z| < 4 each: false alarms 1.3e-4.
    CHECK(std::abs(sum / kScrambles) < 4 * sigma / std::sqrt(kScrambles));
    CHECK(std::abs(lagged / squares) < 4 / std::sqrt(kScrambles));
    // Better than 16 random points, whose variance is (1.0833^8 − 1)/16.
    CHECK(squares / kScrambles < 0.5 * kProductVariance / 16);
}

TEST_CASE("Independent numbers: even, each and in pairs of neighbours of every kind",
          "[statistical]") {
    // Each neighbour (x, y) of 4096 numbers falls into one of 16 x 16 boxes as often as into any
    // other: x and y are uniform and know nothing of each other.
    struct Place {
        std::uint64_t seed, pixel;
        std::uint32_t replicate, sample, block;
    };
    const auto at = [](const Place& p) {
        return Sampler(p.seed, p.pixel, p.replicate, Sampling::kIndependent)
            .point(p.sample, p.block);
    };
    const std::vector<Place> steps{{0, 0, 0, 1, 0}, {0, 0, 0, 0, 1}, {0, 0, 0, 0, 1u << 20},
                                   {0, 0, 1, 0, 0}, {0, 1, 0, 0, 0}, {1, 0, 0, 0, 0}};
    constexpr std::uint32_t kCount = 1u << 14;
    const std::vector<double> expected(256, kCount / 256.0);
    const auto box = [](double x, double y) {
        return static_cast<std::size_t>(x * 16) * 16 + static_cast<std::size_t>(y * 16);
    };
    // z < 4.5 at 56 places: false alarms 2e-4.
    for (const Place& step : steps)
        for (std::size_t d = 0; d < kBlockDimensions; ++d) {
            std::vector<double> counts(256, 0), in_point(256, 0);
            for (std::uint32_t i = 0; i < kCount; ++i) {
                const Place here{5, 8, 2, 2 * i, 0};  // every other sample: each is in one pair
                const SamplePoint u = at(here);
                const SamplePoint v = at({here.seed + step.seed, here.pixel + step.pixel,
                                          here.replicate + step.replicate,
                                          here.sample + step.sample, here.block + step.block});
                ++counts[box(u[d], v[d])];
                ++in_point[box(u[d], u[(d + 1) % kBlockDimensions])];
            }
            CHECK(chi2_z(counts, expected) < 4.5);
            if (&step == &steps.front()) CHECK(chi2_z(in_point, expected) < 4.5);
        }
}

TEST_CASE("Independent numbers: the variance of a mean of N is 1/N of one's", "[statistical]") {
    for (std::uint32_t count : {1u, 16u, 256u}) {
        constexpr int kMeans = 4000;
        double sum = 0, squares = 0, fourth = 0;
        for (int r = 0; r < kMeans; ++r) {
            const Sampler sampler(11, static_cast<std::uint64_t>(r), 0, Sampling::kIndependent);
            double mean = 0;
            for (std::uint32_t i = 0; i < count; ++i) mean += product(sampler.point(i, 1)) / count;
            sum += mean - 1;
            squares += std::pow(mean - 1, 2);
            fourth += std::pow(mean - 1, 4);
        }
        const double variance = squares / kMeans;
        // |z| < 4 each: false alarms 6e-5 a check.
        CHECK(std::abs(sum / kMeans) < 4 * std::sqrt(kProductVariance / count / kMeans));
        CHECK(std::abs(variance - kProductVariance / count) <
              4 * std::sqrt((fourth / kMeans - variance * variance) / kMeans));
    }
}

TEST_CASE(
    "Sampler: the error of a smooth integral falls far faster than random, over two blocks too",
    "[statistical]") {
    const auto rms = [](std::uint32_t count, std::size_t d, std::uint32_t block, std::size_t e) {
        double squares = 0;
        for (std::uint32_t r = 0; r < 64; ++r) {
            const Sampler sampler(3, 17, r);
            double mean = 0;
            for (std::uint32_t i = 0; i < count; ++i) {
                const double u = sampler.point(i, 0)[d], v = sampler.point(i, block)[e];
                mean += std::exp(u * v) / count;
            }
            squares += std::pow(mean - 1.3179021514544038, 2) / 64;  // Ei(1) − γ
        }
        return std::sqrt(squares);
    };
    // 64 times the points: 64 times smaller at the rate 1/N, 512 at Owen's N^{-3/2}; 8 if the two
    // numbers knew nothing of each other. High dimensions come to their rate late.
    CHECK(rms(4096, 0, 0, 1) < rms(64, 0, 0, 1) / 100);
    CHECK(rms(4096, 2, 1, 1) < rms(64, 2, 1, 1) / 24);
    CHECK(rms(4096, 4, 1, 3) < rms(64, 4, 1, 3) / 24);
}
