// sky_emitter_test.cpp — the sky on an equal-area grid: as much light, drawn by its brightness.
// SPDX-License-Identifier: Apache-2.0
#include "scene/sky_emitter.h"

#include <limits>

#include "malus/core/frame.h"
#include "malus/scene/clear_sky.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/statistics.h"

using namespace malus;

namespace {

const std::vector<double> kOne{550};
constexpr double kNoFacets = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("Equal area: the square holds the dome, each part its own solid angle") {
    // There and back, at the middle, the edges and across the diagonals, where the map has creases.
    for (double x : {0.0, 0.1, 0.25, 0.4999, 0.5, 0.7, 1.0})
        for (double y : {0.0, 0.2, 0.25, 0.5, 0.75, 1.0}) {
            const SquarePoint back = to_square(from_square({x, y}));
            CHECK(back.x == near(x, 1e-14));
            CHECK(back.y == near(y, 1e-14));
        }
    CHECK(from_square({0.5, 0.5}).t == 0);
    for (double edge : {0.0, 0.3, 1.0}) CHECK(from_square({edge, 1}).t == 1);
    // The solid angle of a small part, by its tangents: 2π everywhere.
    for (double x : {0.13, 0.52, 0.9})
        for (double y : {0.07, 0.44, 0.81}) {
            const double d = 1e-5;
            const auto at = [](double px, double py) {
                return direction_of(from_square({px, py}), 0.3);
            };
            const Vec3 along = at(x + d, y) - at(x - d, y), up = at(x, y + d) - at(x, y - d);
            CHECK(length(cross(along, up)) / (4 * d * d) == Approx(2 * kPi).epsilon(1e-6));
        }
    // Directions there and back, azimuths counted from anywhere.
    for (double z : {0.0, 1e-9, 0.4, 1.5707})
        for (double a : {0.0, 1.0, 3.5, 6.2}) {
            const Vec3 w = direction(z, a);
            CHECK(length(direction_of(dome_point(w, 2.0), 2.0) - w) < 1e-15);
        }
    CHECK(dome_point(direction(1, 2.5), 2.0).azimuth == near(0.5, 1e-14));
    CHECK(dome_point(direction(1, 1.5), 2.0).azimuth == near(2 * kPi - 0.5, 1e-14));
}

TEST_CASE("Sky density: cells come as often as they are bright, dark ones never") {
    // Two rings of one part and of three; the dark part of the second is never drawn.
    const SkyDensity density({{0, 0.25, 1}, {1, 3}}, [](const DomePoint& p) {
        if (p.t < 0.25) return 2.0;
        return p.azimuth < 2 * kPi / 3 ? 0.0 : p.azimuth < 4 * kPi / 3 ? 1.0 : 3.0;
    });
    // Brightness times solid angle: 0.5, 0, 0.25, 0.75, of 1.5.
    const auto area = [](double share) { return share * 2 * kPi; };
    CHECK(density.pdf({0.1, 1}) == Approx(0.5 / 1.5 / area(0.25)));
    CHECK(density.pdf({0.5, 1}) == 0);
    CHECK(density.pdf({0.5, 3}) == Approx(0.25 / 1.5 / area(0.25)));
    CHECK(density.pdf({0.9, 6}) == Approx(0.75 / 1.5 / area(0.25)));
    double zenith = 0, brightest = 0;
    constexpr int kSteps = 300;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const SkyDensity::Draw draw = density.draw((i + 0.5) / kSteps, (j + 0.5) / kSteps);
            CHECK(draw.pdf == Approx(density.pdf(draw.point)));
            CHECK(draw.pdf > 0);
            zenith += draw.point.t < 0.25 ? 1 : 0;
            brightest += draw.point.t > 0.25 && draw.point.azimuth > 4 * kPi / 3 ? 1 : 0;
        }
    CHECK(zenith / (kSteps * kSteps) == near(1.0 / 3, 1e-6));
    CHECK(brightest / (kSteps * kSteps) == near(0.5, 1e-6));
    CHECK(SkyDensity({{0, 1}, {4}}, [](const DomePoint&) { return 0.0; }).dark());
    // All parts of an equal-area distribution have the same solid angle.
    const DomeCells cells = DomeCells::equal_area(5);
    for (std::size_t k = 0; k < 5; ++k)
        CHECK((cells.t[k + 1] - cells.t[k]) / static_cast<double>(cells.parts[k]) ==
              Approx(1.0 / 100));
}

