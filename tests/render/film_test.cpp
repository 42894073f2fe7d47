// film_test.cpp — means, covariances, refusals, and errors of DoLP and AoLP.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/film.h"

#include <random>

#include "support/catch.h"

using namespace malus;

namespace {

// Adds one sample of one wavelength.
bool add(PixelAccumulator& pixel, float s0, float s1, float s2, float s3) {
    const float S[4] = {s0, s1, s2, s3};
    return pixel.add(S, 1);
}

}  // namespace

TEST_CASE("Film: mean and covariance of the mean over replicates") {
    // Replicate means (1,0,0,0), (3,1,0,0), (2,2,3,0): by hand, mean (2,1,1,0), squares of the
    // deviations summed over R(R−1) = 6.
    PixelAccumulator pixel(1);
    Film film(1, 1, {550});
    pixel.start_pixel();
    const float means[3][3] = {{1, 0, 0}, {3, 1, 0}, {2, 2, 3}};
    for (const auto& m : means) {
        pixel.start_replicate();
        add(pixel, m[0] - 0.5f, m[1], m[2], 0);
        add(pixel, m[0] + 0.5f, m[1], m[2], 0);
        pixel.end_replicate();
    }
    pixel.develop(film, 0);
    const PixelStokes& p = film.at(0, 0);
    CHECK(p.mean.s0 == Approx(2));
    CHECK(p.mean.s1 == Approx(1));
    CHECK(p.mean.s2 == Approx(1));
    CHECK(p.covariance[0] == Approx(2.0 / 6));      // 00: 1 + 1 + 0
    CHECK(p.covariance[1] == Approx(1.0 / 6));      // 01: (−1)(−1) + 1·0 + 0·1
    CHECK(p.covariance[2] == near(0.0 / 6, 1e-9));  // 02: (−1)(−1) + 1(−1) + 0
    CHECK(p.covariance[3] == Approx(2.0 / 6));      // 11
    CHECK(p.covariance[4] == Approx(3.0 / 6));      // 12: 1 + 0 + 1·2
    CHECK(p.covariance[5] == Approx(6.0 / 6));      // 22: 1 + 1 + 4
    CHECK(film.samples[0] == 6);
}

TEST_CASE("Film: samples that are not finite or negative are refused and leave no trace") {
    PixelAccumulator pixel(1);
    pixel.start_pixel();
    pixel.start_replicate();
    CHECK(add(pixel, 1, 0.5f, 0, 0));
    CHECK_FALSE(add(pixel, NAN, 0, 0, 0));
    CHECK_FALSE(add(pixel, 1, INFINITY, 0, 0));
    CHECK_FALSE(add(pixel, 1, 0, 0, -NAN));
    CHECK_FALSE(add(pixel, -1e-6f, 0, 0, 0));
    CHECK(add(pixel, 3, 0.5f, 0, 0));
    pixel.end_replicate();
    pixel.start_replicate();
    CHECK_FALSE(add(pixel, NAN, 0, 0, 0));
    pixel.end_replicate();  // nothing kept: takes no part
    Film film(1, 1, {550});
    pixel.develop(film, 0);
    CHECK(film.at(0, 0).mean.s0 == Approx(2));
    CHECK(film.at(0, 0).mean.s1 == Approx(0.5));
    CHECK(film.samples[0] == 2);
}

TEST_CASE("Film: rounding never makes light more than fully polarized, and hides nothing larger") {
    // DoP = 1 in float components, whose norms round to either side of S0, at all brightnesses.
    PixelAccumulator pixel(1);
    Film film(1, 1, {550});
    const auto developed = [&](float s0, float s1, float s2, float s3) {
        pixel.start_pixel();
        for (int r = 0; r < 8; ++r) {
            pixel.start_replicate();
            REQUIRE(add(pixel, s0, s1, s2, s3));
            pixel.end_replicate();
        }
        pixel.develop(film, 0);
        return film.at(0, 0).mean;
    };
    std::mt19937_64 engine(11);
    std::normal_distribution<double> normal;
    int over = 0;
    for (int i = 0; i < 2000; ++i) {
        const double x = normal(engine), y = normal(engine), z = normal(engine);
        const double s0 = std::exp(20 * normal(engine)), r = s0 / std::hypot(x, y, z);
        const auto f = [](double v) { return static_cast<float>(v); };
        over += std::hypot(double{f(r * x)}, double{f(r * y)}, double{f(r * z)}) > double{f(s0)};
        const Stokes<double> S = developed(f(s0), f(r * x), f(r * y), f(r * z));
        REQUIRE(std::hypot(S.s1, S.s2, S.s3) <= S.s0);
        REQUIRE(std::hypot(double{f(S.s1)}, double{f(S.s2)}, double{f(S.s3)}) <= double{f(S.s0)});
        REQUIRE(dop(S) == near(1, 1e-6));
    }
    CHECK(over > 500);
    // A thousandth too much is a fault upstream: it stays.
    CHECK(dop(developed(1, 1.001f, 0, 0)) == Approx(1.001));
}

