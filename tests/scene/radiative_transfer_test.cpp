// radiative_transfer_test.cpp — the light of a Rayleigh sky against published solutions.
// SPDX-License-Identifier: Apache-2.0
#include "scene/radiative_transfer.h"

#include "malus/scene/sky.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

Stokes<double> light(const RayleighLayer& air, double mu0, double mu, double azimuth_deg) {
    return light_at_ground(air, mu0, std::vector<double>{mu})[0].at(to_radians(azimuth_deg));
}

// ∫ f(μ) dμ over (0, 1): eight Gauss nodes (Abramowitz & Stegun, table 25.4) below 0.15, where light
// at the horizon changes fast, and eight above.
struct Quadrature {
    std::vector<double> mu, weight;
    Quadrature() {
        constexpr std::array<double, 4> kNode{0.183434642495650, 0.525532409916329,
                                              0.796666477413627, 0.960289856497536};
        constexpr std::array<double, 4> kWeight{0.362683783378362, 0.313706645877887,
                                                0.222381034453374, 0.101228536290376};
        for (const auto& [from, to] : {std::pair{0.0, 0.15}, {0.15, 1.0}})
            for (std::size_t i = 0; i < 4; ++i)
                for (double side : {-1.0, 1.0}) {
                    mu.push_back(0.5 * (from + to) + 0.5 * side * kNode[i] * (to - from));
                    weight.push_back(0.5 * kWeight[i] * (to - from));
                }
    }
};

// Irradiance on the ground from sky and sun, per unit of the sun's.
double ground_irradiance(const RayleighLayer& air, double mu0) {
    static const Quadrature over;
    double sum = mu0 * std::exp(-air.optical_depth / mu0);
    const std::vector<SkyModes> sky = light_at_ground(air, mu0, over.mu);
    for (std::size_t i = 0; i < over.mu.size(); ++i)
        sum += 2 * kPi * over.weight[i] * over.mu[i] * sky[i].I[0];
    return sum;
}

// Zenith angle, in degrees, of the place nearest the sun where S1 changes sign in the sun's vertical;
// the sun stands at 60°.
double neutral_point(const RayleighLayer& air, double from_deg, double step_deg) {
    std::vector<double> mu;
    for (int i = 0; i < 60; ++i) mu.push_back(std::cos(to_radians(from_deg + i * step_deg)));
    const std::vector<SkyModes> sky = light_at_ground(air, 0.5, mu);
    for (std::size_t i = 1; i < sky.size(); ++i) {
        const double before = sky[i - 1].at(0).s1, after = sky[i].at(0).s1;
        if (before * after <= 0)
            return from_deg + step_deg * (static_cast<double>(i) - after / (after - before));
    }
    return 0;
}

constexpr std::array<double, 3> kWavelengths{440, 550, 600};

RayleighLayer air_at(double nm, double albedo) {
    return {rayleigh_optical_depth(nm), rayleigh_depolarization(nm), albedo};
}

}  // namespace

TEST_CASE("Transfer: I, Q and U of Natraj, Li and Yung, to 1e-7 for a sun of irradiance π") {
    const auto rows = table_rows("natraj2009_sample.csv");
    REQUIRE(rows.size() == 60);
    for (const auto& cell : rows) {
        REQUIRE(cell.size() == 9);
        const RayleighLayer air{std::stod(cell[1]), 0, std::stod(cell[2])};
        // Their azimuth is anticlockwise; S1 = −Q, S2 = U.
        const Stokes<double> S =
            light(air, std::stod(cell[3]), std::stod(cell[4]), -std::stod(cell[5]));
        CAPTURE(cell);
        CHECK(kPi * S.s0 == near(std::stod(cell[6]), 1e-7));
        CHECK(kPi * S.s1 == near(-std::stod(cell[7]), 1e-7));
        CHECK(kPi * S.s2 == near(std::stod(cell[8]), 1e-7));
    }
}

