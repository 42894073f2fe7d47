// film_test.cpp — means, covariances, refusals, and errors of DoLP and AoLP.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/film.h"

#include <random>

#include "malus/render/render.h"

#include "support/catch.h"

using namespace malus;

namespace {

// One pixel at one wavelength.
struct OnePixel {
    Exposure exposure;
    PixelExposure pixel;
    Film film{1, 1, {550}};

    explicit OnePixel(std::uint32_t replicates)
        : exposure(1, 1, {550}, replicates), pixel(exposure) {}
    bool add(std::uint32_t replicate, float s0, float s1, float s2, float s3) {
        const float S[4] = {s0, s1, s2, s3};
        return pixel.add(replicate, S, 1);
    }
    const PixelStokes& develop() {
        pixel.develop(film, 0);
        return film.at(0, 0);
    }
};

}  // namespace

TEST_CASE("Film: mean and covariance of the mean over replicates") {
    // Replicate means (1,0,0,0), (3,1,0,0), (2,2,3,0): by hand, mean (2,1,1,0), squares of the
    // deviations summed over R(R−1) = 6.
    OnePixel one(3);
    const float means[3][3] = {{1, 0, 0}, {3, 1, 0}, {2, 2, 3}};
    for (float off : {-0.5f, 0.5f}) {
        for (std::uint32_t r = 0; r < 3; ++r)
            one.add(r, means[r][0] + off, means[r][1], means[r][2], 0);
        one.pixel.end_sample();
    }
    const PixelStokes& p = one.develop();
    CHECK(p.mean.s0 == Approx(2));
    CHECK(p.mean.s1 == Approx(1));
    CHECK(p.mean.s2 == Approx(1));
    CHECK(p.covariance[0] == Approx(2.0 / 6));      // 00: 1 + 1 + 0
    CHECK(p.covariance[1] == Approx(1.0 / 6));      // 01: (−1)(−1) + 1·0 + 0·1
    CHECK(p.covariance[2] == near(0.0 / 6, 1e-9));  // 02: (−1)(−1) + 1(−1) + 0
    CHECK(p.covariance[3] == Approx(2.0 / 6));      // 11
    CHECK(p.covariance[4] == Approx(3.0 / 6));      // 12: 1 + 0 + 1·2
    CHECK(p.covariance[5] == Approx(6.0 / 6));      // 22: 1 + 1 + 4
    CHECK(p.replicates == 3);
    CHECK(one.film.samples[0] == 6);
}

TEST_CASE("Film: what the sky table may be off by is in the variances where it is used") {
    // Replicates that agree: all error is the table's, 1e-3 of S0, but of S1 and S2 no more than 100 times
    // that of what they are together. By hand: S0 2, hypot(S1, S2) 0.005 and 0.5.
    for (const float s2 : {0.004f, 0.4f})
        for (const bool used : {true, false}) {
            OnePixel one(2);
            for (std::uint32_t r = 0; r < 2; ++r) one.add(r, 2, 0.75f * s2, s2, 0);
            if (used) one.pixel.set_open(1, 0, 1);
            one.pixel.end_sample();
            one.pixel.develop(one.film, 0, 1e-3);
            const PixelStokes& p = one.film.at(0, 0);
            const double linear = s2 < 0.1f ? 100 * 0.005 : 2;
            CAPTURE(s2, used);
            CHECK(p.covariance[0] == near(used ? 4e-6 : 0, 1e-12));
            CHECK(p.covariance[3] == near(used ? 1e-6 * linear * linear : 0, 1e-12));
            CHECK(p.covariance[5] == near(used ? 1e-6 * linear * linear : 0, 1e-12));
            for (std::size_t e : {1u, 2u, 4u, 6u}) CHECK(p.covariance[e] == 0);
        }
}

