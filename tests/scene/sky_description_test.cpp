// sky_description_test.cpp — irradiance, neutral points and what is doubtful about a map.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/sky_description.h"

#include <complex>

#include "malus/core/frame.h"
#include "malus/scene/clear_sky.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using Catch::Contains;

namespace {

const std::vector<double> kOne{550};

// A sky of S0 = 1 that is neutral at two directions and opposite to them, and nowhere else: the
// polarization of Berry, Dennis & Lee, New J. Phys. 6, 162 (2004). Its angle is the mean of the
// perpendiculars to the planes through the view and each point; DoLP = 0.9 sin d1 sin d2.
reference::SkyFunction neutral_at(const Vec3& one, const Vec3& two) {
    return [one, two](Vec3 w) {
        const Vec3 x = reference::meridian_axis(w), y = cross(-w, x);
        const auto across = [&](const Vec3& point) {
            const Vec3 p = cross(point, w);
            return std::complex<double>(dot(p, x), dot(p, y));
        };
        const std::complex<double> P = 0.9 * across(one) * across(two);
        return reference::Stokes{1, P.real(), P.imag(), 0};
    };
}

Sky with_sun(Sky sky, double zenith_deg, double azimuth_deg) {
    sky.sun = Sun{to_radians(zenith_deg), to_radians(azimuth_deg), {}};
    return sky;
}

// Babinet's point 20° above the sun, Brewster's 15° below, at azimuth 217.3°.
SkyAtWavelength described_neutral(double sun_zenith_deg, int zeniths) {
    const double azimuth = to_radians(217.3);
    const Sky sky = sample_sky(neutral_at(direction(to_radians(sun_zenith_deg - 20), azimuth),
                                          direction(to_radians(sun_zenith_deg + 15), azimuth)),
                               kOne, zeniths, 4 * zeniths);
    return describe_sky(with_sun(sky, sun_zenith_deg, 217.3)).light[0];
}

Sky signs_turned(Sky sky, double s1, double s2) {
    for (Stokes<double>& S : sky.nodes) S = {S.s0, s1 * S.s1, s2 * S.s2, S.s3};
    return sky;
}

}  // namespace

TEST_CASE(
    "Sky description: neutral points and DoLP of clear air are those of an independent solution") {
    ClearSky model;
    model.sun_zenith = to_radians(60), model.sun_azimuth = to_radians(37.3);
    model.ground_albedo = 0.25;
    const std::vector<double> wavelengths{440, 550, 600};
    const SkyDescription sky = describe_sky(make_clear_sky(model, wavelengths, 90, 360));
    // Another solver of the vector equation of transfer, the same air.
    const std::array<double, 3> babinet{17.5, 13.5, 12.1}, brewster{22.1, 15.9, 13.9};
    const std::array<double, 3> across{0.623, 0.672, 0.682};
    for (std::size_t i = 0; i < 3; ++i) {
        const SkyAtWavelength& light = sky.light[i];
        REQUIRE(light.babinet);
        REQUIRE(light.brewster);
        CHECK(to_degrees(*light.babinet) == near(babinet[i], 0.3));
        CHECK(to_degrees(*light.brewster) == near(brewster[i], 0.3));
        CHECK_FALSE(light.arago);
        CHECK(*light.dolp_at_right_angle == near(across[i], 0.002));
        CHECK(to_degrees(*light.orientation->deviation) < 4);
    }
    CHECK(sky.doubts.empty());
    CHECK(sky.missing.empty());
}

TEST_CASE("Sky description: neutral points across the zenith, beside the horizon and below it") {
    // Bilinear cells of 1°: h²/8 of second derivatives near 1, over slopes near sin 35°, is 0.004°.
    const SkyAtWavelength high = described_neutral(8, 90);  // Babinet's point beyond the zenith
    CHECK(to_degrees(high.babinet.value()) == near(20, 0.01));
    CHECK(to_degrees(high.brewster.value()) == near(15, 0.01));
    CHECK_FALSE(high.arago);
    const SkyAtWavelength low = described_neutral(80, 90);  // opposite to Brewster's, 5° high
    CHECK(to_degrees(low.babinet.value()) == near(20, 0.01));
    CHECK_FALSE(low.brewster);
    CHECK(to_degrees(low.arago.value()) == near(15, 0.01));
    const SkyAtWavelength coarse = described_neutral(45, 18);
    CHECK(to_degrees(coarse.babinet.value()) == near(20, 0.3));
    CHECK(to_degrees(coarse.brewster.value()) == near(15, 0.3));
    // Light scattered once is neutral at the sun alone.
    const SkyAtWavelength once =
        describe_sky(with_sun(sample_sky(smooth_sky(200.3), kOne, 90, 360), 50, 200.3)).light[0];
    CHECK_FALSE(once.babinet);
    CHECK_FALSE(once.brewster);
}

