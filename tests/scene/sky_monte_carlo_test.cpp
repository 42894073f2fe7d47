// sky_monte_carlo_test.cpp — random walks against published skies, and the solver against them.
//
// Every number is judged by 4.5 of its standard errors: false alarms 7e-6 a number, 8e-4 in all 114.
// SPDX-License-Identifier: Apache-2.0
#include "support/sky_monte_carlo.h"

#include "scene/radiative_transfer.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using sky_monte_carlo::Air, sky_monte_carlo::Estimate, sky_monte_carlo::HenyeyGreenstein,
    sky_monte_carlo::Molecules, sky_monte_carlo::Particles, sky_monte_carlo::random_walks;

namespace {

ScatteringMatrix matrix_of(const Molecules& air) {
    return rayleigh_matrix(air.depolarization);
}
ScatteringMatrix matrix_of(const HenyeyGreenstein& haze) {
    return henyey_greenstein_matrix(haze.asymmetry, haze.polarization);
}
Atmosphere for_solver(const Air& air) {
    Atmosphere result{{}, air.ground_albedo};
    for (const auto& mixture : air.layers) {
        result.layers.emplace_back();
        for (const Particles& p : mixture)
            result.layers.back().push_back(
                {p.optical_depth, p.albedo,
                 std::visit([](const auto& kind) { return matrix_of(kind); }, p.kind)});
    }
    return result;
}

// By their standard errors, which are small: I, Q and U of a walk's result and what they should be.
void check(const Estimate& found, const sky_monte_carlo::Stokes& expected) {
    for (std::size_t c = 0; c < 3; ++c) {
        CAPTURE(c, (found.mean[c] - expected[c]) / found.error[c]);
        CHECK(std::abs(found.mean[c] - expected[c]) < 4.5 * found.error[c]);
        CHECK(found.error[c] < 2.5e-3 * expected[0]);
    }
}

constexpr double kSunZenithDeg = 60;

struct Direction {
    double zenith_deg, azimuth_deg;
};

void compare(const Air& air, const std::vector<Direction>& directions, int walks) {
    std::vector<double> mu, azimuths;
    for (const Direction& to : directions) {
        mu.push_back(std::cos(to_radians(to.zenith_deg)));
        azimuths.push_back(to_radians(to.azimuth_deg));
    }
    const double sun_zenith = to_radians(kSunZenithDeg);
    const auto sky = light_at_ground(for_solver(air), std::cos(sun_zenith), mu, azimuths).sky;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        CAPTURE(directions[i].zenith_deg, directions[i].azimuth_deg);
        const auto& S = sky[i * azimuths.size() + i];
        check(random_walks(air, sun_zenith, std::acos(mu[i]), azimuths[i], walks,
                           static_cast<unsigned>(i + 1)),
              {S.s0, S.s1, S.s2});
    }
}

const Particles kAir{0.1, 1, Molecules{0.03}};

Particles haze(double asymmetry) {
    return {0.3, 0.96, HenyeyGreenstein{asymmetry, 0.45}};
}

// 10° from the sun, 90°, low, 120°, near the zenith.
const std::vector<Direction> kDirections{{55, 10}, {59, 110}, {80, 250}, {70, 215}, {3, 35}};

}  // namespace

TEST_CASE("Transfer: random walks find I, Q and U of Natraj, Li and Yung", "[statistical]") {
    unsigned rows = 0;
    for (const auto& cell : table_rows("natraj2009_sample.csv")) {
        if (cell[1] != "0.25") continue;
        CAPTURE(cell);
        // Sun of irradiance π; their azimuth is anticlockwise; S1 = −Q, S2 = U.
        check(random_walks({{{{0.25, 1, Molecules{0}}}}, std::stod(cell[2])},
                           std::acos(std::stod(cell[3])), std::acos(std::stod(cell[4])),
                           -to_radians(std::stod(cell[5])), 200000, ++rows),
              {std::stod(cell[6]) / kPi, -std::stod(cell[7]) / kPi, std::stod(cell[8]) / kPi});
    }
    CHECK(rows == 20);
}

TEST_CASE("Transfer: random walks find the same light under haze mixed with air", "[statistical]") {
    compare({{{kAir, haze(0.7)}}, 0.3}, kDirections, 800000);
}

TEST_CASE("Transfer: random walks find the same light under air above haze", "[statistical]") {
    compare({{{kAir}, {haze(0.7)}}, 0.3}, kDirections, 800000);
    compare({{{kAir}, {haze(0.85)}}, 0.3}, kDirections, 1600000);
}

TEST_CASE("Transfer: random walks find the same light 2° to 10° from the sun in a sharp peak",
          "[statistical]") {
    // The solver's nodes hold 98 % of this matrix; beside the sun single scattering is put right.
    compare({{{kAir}, {haze(0.95)}, {kAir}}, 0.3}, {{61, 2}, {63, 356}, {55, 10}}, 1600000);
}
