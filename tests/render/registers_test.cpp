// registers_test.cpp — what the path loop computes in registers, against the C library's doubles.
// SPDX-License-Identifier: Apache-2.0
#include "render/gaussian.h"
#include "render/lanes.h"
#include "render/points.h"
#include "render/sky_lights.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/statistics.h"

using namespace malus;

namespace {

Reals of(const std::array<double, kSide>& x) {
    return lanewise<Reals>([&](std::size_t i) { return x[i]; });
}

}  // namespace

TEST_CASE("Registers: erfc and the Gaussian to 4e-11 of themselves") {
    for (double x = -9; x < 9; x += 0.01) {
        const GaussTail<double> tail = gauss_tail(x);
        CHECK(tail.erfc == Approx(std::erfc(x)).epsilon(4e-11));
        CHECK(tail.gauss == Approx(std::exp(-x * x) / std::sqrt(kPi)).epsilon(1e-14));
    }
}

TEST_CASE("Registers: slopes follow the normal distribution") {
    for (double u = 1e-6; u < 1; u += 1e-3) {
        CHECK(0.5 * std::erfc(-gaussian_slope(u)) == near(u, 1e-6 * std::min(u, 1 - u)));
        CHECK(lane(gaussian_slope(Reals(u)), kSide - 1) == Approx(gaussian_slope(u)).margin(1e-9));
    }
}

TEST_CASE("Registers: angles in all quadrants are atan2's to 1e-12") {
    Uniform u(5);
    for (int i = 0; i < 2000; ++i) {
        std::array<double, kSide> y, x;
        for (std::size_t l = 0; l < kSide; ++l) {
            const double size = std::exp(40 * (u() - 0.5));
            y[l] = size * (u() - 0.5), x[l] = (i % 3 == 0 ? 1e-8 : 1) * size * (u() - 0.5);
        }
        const auto angle = stored(angle_of(of(y), of(x)));
        for (std::size_t l = 0; l < kSide; ++l)
            CHECK(angle[l] == near(std::atan2(y[l], x[l]), 1e-12));
    }
    for (double zero : {0.0, -0.0}) CHECK(lane(angle_of(Reals(zero), Reals(0.0)), 0) == 0);
}

TEST_CASE("Registers: exponentials, logarithms, roots and circles to 1e-6 of a double's") {
    Uniform u(6);
    for (int i = 0; i < 2000; ++i) {
        const double x = 80 * u(), y = 1 - u();
        CHECK(static_cast<double>(lane(exp(Lanes(static_cast<float>(-x))), 0)) ==
              Approx(std::exp(-static_cast<double>(static_cast<float>(x)))).epsilon(1e-6));
        CHECK(static_cast<double>(lane(sqrt(Lanes(static_cast<float>(x))), 0)) ==
              Approx(std::sqrt(x)).epsilon(1e-6));
        CHECK(lane(exp(Reals(-x)), 0) == Approx(std::exp(-x)).epsilon(1e-14));
        CHECK(lane(log(Reals(y)), 0) == Approx(std::log(y)).epsilon(1e-14));
        const CosSin<Reals> circle = cos_sin(Reals(2 * kPi * y));
        CHECK(lane(circle.cos, 0) == near(std::cos(2 * kPi * y), 1e-14));
        CHECK(lane(circle.sin, 0) == near(std::sin(2 * kPi * y), 1e-14));
    }
}

TEST_CASE("Registers: inverses, and what decays, to 3e-7 of a double's, or 1e-15") {
    Uniform u(7);
    for (int i = 0; i < 2000; ++i) {
        // 1e-17 to 1e17: squares of cosines beside 90 degrees, fourth powers of indices to 1000.
        const double x = std::exp(80 * (u() - 0.5)), fall = -86 * u();
        const auto as_float = static_cast<float>(x), fall_as_float = static_cast<float>(fall);
        const auto one_lane = [](const Lanes& of) { return static_cast<double>(lane(of, 3)); };
        CHECK(one_lane(inverse(Lanes(as_float))) == Approx(1.0 / double{as_float}).epsilon(3e-7));
        CHECK(one_lane(inverse_sqrt(Lanes(as_float))) ==
              Approx(1 / std::sqrt(double{as_float})).epsilon(3e-7));
        CHECK(one_lane(decay(Lanes(fall_as_float))) ==
              Approx(std::exp(double{fall_as_float})).epsilon(3e-7));
        CHECK(lane(decay(Reals(8 * fall)), 1) == Approx(std::exp(8 * fall)).epsilon(1e-15));
    }
    CHECK(lane(decay(Lanes(0.f)), 0) == 1);
    CHECK(lane(decay(Reals(-HUGE_VAL)), 0) == 0);
    std::array<double, kSide> some;
    for (std::size_t i = 0; i < kSide; ++i) some[i] = std::pow(2.0, static_cast<double>(i));
    CHECK(total(of(some)) == std::pow(2.0, static_cast<double>(kSide)) - 1);
}