TEST_CASE("Film: the id of a pixel is what most of its samples met") {
    PixelAccumulator pixel(1);
    Film film(1, 1, {550});
    pixel.start_pixel();
    pixel.start_replicate();
    for (int i = 0; i < 3; ++i) {
        add(pixel, 1, 0, 0, 0);
        pixel.add_surface(7, 2);
        add(pixel, 1, 0, 0, 0);
        pixel.add_surface(3, 4);
        add(pixel, 1, 0, 0, 0);
        pixel.add_surface(7, 3);
        add(pixel, 1, 0, 0, 0);
        if (i == 0)
            pixel.add_sky();
        else
            pixel.add_surface(7, 3);
    }
    pixel.end_replicate();
    pixel.develop(film, 0);
    CHECK(film.instance[0] == 7);
    CHECK(film.coverage[0] == Approx(11.0 / 12));
    CHECK(film.distance[0] == Approx((3 * (2 + 4 + 3) + 2 * 3) / 11.0));
}

TEST_CASE("Error bars: DoLP and AoLP spread as their formulas say", "[statistical]") {
    // Correlated Gaussian noise on (S0, S1, S2), made by a mixing matrix; the spread of the drawn
    // DoLP and AoLP is what the formulas must give. 200 000 draws know it to 0.2 %.
    const Stokes<double> S{1.0, 0.15, -0.25, 0};
    const double mix[3][3] = {{0.010, 0, 0}, {0.004, 0.006, 0}, {-0.003, 0.002, 0.008}};
    PixelStokes pixel{S, {}};
    const auto covariance = [&](int i, int j) {
        double sum = 0;
        for (int k = 0; k < 3; ++k) sum += mix[i][k] * mix[j][k];
        return static_cast<float>(sum);
    };
    pixel.covariance = {covariance(0, 0),
                        covariance(0, 1),
                        covariance(0, 2),
                        covariance(1, 1),
                        covariance(1, 2),
                        covariance(2, 2),
                        0};
    std::mt19937_64 engine(4);
    std::normal_distribution<double> normal;
    double p1 = 0, p2 = 0, a1 = 0, a2 = 0;
    constexpr int kDraws = 200000;
    for (int i = 0; i < kDraws; ++i) {
        double e[3] = {normal(engine), normal(engine), normal(engine)}, d[3] = {0, 0, 0};
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) d[r] += mix[r][c] * e[c];
        const Stokes<double> T{S.s0 + d[0], S.s1 + d[1], S.s2 + d[2], 0};
        p1 += dolp(T), p2 += sqr(dolp(T)), a1 += aolp(T), a2 += sqr(aolp(T));
    }
    const double p_spread = std::sqrt(p2 / kDraws - sqr(p1 / kDraws));
    const double a_spread = std::sqrt(a2 / kDraws - sqr(a1 / kDraws));
    // First-order propagation is itself good to (0.01/0.29)² ≈ 0.1 %.
    CHECK(stderr_dolp(pixel) == Approx(p_spread).epsilon(0.01));
    CHECK(stderr_aolp(pixel) == Approx(a_spread).epsilon(0.01));
}

TEST_CASE("Error bars: limits at no light and no polarization") {
    PixelStokes pixel;
    CHECK(stderr_dolp(pixel) == 0);
    CHECK(stderr_aolp(pixel) == Approx(kPi / 2));
    pixel.mean.s0 = 2;
    pixel.covariance = {0, 0, 0, 0.04f, 0, 0.01f, 0};
    CHECK(stderr_dolp(pixel) == Approx(0.1));
    // p = 0.25 is 2.5 of its errors (0.1): the axis may point anywhere; p = 0.35 is 3.5.
    pixel.mean.s1 = 0.5;
    CHECK(stderr_aolp(pixel) == Approx(kPi / 2));
    pixel.mean.s1 = 0.7;
    CHECK(stderr_aolp(pixel) == Approx(0.1 / (2 * 0.7)));
    pixel.mean.s1 = 0;
    CHECK(stderr_aolp(pixel) == Approx(kPi / 2));
}

TEST_CASE("Error bars: light from one replicate alone is not known, however alike its numbers") {
    // Replicates (8,4,0,0), 0, …: DoLP 0.5 in the only one that has light.
    PixelAccumulator pixel(1);
    Film film(1, 1, {550});
    pixel.start_pixel();
    for (int r = 0; r < 8; ++r) {
        pixel.start_replicate();
        add(pixel, r == 0 ? 8.f : 0.f, r == 0 ? 4.f : 0.f, 0, 0);
        pixel.end_replicate();
    }
    pixel.develop(film, 0);
    CHECK(dolp(film.at(0, 0).mean) == Approx(0.5));
    CHECK(stderr_dolp(film.at(0, 0)) == 1);
    CHECK(stderr_aolp(film.at(0, 0)) == Approx(kPi / 2));
}

TEST_CASE("Error bars: few replicates that carry the light widen them by Kish's number") {
    // Four of eight replicates carry all light. By hand: S0_r = 2 or 0, mean 1, Σ(±1)² = 8,
    // C00 = 8/56 = 1/7; m = 8/(1 + 7/7) = 4; widening √(7/8 · 4/3) = 1.0801.
    PixelStokes pixel{{1, 0.5, 0, 0}, {1.f / 7, 0, 0, 0, 0, 0.01f, 0}};
    CHECK(stderr_dolp(pixel) == Approx(std::sqrt(7.0 / 6) * 0.5 * std::sqrt(1.0 / 7)));
    // With S1 = S0/2 in each replicate (C01 = C00/2, C11 = C00/4) DoLP is sharp, and AoLP known.
    pixel.covariance = {1.f / 7, 1.f / 14, 0, 1.f / 28, 0, 0.01f, 0};
    CHECK(stderr_aolp(pixel) == Approx(std::sqrt(7.0 / 6) * 0.1 / (2 * 0.5)));
}