TEST_CASE("Sky description: irradiance is exact where S0 is linear between nodes") {
    // Zenith angles 0 to 90° with uneven steps, and a ridge of 1 at azimuth 90°, linear to its
    // neighbours at 30° and 200°: its mean over the circle is half of 170°/360°.
    Sky sky;
    sky.wavelengths_nm = kOne;
    for (double z : {0.0, 11.0, 40.0, 77.0, 90.0}) sky.zeniths.push_back(to_radians(z));
    for (double a : {30.0, 90.0, 200.0}) sky.azimuths.push_back(to_radians(a));
    for (double z : sky.zeniths)
        for (double a : sky.azimuths)
            sky.nodes.push_back({1 + z + (to_degrees(a) == Approx(90) ? 1 : 0), 0, 0, 0});
    sky.sun = Sun{to_radians(60), 0, {1.5}};
    const SkyDescription description = describe_sky(sky);
    // ∫ (c + z) cos z sin z dz dφ = 2π (c/2 + π/8).
    CHECK(description.light[0].sky_irradiance ==
          Approx(2 * kPi * ((1 + 0.5 * 170 / 360) / 2 + kPi / 8)).epsilon(1e-12));
    CHECK(description.light[0].sun_irradiance.value() == Approx(0.75));
    const SkyDescription even = describe_sky(sample_sky(reference::uniform_sky(2), kOne, 90, 360));
    CHECK(even.light[0].sky_irradiance == Approx(2 * kPi).epsilon(1e-6));
    CHECK_FALSE(even.light[0].sun_irradiance);
}

TEST_CASE("Sky description: range of S0, largest DoLP and its angle from the sun") {
    const SkyAtWavelength light =
        describe_sky(with_sun(sample_sky(smooth_sky(200), kOne, 90, 360), 50, 200)).light[0];
    // ¾ (1 + cos²Θ) from 0.75 to 1.5; DoLP 0.8 at 90° from the sun.
    CHECK(light.least_s0 == near(0.75, 1e-3));
    CHECK(light.most_s0 == near(1.5, 1e-3));
    CHECK(to_degrees(light.brightest.zenith) == near(50, 1));
    CHECK(to_degrees(light.brightest.azimuth) == near(200, 1));
    CHECK(light.largest_dolp == near(0.8, 1e-3));
    CHECK(to_degrees(*light.most_polarized_from_sun) == near(90, 1));
}

TEST_CASE("Sky description: a sun beside the map's plane of symmetry is doubted, with the plane") {
    const Sky map = sample_sky(smooth_sky(137), kOne, 45, 180);
    CHECK(describe_sky(with_sun(map, 50, 137)).doubts.empty());
    for (double off : {5.0, 40.0, 90.0, 223.0}) {
        const SkyDescription sky = describe_sky(with_sun(map, 50, 137 + off));
        CAPTURE(off);
        REQUIRE(sky.doubts.size() == 1);
        CHECK_THAT(sky.doubts[0], Contains("550 nm: the declared sun is not in the map's plane of "
                                           "symmetry") &&
                                      Contains("about azimuth 137 or 317") &&
                                      Contains("azimuth origin or sense may differ"));
        CHECK(sky.light[0].orientation->polarization_asymmetry > 0.05);
    }
}

TEST_CASE("Sky description: a reversed sign is told from the plane through sun and view") {
    const Sky map = with_sun(sample_sky(smooth_sky(137), kOne, 45, 180), 50, 137);
    const auto doubt = [](const Sky& sky) {
        const SkyDescription description = describe_sky(sky);
        REQUIRE(description.doubts.size() == 1);
        CHECK_THAT(description.doubts[0],
                   Contains("550 nm: polarization is not perpendicular to the plane sun-view"));
        CHECK(to_degrees(*description.light[0].orientation->deviation) > 20);
        return description.doubts[0];
    };
    CHECK(to_degrees(*describe_sky(map).light[0].orientation->deviation) < 0.1);
    CHECK_THAT(doubt(signs_turned(map, -1, 1)), Contains("with S1 reversed it is 0"));
    CHECK_THAT(doubt(signs_turned(map, 1, -1)), Contains("with S2 reversed or azimuths"));
    CHECK_THAT(doubt(signs_turned(map, -1, -1)), Contains("with S1 and S2 reversed"));
    CHECK_THAT(doubt(with_sun(map, 50, 317)), Contains("the sun at the opposite azimuth"));
    // Nothing can be said of a sky without polarization.
    const SkyDescription grey = describe_sky(signs_turned(map, 0, 0));
    CHECK(grey.doubts.empty());
    CHECK_FALSE(grey.light[0].orientation->deviation);
}

TEST_CASE("Sky description: what is missing or cannot be is said") {
    Sky sky = sample_sky(smooth_sky(137), kOne, 90, 360);
    const std::vector<std::string> without = describe_sky(sky).missing;
    REQUIRE(without.size() == 1);
    CHECK_THAT(without[0], Contains("no sun is declared"));
    sky = with_sun(sky, 50, 137);
    sky.nodes[5] = {};
    sky.nodes[700] = {1, 0.99, 0, 0};
    const SkyDescription spoiled = describe_sky(sky);
    REQUIRE(spoiled.missing.size() == 2);
    CHECK_THAT(spoiled.missing[0], Contains("no sunIrradiance"));
    CHECK(spoiled.missing[1] == "550 nm: S0 = 0 at 1 of 32400 nodes");
    REQUIRE(spoiled.doubts.size() == 1);
    CHECK_THAT(spoiled.doubts[0], Contains("DoLP above 0.98 at 1 of 32400 nodes"));
    // Rows from 10° to 80°, 10° apart.
    Sky part = sample_sky(reference::uniform_sky(1), kOne, 8, 36);
    for (std::size_t z = 0; z < 8; ++z)
        part.zeniths[z] = to_radians(10.0 * static_cast<double>(z + 1));
    const std::vector<std::string> rows = describe_sky(part).missing;
    REQUIRE(rows.size() == 4);
    CHECK_THAT(rows[1], Contains("rows start at zenith angle 10 degrees"));
    CHECK_THAT(rows[2], Contains("rows end at zenith angle 80 degrees"));
    CHECK_THAT(rows[3], Contains("up to 10 degrees"));
}