TEST_CASE("Registers: transposing, masks and both wavelengths") {
    std::array<Lanes, kSide> rows;
    for (std::size_t i = 0; i < kSide; ++i)
        rows[i] = lanewise<Lanes>([&](std::size_t j) {
            return 100.f * static_cast<float>(i + 1) + static_cast<float>(j);
        });
    std::array<float, 2 * kSide * kSide> columns;
    transpose(rows, columns.data());
    for (std::size_t i = 0; i < kSide; ++i)
        for (std::size_t j = 0; j < 2 * kSide; ++j)
            CHECK(columns[j * kSide + i] ==
                  100.f * static_cast<float>(i + 1) + static_cast<float>(j));
    for (unsigned set = 0; set <= kAllLanes; set += 3) {
        CHECK(bits(mask_of(set)) == set);
        const auto picked = stored(select(lanes_mask_of(set), Lanes(1.f), Lanes(0.f)));
        for (std::size_t i = 0; i < 2 * kSide; ++i)
            CHECK(picked[i] == (set >> (i % kSide) & 1 ? 1.f : 0.f));
    }
    const Reals x = lanewise<Reals>([](std::size_t i) { return 0.5 + static_cast<double>(i); });
    const auto twice = stored(real<Lanes>(x));
    for (std::size_t i = 0; i < 2 * kSide; ++i)
        CHECK(twice[i] == 0.5f + static_cast<float>(i % kSide));
}

TEST_CASE("Registers: points are those of each lane's own sampler") {
    for (Sampling sampling : {Sampling::kSobol, Sampling::kIndependent})
        for (std::uint32_t block : {0u, 1u, 5u}) {
            std::array<Scramble, kSide> own;
            PointPlaces places;
            for (std::size_t i = 0; i < kSide; ++i) {
                own[i] = Sampler(3, 7, static_cast<std::uint32_t>(i % 3), sampling).scramble(block);
                places.scramble[i] = &own[i];
                places.sample[i] = static_cast<std::uint32_t>(11 + i / 2);
            }
            const auto first = points<0, 5>(places);
            const auto last = points<5, 2>(places);
            for (std::size_t i = 0; i < kSide; ++i) {
                const SamplePoint expected = own[i].point(places.sample[i]);
                for (std::size_t d = 0; d < 5; ++d) CHECK(lane(first[d], i) == expected[d]);
                for (std::size_t d = 0; d < 2; ++d) CHECK(lane(last[d], i) == expected[5 + d]);
            }
        }
}

TEST_CASE("Registers: the sky is drawn and located as one direction by itself is") {
    // Of a grid, and of the map itself beside a sharp surface; one direction in four below the horizon.
    const Sky map = sample_sky(smooth_sky(37), {550}, 12, 24);
    const std::vector<double> nm{550};
    for (double slope : {0.3, 1e-3}) {
        const SkyEmitter sky(map, nm, slope);
        Uniform u(9);
        for (int n = 0; n < 500; ++n) {
            const Reals a = lanewise<Reals>([&](std::size_t) { return u(); });
            const Reals b = lanewise<Reals>([&](std::size_t) { return u(); });
            SkyLookups drawn_at, found_at;
            const SkySamples drawn = sample_sky(sky, sky.density(), a, b, drawn_at);
            const Vec3s w = vectors([&](std::size_t i) {
                const double y = 1 - 4.0 / 3 * lane(a, i), r = std::sqrt(1 - y * y);
                return Vec3{r * std::cos(7 * lane(b, i)), y, r * std::sin(7 * lane(b, i))};
            });
            const Reals found = locate(sky, sky.density(), w, kAllLanes, found_at);
            for (std::size_t i = 0; i < kSide; ++i) {
                const LightSample one = sky.sample(lane(a, i), lane(b, i));
                CHECK(length(stored(drawn.w)[i] - one.w) < 1e-12);
                CHECK(lane(drawn.pdf, i) == one.light.pdf);
                const LightLookup there = sky.locate(stored(w)[i]);
                CHECK(lane(found, i) == there.pdf);
                CHECK(light_at(sky, found_at[i], 0).s1 ==
                      near(light_at(sky, there.at, 0).s1, 1e-6));
                CHECK(light_at(sky, drawn_at[i], 0).s2 ==
                      near(light_at(sky, one.light.at, 0).s2, 1e-6));
            }
        }
    }
}
