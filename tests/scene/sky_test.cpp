// sky_test.cpp — sky maps: frames, interpolation, and what clear ones look like.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/sky.h"

#include "malus/core/error.h"
#include "malus/core/frame.h"
#include "malus/scene/clear_sky.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kOne{550};

double distance(const Stokes<double>& a, const Stokes<double>& b) {
    return std::max({std::abs(a.s0 - b.s0), std::abs(a.s1 - b.s1), std::abs(a.s2 - b.s2),
                     std::abs(a.s3 - b.s3)});
}

}  // namespace

TEST_CASE("Sky frames: the meridian axis points to the zenith, x and y as seen by the receiver") {
    const Vec3 w = direction(to_radians(60), to_radians(90));  // east, 30° high
    const BeamFrame frame = meridian_frame(w);
    // Looking at it, up is up; y = k × x lies to the receiver's left when x is up, here north.
    CHECK(frame.x.y == Approx(std::sin(to_radians(60))));
    CHECK(dot(frame.y(), kNorth) == Approx(1));
    CHECK(dot(frame.x, w) == near(0, 1e-15));
}

TEST_CASE("Sky frames: the fixed frame does not spin around the zenith") {
    const BeamFrame zenith = fixed_frame({0, 1, 0});
    for (double tilt : {1e-12, 1e-6, 1e-3})
        for (double a : {0.0, 1.0, 2.5, 4.0, 6.0}) {
            const BeamFrame beside = fixed_frame(direction(tilt, a));
            CHECK(length(beside.x - zenith.x) < 2 * tilt + 1e-14);
        }
}

TEST_CASE("Sky frames: the fixed frame is the meridian frame turned back by the azimuth") {
    for (double z : {0.0, 0.3, 1.2, 1.57})
        for (double a : {0.0, 1.0, 2.5, 4.0, 6.0}) {
            const BeamFrame meridian = meridian_frame(direction(z, a));
            // At the zenith the meridian frame is that of azimuth 0.
            const double turn = z == 0 ? 0 : a;
            const Vec3 x = std::cos(turn) * meridian.x - std::sin(turn) * meridian.y();
            CHECK(length(fixed_frame(direction(z, a)).x - x) < 1e-14);
        }
}

TEST_CASE("Sky map: interpolation reproduces a smooth sky, at the zenith and the seam too") {
    const auto sky = smooth_sky(37);
    const SkyDome dome(sample_sky(sky, kOne, 90, 360), kOne);
    for (double z : {0.0, 1e-9, 0.2, 0.6, 7.0, 45.0, 88.0})
        for (double a : {0.0, 1e-9, 0.3, 45.0, 179.7, 271.0, 359.99}) {
            const Vec3 w = direction(to_radians(z), to_radians(a));
            const reference::Stokes expected = sky(w);
            const Stokes<double> found =
                measured_in(Beam<double>{dome.radiance(w, 0), fixed_frame(w)}, meridian_frame(w))
                    .stokes;
            CAPTURE(z, a);
            // Bilinear in cells of 1°: h²/8 of second derivatives of order 3 is 1e-4. At the
            // zenith itself the meridian frame of reference and program is that of azimuth 0.
            CHECK(distance(found, {expected[0], expected[1], expected[2], expected[3]}) < 3e-4);
        }
}

TEST_CASE("Sky map: a coarse map of a sky that is the same all around stays so near the horizon") {
    // Between nodes 30° apart light is carried along its circle of zenith angle: at 80° it turns
    // by 30° cos 80° = 5.2° against the meridian from node to node.
    const auto sky = [](Vec3) { return reference::Stokes{1, 0.5, 0, 0}; };
    for (int azimuths : {1, 4, 12, 36}) {
        const SkyDome dome(sample_sky(sky, kOne, 45, azimuths), kOne);
        for (double a : {0.0, 17.0, 45.0, 200.0}) {
            const Vec3 w = direction(to_radians(80), to_radians(a));
            const Stokes<double> S =
                measured_in(Beam<double>{dome.radiance(w, 0), fixed_frame(w)}, meridian_frame(w))
                    .stokes;
            CAPTURE(azimuths, a);
            // Halfway between two nodes Δa apart, S1 is cos(Δa cos z) of what it was.
            const double least =
                azimuths == 1 ? 1 : std::cos(2 * kPi / azimuths * std::cos(to_radians(80)));
            CHECK(S.s0 == Approx(1));
            CHECK(S.s1 >= 0.5 * least - 2e-3);
            CHECK(S.s1 <= 0.5 + 1e-6);
            CHECK(std::abs(S.s2) < 0.1 * (azimuths == 1 ? 0.01 : 1));
        }
    }
}

TEST_CASE("Sky map: below the horizon it is black") {
    const SkyDome dome(sample_sky(smooth_sky(37), kOne, 9, 36), kOne);
    CHECK(dome.radiance(direction(to_radians(90.001), 1), 0).s0 == 0);
    CHECK(dome.radiance(direction(to_radians(90), 1), 0).s0 > 0);
    CHECK(dome.locate({0, -1, 0}).weight == std::array<float, 4>{});
}