TEST_CASE("Film: samples that are not finite or negative are refused and leave no trace") {
    OnePixel one(2);
    CHECK(one.add(0, 1, 0.5f, 0, 0));
    CHECK_FALSE(one.add(0, NAN, 0, 0, 0));
    CHECK_FALSE(one.add(0, 1, INFINITY, 0, 0));
    CHECK_FALSE(one.add(0, 1, 0, 0, -NAN));
    CHECK_FALSE(one.add(0, -1e-6f, 0, 0, 0));
    CHECK_FALSE(one.add(0, 3e38f, 0, 0, 0));  // two of them would overflow
    CHECK(one.add(0, 3, 0.5f, 0, 0));
    CHECK_FALSE(one.add(1, NAN, 0, 0, 0));  // nothing kept: takes no part
    CHECK(one.develop().mean.s0 == Approx(2));
    CHECK(one.film.at(0, 0).mean.s1 == Approx(0.5));
    CHECK(one.film.at(0, 0).replicates == 1);
    CHECK(one.film.samples[0] == 2);
}

TEST_CASE("Film: a sample of all replicates is taken or left as each by itself would be") {
    for (float spoiled : {NAN, -NAN, INFINITY, -1e-6f, 3e38f, -1e-40f})
        for (std::size_t where : {0u, 1u}) {
            OnePixel one(2);
            float S[8] = {1, 2, 0.5f, -0.5f, 0, 0, 0, 0};  // [S0..S3][replicate]
            CHECK(one.pixel.add_all(S));
            S[where] = spoiled;
            CHECK_FALSE(one.pixel.add_all(S));
            CHECK_FALSE(one.add(static_cast<std::uint32_t>(where), spoiled, 0, 0, 0));
            S[where] = -0.f;
            S[2 + where] = 0;
            CHECK(one.pixel.add_all(S));
            CHECK(one.develop().mean.s0 == Approx(0.5 * (where == 0 ? 0.5 + 2 : 1 + 1)));
            CHECK(one.film.samples[0] == 4);
        }
}