TEST_CASE("Sky dome: one number of circular light is told from none") {
    const std::vector<double> nm{440, 600};
    Sky sky = make_clear_sky({}, nm, 45, 180);
    CHECK_FALSE(SkyDome(sky, nm).circular());
    sky.nodes.back().s3 = 1e-30;
    CHECK(SkyDome(sky, nm).circular());
}

TEST_CASE("Sky grid: a bright pixel keeps its light, a uniform sky stays uniform") {
    Sky sky = sample_sky(reference::uniform_sky(1), kOne, 45, 180);
    const SkyEmitter even(sky, kOne, kNoFacets);
    CHECK(even.resampling().cells <= 32);
    CHECK(even.resampling().largest_s0 < 1e-6);
    CHECK(even.locate(direction(0.7, 5)).pdf == Approx(1 / (2 * kPi)));

    // A node of a 2° map: ∫∫ hat sin z dz da = (2°)² sin z sinc²(1°).
    for (Stokes<double>& S : sky.nodes) S = {};
    const std::size_t row = 30;
    sky.nodes[row * 180 + 33] = {1e6, 0, 0, 0};
    const EqualAreaSky grid(SkyDome(sky, kOne), 64);
    double total = 0;
    for (std::size_t y = 0; y <= 64; ++y)
        for (std::size_t x = 0; x <= 64; ++x)
            total += static_cast<double>(grid.row(y * 65 + x, 0)[0]) *
                     (x == 0 || x == 64 ? 0.5 : 1) * (y == 0 || y == 64 ? 0.5 : 1);
    const double step = to_radians(2);
    CHECK(total * 2 * kPi / (64 * 64) == Approx(1e6 * step * step * std::sin(sky.zeniths[row]) *
                                                sqr(std::sin(step / 2) / (step / 2)))
                                             .epsilon(1e-3));
}

TEST_CASE("Sky grid: values and means lead to each other, and coarser means are means") {
    const EqualAreaSky means(SkyDome(sample_sky(smooth_sky(), kOne, 90, 360), kOne), 64);
    const EqualAreaSky back = means.values_of_means().means_of_values();
    const EqualAreaSky values = means.values_of_means();
    CHECK(values.physical());
    // Means of bilinear light on 64 cells, seen on 128 and made coarser again.
    const EqualAreaSky around = values.finer().means_of_values().coarser_means();
    for (std::size_t node = 0; node < means.nodes(); ++node)
        for (int c = 0; c < 4; ++c) {
            CHECK(back.row(node, c)[0] == near(means.row(node, c)[0], 2e-6));
            CHECK(around.row(node, c)[0] == near(means.row(node, c)[0], 2e-6));
        }
}

TEST_CASE("Sky emitter: a map of any resolution becomes what the surfaces can tell") {
    const auto resampled = [](int zeniths, int azimuths, double slope) {
        return SkyEmitter(sample_sky(smooth_sky(), kOne, zeniths, azimuths), kOne, slope)
            .resampling();
    };
    const SkyResampling coarse = resampled(64, 256, 0.0742), fine = resampled(512, 2048, 0.0742);
    CHECK(coarse.cells == fine.cells);
    CHECK(fine.cells <= 128);
    CHECK(fine.largest_s0 < 5e-3);
    CHECK(fine.rms_dolp < 1e-3);
    CHECK(resampled(64, 256, 0.5).cells <= coarse.cells);
    // Sharper than a third of the map's step: the map itself.
    CHECK(resampled(64, 256, 0.01).cells == 0);
    CHECK(resampled(64, 256, 0.01).largest_s0 == 0);
}