TEST_CASE("Transfer: depolarizing air as PSTAR has it, within 2e-6") {
    // IPRT phase A, case A1, model PSTAR (Emde et al., JQSRT 164, 8 (2015)): τ = 0.5, ground, I, Q,
    // U per irradiance of the sun; azimuths clockwise with U = −S2, as the vectors of a single
    // scattering show.
    struct Row {
        double depolarization, sun_zenith, view_zenith, azimuth, I, Q, U;
    };
    for (const Row& row : {
             Row{0.03, 30.0, 20.0, 65.0, 5.300881E-02, 4.945415E-03, 2.677707E-03},
             Row{0.03, 30.0, 20.0, 300.0, 5.360718E-02, 4.715367E-03, -1.827983E-03},
             Row{0.03, 30.0, 60.0, 120.0, 5.409492E-02, -1.959279E-02, 2.873062E-02},
             Row{0.03, 30.0, 60.0, 245.0, 5.474248E-02, -1.769932E-02, -2.945506E-02},
             Row{0.10, 30.0, 20.0, 235.0, 4.568886E-02, -3.193614E-03, -9.745562E-03},
             Row{0.10, 30.0, 60.0, 55.0, 6.959898E-02, -4.073043E-03, 1.663666E-02},
             Row{0.10, 30.0, 60.0, 180.0, 5.401279E-02, -2.981117E-02, 0.000000E+00},
         }) {
        const Stokes<double> S =
            light({0.5, row.depolarization, 0}, std::cos(to_radians(row.sun_zenith)),
                  std::cos(to_radians(row.view_zenith)), row.azimuth);
        CAPTURE(row.depolarization, row.view_zenith, row.azimuth);
        CHECK(S.s0 == near(row.I, 2e-6 * row.I));
        CHECK(S.s1 == near(row.Q, 2e-6 * row.I));
        CHECK(S.s2 == near(-row.U, 2e-6 * row.I));
    }
}

TEST_CASE("Transfer: no light is lost, and ways of light can be reversed") {
    // Conservative air: what comes through of even light from above is 1 − s, s the share of even
    // light from below that returns. By reciprocity that share is 2 ∫ G(μ0) dμ0, G the irradiance
    // on black ground under a sun at μ0; and G over ground of albedo A is G/(1 − A s).
    const double tau = 0.3, rho = 0.03;
    const double black = ground_irradiance({tau, rho, 0}, 0.6);
    const double grey = ground_irradiance({tau, rho, 0.5}, 0.6);
    const double s = (1 - black / grey) / 0.5;
    double through = 0;
    const Quadrature suns;
    for (std::size_t i = 0; i < suns.mu.size(); ++i)
        through += 2 * suns.weight[i] * ground_irradiance({tau, rho, 0}, suns.mu[i]);
    CHECK(s > 0.1);
    CHECK(through == near(1 - s, 1e-6));
}

TEST_CASE("Air: optical depth and depolarization of Bodhaine et al. and Bates") {
    const std::array<double, 3> depth{0.242605, 0.097065, 0.068087}, rho{0.0292, 0.0283, 0.0281};
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(rayleigh_optical_depth(kWavelengths[i]) == near(depth[i], 1e-6));
        CHECK(rayleigh_optical_depth(kWavelengths[i], 506.625) == near(depth[i] / 2, 1e-6));
        CHECK(rayleigh_depolarization(kWavelengths[i]) == near(rho[i], 1e-4));
    }
}

TEST_CASE("Clear sky: DoLP 90° from the sun falls with multiple scattering and bright ground") {
    // An independent adding-doubling of the same air, sun zenith 60°.
    const std::array<double, 3> black{0.780, 0.863, 0.883}, bright{0.623, 0.672, 0.682};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto dolp_at = [&](double albedo) {
            return dolp(light(air_at(kWavelengths[i], albedo), 0.5, std::cos(to_radians(30)), 180));
        };
        CHECK(dolp_at(0) == near(black[i], 1e-3));
        CHECK(dolp_at(0.25) == near(bright[i], 1e-3));
    }
}

TEST_CASE("Neutral points: Babinet's above and Brewster's below the sun") {
    // The same independent solution, ground albedo 0.25.
    const std::array<double, 3> babinet{17.5, 13.5, 12.1}, brewster{22.1, 15.9, 13.9};
    for (std::size_t i = 0; i < 3; ++i) {
        const RayleighLayer air = air_at(kWavelengths[i], 0.25);
        CHECK(60 - neutral_point(air, 59.5, -0.5) == near(babinet[i], 0.1));
        CHECK(neutral_point(air, 60.5, 0.45) - 60 == near(brewster[i], 0.1));
    }
}