TEST_CASE("Sky map: toward the horizon it goes on as its last two rows, and never out of light") {
    // Rows at 75° and 85°; the horizon is half a step on.
    const auto horizon = [](const Stokes<double>& above, const Stokes<double>& last) {
        Sky sky;
        sky.wavelengths_nm = kOne;
        sky.zeniths = {to_radians(75), to_radians(85)};
        sky.azimuths = {0};
        sky.nodes = {above, last};
        const Vec3 w = direction(kPi / 2, 0);
        return measured_in(Beam<double>{SkyDome(sky, kOne).radiance(w, 0), fixed_frame(w)},
                           meridian_frame(w))
            .stokes;
    };
    CHECK(distance(horizon({2, 0.4, 0.2, 0}, {3, 0.8, 0.1, 0}), {3.5, 1.0, 0.05, 0}) < 1e-6);
    // Past half and double, and where more would be polarized than there is: as the last row.
    CHECK(distance(horizon({9, 0, 0, 0}, {3, 0.8, 0, 0}), {3, 0.8, 0, 0}) < 1e-6);
    CHECK(distance(horizon({3, 0.1, 0, 0}, {2, 1.9, 0, 0}), {2, 1.9, 0, 0}) < 1e-6);
    CHECK(distance(horizon({0, 0, 0, 0}, {0, 0, 0, 0}), {0, 0, 0, 0}) == 0);
}

TEST_CASE("Sky map: one pixel is a uniform sky") {
    Sky sky = sample_sky(reference::uniform_sky(2.5), kOne, 1, 1);
    const SkyDome dome(sky, kOne);
    for (double z : {0.0, 0.5, 1.5}) CHECK(dome.radiance(direction(z, 2 * z), 0).s0 == Approx(2.5));
}

TEST_CASE("Sky map: a wavelength that it lacks is an error that lists what it has") {
    const Sky sky = sample_sky(reference::uniform_sky(1), {440, 600}, 2, 4);
    CHECK_THROWS_WITH(SkyDome(sky, std::vector<double>{440, 550}),
                      Catch::Contains("550") && Catch::Contains("440, 600"));
}

TEST_CASE("Clear sky: the stated largest DoLP, near 90° from the sun, horizontal in its meridian") {
    ClearSky model;
    model.sun_zenith = to_radians(60), model.sun_azimuth = to_radians(140), model.max_dolp = 0.7;
    const SkyDome dome(make_clear_sky(model, kOne, 180, 720), kOne);
    const Vec3 sun = direction(model.sun_zenith, model.sun_azimuth);
    CHECK(dolp(dome.radiance(sun, 0)) < 0.1);
    // The highest point 90° from the sun stands in its own meridian plane.
    const Vec3 opposite = direction(to_radians(30), model.sun_azimuth + kPi);
    CHECK(dolp(dome.radiance(opposite, 0)) == near(0.7, 0.02));
    const Stokes<double> S =
        measured_in(Beam<double>{dome.radiance(opposite, 0), fixed_frame(opposite)},
                    meridian_frame(opposite))
            .stokes;
    CHECK(S.s1 == near(-0.7 * S.s0, 0.02 * S.s0));
    CHECK(std::abs(S.s2) < 1e-3 * S.s0);
}

TEST_CASE("Clear sky: the map has the angles of an exact solution, azimuths in its own sense") {
    // Natraj, Li & Yung (2009), τ = 0.05, which air has at 647.4 nm, over black ground, without
    // depolarization: ρ leaves (1 − ρ)/(1 + ρ) of the DoLP of what is scattered once. Anticlockwise
    // from the sun's azimuth is less azimuth for us.
    CHECK(rayleigh_optical_depth(647.4) == near(0.05, 1e-4));
    const std::vector<double> red{647.4};
    const double rho = rayleigh_depolarization(647.4);
    int compared = 0;
    for (const auto& cell : table_rows("natraj2009_sample.csv")) {
        if (cell[1] != "0.05" || cell[2] != "0.0") continue;
        const double mu0 = std::stod(cell[3]), mu = std::stod(cell[4]);
        const double phi = to_radians(std::stod(cell[5]));
        const Stokes<double> theirs{std::stod(cell[6]), -std::stod(cell[7]), std::stod(cell[8]), 0};
        if (dolp(theirs) < 0.1) continue;
        ClearSky model;
        model.sun_zenith = std::acos(mu0), model.sun_azimuth = 2, model.ground_albedo = 0;
        // The zenith itself has no azimuth; 1e-6 rad beside it has.
        const Vec3 w = direction(std::max(1e-6, std::acos(mu)), model.sun_azimuth - phi);
        const SkyDome dome(make_clear_sky(model, red, 180, 720), red);
        const Stokes<double> ours =
            measured_in(Beam<double>{dome.radiance(w, 0), fixed_frame(w)}, meridian_frame(w))
                .stokes;
        CAPTURE(cell);
        CHECK(std::abs(std::sin(aolp(ours) - aolp(theirs))) < std::sin(to_radians(1)));
        CHECK(dolp(ours) == near((1 - rho) / (1 + rho) * dolp(theirs), 0.01));
        ++compared;
    }
    CHECK(compared >= 8);
}
