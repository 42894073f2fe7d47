// neutral_points_test.cpp — the points of Babinet, Brewster and Arago, judged by an independent
// solution of Rayleigh's atmosphere and by a sky that has them by construction.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/neutral_points.h"

#include <array>
#include <complex>

#include "malus/core/frame.h"
#include "malus/scene/clear_sky.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kOne{550};

// Polarization that vanishes at four places of the vertical of azimuth a, and nowhere else:
//   S1 + i S2 ~ −Π (u − tan(t_j/2)) / (1 + |u|²)²,   u = tan(z/2) exp i(azimuth − a),
// in the meridian frame turned by a − azimuth: the form that M. V. Berry, M. R. Dennis and R. L. Lee,
// New J. Phys. 6, 162 (2004), give to the zeros beside the sun and the antisun.
reference::SkyFunction sky_with_zeros(const std::array<double, 4>& t, double a) {
    return [=](Vec3 w) -> reference::Stokes {
        using namespace std::complex_literals;
        const double azimuth = azimuth_of(w) - a;
        const std::complex<double> u = std::tan(zenith_of(w) / 2) * std::exp(1i * azimuth);
        std::complex<double> P = -1 / sqr(1 + std::norm(u));
        for (double zero : t) P *= (u - std::tan(zero / 2)) * std::cos(zero / 2);
        P *= std::exp(-2i * azimuth);
        return {1, P.real(), P.imag(), 0};
    };
}

}  // namespace

TEST_CASE("Neutral points: Babinet and Brewster in a map of 1 degree are those of Rayleigh's air") {
    // An independent adding-doubling, sun zenith 60°, ground albedo 0.25.
    const std::array<double, 3> nm{440, 550, 600}, babinet{17.5, 13.5, 12.1},
        brewster{22.1, 15.9, 13.9};
    for (double sun_azimuth_deg : {37.0, 135.0, 180.0, 301.3}) {
        ClearSky model;
        model.sun_zenith = to_radians(60), model.sun_azimuth = to_radians(sun_azimuth_deg);
        model.ground_albedo = 0.25;
        const Sky sky = make_clear_sky(model, nm, 90, 360);
        const SkyDome dome(sky, nm);
        for (std::size_t w = 0; w < nm.size(); ++w) {
            const auto found = neutral_points(dome, w, *sky.sun);
            CAPTURE(sun_azimuth_deg, nm[w]);
            // The antisun is 30° below the horizon, and Arago's point less than 30° above it.
            REQUIRE(found.size() == 2);
            CHECK(found[0].name == "Babinet");
            CHECK(found[1].name == "Brewster");
            CHECK(to_degrees(found[0].distance) == near(babinet[w], 0.1));
            CHECK(to_degrees(found[1].distance) == near(brewster[w], 0.1));
            CHECK(found[0].zenith == Approx(model.sun_zenith - found[0].distance));
            CHECK(found[1].zenith == Approx(model.sun_zenith + found[1].distance));
            for (const NeutralPoint& point : found) {
                CHECK(to_degrees(point.azimuth) == Approx(sun_azimuth_deg));
                CHECK(dolp(dome.radiance(direction(point.zenith, point.azimuth), w)) < 2e-3);
            }
        }
    }
}

TEST_CASE("Neutral points: all three are found where a closed form has put them") {
    // Beyond the zenith, and at the horizon's edge. The fourth is below the horizon.
    struct Case {
        double sun_deg, babinet_deg, brewster_deg, arago_deg;
    };
    for (const Case& c : {Case{75, 17, 12, 20}, Case{88, 15, 1000, 19}, Case{10, 25, 15, 1000},
                          Case{93, 15, 1000, 21}}) {
        const double below = c.brewster_deg < 90 ? c.brewster_deg : 20;
        const double above_antisun = c.arago_deg < 90 ? c.arago_deg : 18;
        const double sun_azimuth = to_radians(217);
        const auto sky = sky_with_zeros(
            {to_radians(c.sun_deg - c.babinet_deg), to_radians(c.sun_deg + below),
             to_radians(c.sun_deg - 180 + above_antisun), to_radians(c.sun_deg - 180 - 15)},
            sun_azimuth);
        const SkyDome dome(sample_sky(sky, kOne, 90, 360), kOne);
        const auto found = neutral_points(dome, 0, {to_radians(c.sun_deg), sun_azimuth, {}});
        std::vector<std::string> names{"Babinet"};
        std::vector<double> distances{c.babinet_deg};
        if (c.brewster_deg < 90) names.push_back("Brewster"), distances.push_back(c.brewster_deg);
        if (c.arago_deg < 90) names.push_back("Arago"), distances.push_back(c.arago_deg);
        CAPTURE(c.sun_deg);
        REQUIRE(found.size() == names.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
            CAPTURE(names[i]);
            CHECK(found[i].name == names[i]);
            // Bilinear in cells of 1°.
            CHECK(to_degrees(found[i].distance) == near(distances[i], 0.05));
            const double t_deg = i == 0                ? c.sun_deg - distances[i]
                                 : names[i] == "Arago" ? c.sun_deg - 180 + distances[i]
                                                       : c.sun_deg + distances[i];
            CHECK(to_degrees(found[i].zenith) == near(std::abs(t_deg), 0.05));
            CHECK(to_degrees(found[i].azimuth) == near(t_deg > 0 ? 217 : 37, 1e-6));
        }
    }
}

TEST_CASE("Neutral points: light scattered once has none, nor has light without polarization") {
    const Sun sun{to_radians(50), to_radians(200), {}};
    for (const auto& sky : {smooth_sky(200), reference::uniform_sky(1)}) {
        const SkyDome dome(sample_sky(sky, kOne, 90, 360), kOne);
        CHECK(neutral_points(dome, 0, sun).empty());
    }
}

TEST_CASE("Neutral points: what is polarized within 2 degrees of the sun does not hide them") {
    // An aureole polarized across the vertical, as a cloud's edge or a stray reflection would.
    const double sun_azimuth = to_radians(217);
    const Vec3 sun = direction(to_radians(60), sun_azimuth);
    const auto clean = sky_with_zeros(
        {to_radians(43), to_radians(75), to_radians(-100), to_radians(-140)}, sun_azimuth);
    const auto sky = [&](Vec3 w) -> reference::Stokes {
        if (std::acos(std::min(1.0, dot(w, sun))) > to_radians(1)) return clean(w);
        return {100, -50, 0, 0};
    };
    const SkyDome dome(sample_sky(sky, kOne, 180, 720), kOne);
    const auto found = neutral_points(dome, 0, {to_radians(60), sun_azimuth, {}});
    REQUIRE(found.size() == 2);
    CHECK(to_degrees(found[0].distance) == near(17, 0.05));
    CHECK(to_degrees(found[1].distance) == near(15, 0.05));
}