TEST_CASE("Film: rounding never makes light more than fully polarized, and hides nothing larger") {
    // DoP = 1 in float components, whose norms round to either side of S0, at all brightnesses.
    const auto developed = [](float s0, float s1, float s2, float s3) {
        OnePixel one(8);
        for (std::uint32_t r = 0; r < 8; ++r) REQUIRE(one.add(r, s0, s1, s2, s3));
        return one.develop().mean;
    };
    std::mt19937_64 engine(11);
    std::normal_distribution<double> normal;
    int over = 0;
    for (int i = 0; i < 2000; ++i) {
        const double x = normal(engine), y = normal(engine), z = normal(engine);
        const double s0 = std::exp(15 * normal(engine)), r = s0 / std::hypot(x, y, z);
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
    OnePixel one(4);
    for (int i = 0; i < 3; ++i) {
        one.pixel.add_surface(7, 2);
        one.pixel.add_surface(3, 4);
        one.pixel.add_surface(7, 3);
        if (i == 0)
            one.pixel.add_sky();
        else
            one.pixel.add_surface(7, 3);
        for (std::uint32_t r = 0; r < 4; ++r) one.add(r, 1, 0, 0, 0);
        one.pixel.end_sample();
    }
    one.develop();
    CHECK(one.film.instance[0] == 7);
    CHECK(one.film.coverage[0] == Approx(11.0 / 12));
    CHECK(one.film.distance[0] == Approx((3 * (2 + 4 + 3) + 2 * 3) / 11.0));
}

TEST_CASE("Exposure: checkpoints are each sample up to 64, then 32 in a doubling") {
    for (std::uint32_t n = 0; n <= 64; ++n) CHECK(checkpoint(n) == n);
    CHECK(checkpoint(65) == 66);
    CHECK(checkpoint(127) == 128);
    CHECK(checkpoint(129) == 132);
    CHECK(checkpoint(1025) == 1056);
    CHECK(checkpoint((1u << 20) + 1) == (1u << 20) + (1u << 15));
    CHECK(whole_spp(1) == 8);
    CHECK(whole_spp(1000) == 1008);  // 125 of each replicate, 126 with 8 of them
    CHECK(whole_spp(100, 32) == 128);
}

TEST_CASE("Exposure: the sums of a million samples are good to 2e-6") {
    // A constant whose roundings all go one way, and numbers that spread; sums of doubles beside.
    OnePixel one(2);
    std::mt19937_64 engine(3);
    std::exponential_distribution<double> spread;
    double sum = 0;
    constexpr std::uint32_t kSamples = 1u << 20;
    for (std::uint32_t n = 0; n < kSamples; ++n) {
        const auto x = static_cast<float>(spread(engine));
        sum += static_cast<double>(x);
        one.add(0, 1.1f, 0, 0, 0);
        one.add(1, x, 0, 0, 0);
        one.pixel.end_sample();
    }
    one.pixel.store(one.exposure, 0);
    CHECK(double{one.exposure.stokes[0]} / kSamples == Approx(double{1.1f}).epsilon(2e-6));
    CHECK(double{one.exposure.stokes[1]} == Approx(sum).epsilon(2e-6));
}

TEST_CASE("Exposure: a pixel that is put away at any checkpoint goes on as if it had not been") {
    std::mt19937_64 engine(8);
    std::exponential_distribution<float> spread;
    OnePixel whole(2), paused(2);
    for (std::uint32_t n = 0; n < 1000; ++n) {
        for (std::uint32_t r = 0; r < 2; ++r) {
            const float x = spread(engine), y = spread(engine);
            whole.add(r, x + y, x, y, 0);
            paused.add(r, x + y, x, y, 0);
            if (x > y) {
                whole.pixel.add_surface(static_cast<int>(3 * x), double{y});
                paused.pixel.add_surface(static_cast<int>(3 * x), double{y});
            }
        }
        whole.pixel.end_sample();
        paused.pixel.end_sample();
        if (paused.pixel.taken() != checkpoint(paused.pixel.taken())) continue;
        paused.pixel.store(paused.exposure, 0);
        paused.pixel = PixelExposure(paused.exposure);
        paused.pixel.load(paused.exposure, 0);
    }
    const PixelStokes &a = whole.develop(), &b = paused.develop();
    CHECK(a.mean.s0 == b.mean.s0);
    CHECK(a.mean.s2 == b.mean.s2);
    CHECK(a.covariance == b.covariance);
    CHECK(whole.film.distance == paused.film.distance);
    CHECK(whole.film.instance == paused.film.instance);
    CHECK(whole.film.coverage == paused.film.coverage);
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

TEST_CASE("Error bars: light so faint that floats lose its covariance is not known") {
    // Of 1e-24 with a spread of a tenth the variance is 1e-50; the least float is 1.4e-45.
    for (const auto& [s0, known] : {std::pair(1e-17, true), {1e-19, false}, {1e-24, false}}) {
        PixelStokes pixel;
        pixel.mean = {s0, 0.3 * s0, 0.4 * s0, 0};
        for (std::size_t i : {0u, 3u, 5u}) pixel.covariance[i] = static_cast<float>(1e-4 * s0 * s0);
        CAPTURE(s0);
        CHECK((stderr_dolp(pixel) < 0.1) == known);
        CHECK((stderr_aolp(pixel) < 0.1) == known);
        if (!known) {
            CHECK(stderr_dolp(pixel) == 1);
            CHECK(stderr_aolp(pixel) == near(kPi / 2, 1e-12));
        }
    }
}

TEST_CASE("Error bars: light from one replicate alone is not known, however alike its numbers") {
    // Replicates (8,4,0,0), 0, …: DoLP 0.5 in the only one that has light.
    OnePixel one(8);
    for (std::uint32_t r = 0; r < 8; ++r) one.add(r, r == 0 ? 8.f : 0.f, r == 0 ? 4.f : 0.f, 0, 0);
    const PixelStokes& pixel = one.develop();
    CHECK(dolp(pixel.mean) == Approx(0.5));
    CHECK(stderr_dolp(pixel) == 1);
    CHECK(stderr_aolp(pixel) == Approx(kPi / 2));
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

TEST_CASE("Film: what follows from pixels side by side is what follows from each of them") {
    // 37 pixels: full registers and a rest. Among them no light, unpolarized, faint, of one replicate.
    constexpr std::size_t kPixels = 37, kWavelengths = 3, kAt = 1;
    Film film(static_cast<int>(kPixels), 1, {440, 550, 600});
    std::mt19937_64 engine(7);
    std::uniform_real_distribution<double> share(-1, 1);
    for (std::size_t i = 0; i < kPixels; ++i) {
        PixelStokes& pixel = film.stokes[i * kWavelengths + kAt];
        const double s0 = 0.1 * (1.1 + share(engine)), noise = i % 5 ? 0.01 : 0.6;
        pixel.mean = {s0, 0.5 * s0 * share(engine), 0.5 * s0 * share(engine),
                      0.1 * s0 * share(engine)};
        for (std::size_t e : {0u, 3u, 5u, 6u})
            pixel.covariance[e] = static_cast<float>(sqr(noise * s0 * (2 + share(engine))));
        for (std::size_t e : {1u, 2u, 4u})
            pixel.covariance[e] = static_cast<float>(sqr(noise * s0) * share(engine));
        pixel.replicates = i % 2 ? 8.f : 32.f;
    }
    film.stokes[3 * kWavelengths + kAt].mean = {};
    film.stokes[4 * kWavelengths + kAt] = {};
    film.stokes[5 * kWavelengths + kAt].mean = {1, 0, 0, 0};
    film.stokes[6 * kWavelengths + kAt].mean = {1e-24, 0.3e-24, -0.4e-24, 0};
    film.stokes[7 * kWavelengths + kAt].mean = {1, -0.5, -1e-18, 0};  // AoLP just below 90 degrees
    film.stokes[8 * kWavelengths + kAt].mean = {1, 0.5, -1e-18, 0};   // and just below 180
    film.stokes[36 * kWavelengths + kAt].mean = {0.5, 0.6, 0, 0};

    std::vector<std::vector<float>> numbers(kFilmQuantities, std::vector<float>(kPixels + 1, -7));
    std::vector<float*> rows;
    for (auto& row : numbers) rows.push_back(row.data());
    derive(film, kAt, 1, kPixels, rows.data());
    for (std::size_t i = 1; i < kPixels; ++i) {
        CAPTURE(i);
        const PixelStokes& pixel = film.at(i, kAt);
        const auto& C = pixel.covariance;
        const auto found = [&](FilmQuantity of) { return numbers[of][i - 1]; };
        const auto same = [](double x) { return Approx(x).epsilon(1e-6).margin(1e-37); };
        CHECK(found(kS0) == same(pixel.mean.s0));
        CHECK(found(kS1) == same(pixel.mean.s1));
        CHECK(found(kS2) == same(pixel.mean.s2));
        CHECK(found(kS3) == same(pixel.mean.s3));
        CHECK(found(kDolp) == same(std::min(1.0, dolp(pixel.mean))));
        const double axis = to_degrees(aolp(pixel.mean));
        CHECK(found(kAolp) == same(static_cast<float>(axis) < 180 ? axis : 0));
        CHECK(found(kErrorS0) == same(std::sqrt(C[0])));
        CHECK(found(kErrorS1) == same(std::sqrt(C[3])));
        CHECK(found(kErrorS2) == same(std::sqrt(C[5])));
        CHECK(found(kErrorS3) == same(std::sqrt(C[6])));
        CHECK(found(kCovS0S1) == C[1]);
        CHECK(found(kCovS0S2) == C[2]);
        CHECK(found(kCovS1S2) == C[4]);
        CHECK(found(kErrorDolp) == same(stderr_dolp(pixel)));
        CHECK(found(kErrorAolp) == same(to_degrees(stderr_aolp(pixel))));
    }
    for (const auto& row : numbers) {  // nothing beyond what was asked for
        CHECK(row[kPixels - 1] == -7);
        CHECK(row[kPixels] == -7);
    }
}

namespace {

// Mean of the raw and of the debiased DoLP over noise of deviation `sigma` in S1 and S2, S0 = 1, by
// midpoints over ±7 deviations. The estimate is written anew here.
struct Means {
    double raw = 0, debiased = 0;
};
Means expected_dolp(double p0, double sigma) {
    constexpr int kSteps = 700;
    Means sum;
    double weights = 0;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const double x = 14 * ((i + 0.5) / kSteps - 0.5), y = 14 * ((j + 0.5) / kSteps - 0.5);
            const double weight = std::exp(-(x * x + y * y) / 2);
            // No light is more than fully polarized.
            const double p = std::min(1.0, std::hypot(p0 + sigma * x, sigma * y));
            const double b2 = sigma * sigma;
            weights += weight;
            sum.raw += weight * p;
            sum.debiased += weight * (p - b2 * (1 - std::exp(-p * p / b2)) / (2 * p));
        }
    return {sum.raw / weights, sum.debiased / weights};
}

}  // namespace

TEST_CASE("Debiased DoLP: the bias that is left is the MAS formula's, at any signal to noise",
          "[statistical]") {
    // Known DoLP at an AoLP of 20°, its error p/snr (0.02 where it is 0). Mean of 4000 pixels within
    // 4.5 of its errors: false alarms 7e-6, 26 times.
    std::mt19937_64 engine(11);
    std::normal_distribution<double> normal;
    for (const auto& [p0, snr] : {std::pair{0.0, 0.0},
                                  {0.01, 1.0},
                                  {0.01, 2.0},
                                  {0.01, 3.0},
                                  {0.01, 10.0},
                                  {0.05, 1.0},
                                  {0.05, 2.0},
                                  {0.05, 3.0},
                                  {0.05, 10.0},
                                  {0.3, 1.0},
                                  {0.3, 2.0},
                                  {0.3, 3.0},
                                  {0.3, 10.0}}) {
        const double sigma = p0 > 0 ? p0 / snr : 0.02;
        const double q = std::cos(to_radians(40)), u = std::sin(to_radians(40));
        double raw = 0, debiased = 0, squares = 0;
        constexpr int kPixels = 4000;
        for (int i = 0; i < kPixels; ++i) {
            PixelStokes pixel;
            pixel.mean = {2, 2 * (p0 * q + sigma * normal(engine)),
                          2 * (p0 * u + sigma * normal(engine)), 0};
            pixel.covariance[3] = pixel.covariance[5] = static_cast<float>(4 * sigma * sigma);
            raw += std::min(1.0, dolp(pixel.mean)) / kPixels;
            debiased += debiased_dolp(pixel) / kPixels;
            squares += sqr(debiased_dolp(pixel)) / kPixels;
        }
        const double error = std::sqrt((squares - debiased * debiased) / kPixels);
        const Means expected = expected_dolp(p0, sigma);
        CAPTURE(p0, snr, raw, debiased, error);
        CHECK(std::abs(debiased - expected.debiased) < 4.5 * error);
        CHECK(std::abs(raw - expected.raw) < 4.5 * error);
        // What it is for: from 3 errors on a tenth of the raw bias is left, and less.
        if (snr >= 3)
            CHECK(std::abs(expected.debiased - p0) < 0.1 * (expected.raw - p0));
        else
            CHECK(expected.debiased - p0 < expected.raw - p0);
    }
}

TEST_CASE("Debiased DoLP: error ellipses of any shape, no error, no light") {
    PixelStokes pixel;
    pixel.mean = {2, 0, 0.4, 0};
    // Only noise across the polarization adds to DoLP: here C11.
    pixel.covariance[3] = 0.04f, pixel.covariance[5] = 9;
    const double b2 = 0.01, p = 0.2;
    CHECK(debiased_dolp(pixel) == Approx(p - b2 * (1 - std::exp(-p * p / b2)) / (2 * p)));
    // At 45° between the axes C12 counts: b² = (C11 + C22 − 2 C12)/2/S0².
    pixel.mean = {1, 0.3, 0.3, 0};
    pixel.covariance = {0, 0, 0, 0.02f, 0.01f, 0.03f, 0};
    const double P = std::hypot(0.3, 0.3);
    CHECK(debiased_dolp(pixel) == Approx(P - 0.015 * (1 - std::exp(-P * P / 0.015)) / (2 * P)));
    pixel.covariance = {};
    CHECK(debiased_dolp(pixel) == Approx(P));
    pixel.mean = {};
    CHECK(debiased_dolp(pixel) == 0);
}