TEST_CASE("Sky emitter: rough paint under a thin clear sky gets a grid, too") {
    // Red light rises steeply toward the horizon: the coarsest grids do not hold it, finer ones do.
    ClearSky model;
    const std::vector<double> red{600};
    for (double zenith : {30.0, 60.0, 80.0}) {
        model.sun_zenith = to_radians(zenith);
        for (int rows : {64, 180}) {
            const SkyResampling found =
                SkyEmitter(make_clear_sky(model, red, rows, 4 * rows), red, 0.7556).resampling();
            CAPTURE(zenith, rows, found.cells);
            CHECK(found.cells > 0);
            CHECK(found.cells <= 256);
            CHECK(found.rms_s0 < 5e-3);
        }
    }
}

TEST_CASE("Sky emitter: beside a spot at the horizon no grid will do") {
    // A grid would lift it: level ground would receive many times its light.
    Sky sky = sample_sky(reference::uniform_sky(1), kOne, 900, 36);
    for (std::size_t a = 0; a < 36; ++a) sky.nodes[899 * 36 + a].s0 = 1e5;
    CHECK(SkyEmitter(sky, kOne, 0.5).resampling().cells == 0);
}

TEST_CASE("Sky emitter: nothing to draw from a black sky") {
    const SkyEmitter night(sample_sky(reference::uniform_sky(0), kOne, 4, 4), kOne, 0.1);
    CHECK(night.sample(0.3, 0.4).light.pdf == 0);
    CHECK(night.locate({0, 1, 0}).pdf == 0);
    CHECK(night.locate({0, -1, 0}).at.weight == std::array<float, 4>{});
}

TEST_CASE("Sky sampling: directions follow their density", "[statistical]") {
    // A bright patch, a dark half and a black band.
    Sky sky = sample_sky(smooth_sky(37), kOne, 12, 24);
    for (std::size_t i = 0; i < sky.nodes.size(); ++i) {
        if (i == 5 * 24 + 7) sky.nodes[i].s0 = 300;
        if (i / 24 == 2 || i / 24 == 3 || i / 24 == 4) sky.nodes[i] = {};
    }
    // From a grid, and beside a surface that sees the map itself.
    for (double slope : {0.3, 1e-3}) {
        const SkyEmitter light(sky, kOne, slope);
        constexpr int kZ = 24, kA = 36, kSamples = 400000, kFine = 8;
        std::vector<double> counts(kZ * kA, 0), expected(kZ * kA, 0);
        Uniform u(3);
        for (int i = 0; i < kSamples; ++i) {
            const LightSample s = light.sample(u(), u());
            REQUIRE(s.light.pdf > 0);
            REQUIRE(s.w.y >= 0);
            CHECK(light.locate(s.w).pdf == Approx(s.light.pdf).epsilon(1e-6));
            const auto z = std::min(kZ - 1, static_cast<int>(kZ * (1 - s.w.y)));
            const auto a = std::min(kA - 1, static_cast<int>(kA * azimuth_of(s.w) / (2 * kPi)));
            counts[static_cast<std::size_t>(z * kA + a)] += 1;
        }
        // Cells of equal solid angle; their probability by a fine midpoint rule. The density has
        // jumps, so the rule is refined until its error is below the counts' own spread.
        constexpr int kRefine = kFine * 8;
        double total = 0;
        for (int z = 0; z < kZ; ++z)
            for (int a = 0; a < kA; ++a) {
                double sum = 0;
                for (int i = 0; i < kRefine; ++i)
                    for (int j = 0; j < kFine; ++j) {
                        const double y = 1 - (z + (i + 0.5) / kRefine) / kZ;
                        const double phi = 2 * kPi * (a + (j + 0.5) / kFine) / kA;
                        sum += light.locate(direction(std::acos(y), phi)).pdf;
                    }
                const double p = sum / (kRefine * kFine) * 2 * kPi / (kZ * kA);
                expected[static_cast<std::size_t>(z * kA + a)] = p * kSamples;
                total += p;
            }
        CHECK(total == Approx(1).epsilon(1e-3));
        // False alarms: z > 4 has probability 3e-5, twice.
        CHECK(chi2_z(counts, expected) < 4);
    }
}
