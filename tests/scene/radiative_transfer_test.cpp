// radiative_transfer_test.cpp — the light of the sky against published solutions.
// SPDX-License-Identifier: Apache-2.0
#include "scene/radiative_transfer.h"

#include <fstream>

#include "malus/core/frame.h"
#include "malus/scene/clear_sky.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

Atmosphere rayleigh(double optical_depth, double depolarization, double ground_albedo) {
    return {{{{optical_depth, 1, rayleigh_matrix(depolarization)}}}, ground_albedo};
}

Stokes<double> light(const Atmosphere& air, double mu0, double mu, double azimuth_deg) {
    return light_at_ground(air, mu0, std::array{mu}, std::array{to_radians(azimuth_deg)}).sky[0];
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

// Irradiance on the ground from sky and sun, per unit of the sun's, by another quadrature than the
// solver's: Rayleigh's modes 1 and 2 vanish from the mean of four azimuths.
double ground_irradiance(const Atmosphere& air, double mu0) {
    static const Quadrature over;
    constexpr std::array<double, 4> kAzimuths{0, kPi / 2, kPi, 1.5 * kPi};
    const GroundLight light = light_at_ground(air, mu0, over.mu, kAzimuths);
    double sum = mu0 * light.direct;
    for (std::size_t i = 0; i < over.mu.size(); ++i)
        for (std::size_t a = 0; a < 4; ++a)
            sum += 0.5 * kPi * over.weight[i] * over.mu[i] * light.sky[4 * i + a].s0;
    return sum;
}

// Zenith angle, in degrees, of the place nearest the sun where S1 changes sign in the sun's vertical;
// the sun stands at 60°.
double neutral_point(const Atmosphere& air, double from_deg, double step_deg) {
    std::vector<double> mu;
    for (int i = 0; i < 60; ++i) mu.push_back(std::cos(to_radians(from_deg + i * step_deg)));
    const auto sky = light_at_ground(air, 0.5, mu, std::array{0.0}).sky;
    for (std::size_t i = 1; i < sky.size(); ++i) {
        const double before = sky[i - 1].s1, after = sky[i].s1;
        if (before * after <= 0)
            return from_deg + step_deg * (static_cast<double>(i) - after / (after - before));
    }
    return 0;
}

constexpr std::array<double, 3> kWavelengths{440, 550, 600};

Atmosphere air_at(double nm, double albedo) {
    return rayleigh(rayleigh_optical_depth(nm), rayleigh_depolarization(nm), albedo);
}

}  // namespace

TEST_CASE("Transfer: I, Q and U of Natraj, Li and Yung, to 1e-7 for a sun of irradiance π") {
    const auto rows = table_rows("natraj2009_sample.csv");
    REQUIRE(rows.size() == 60);
    for (const auto& cell : rows) {
        REQUIRE(cell.size() == 9);
        const Atmosphere air = rayleigh(std::stod(cell[1]), 0, std::stod(cell[2]));
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
            light(rayleigh(0.5, row.depolarization, 0), std::cos(to_radians(row.sun_zenith)),
                  std::cos(to_radians(row.view_zenith)), row.azimuth);
        CAPTURE(row.depolarization, row.view_zenith, row.azimuth);
        CHECK(S.s0 == near(row.I, 2e-6 * row.I));
        CHECK(S.s1 == near(row.Q, 2e-6 * row.I));
        CHECK(S.s2 == near(-row.U, 2e-6 * row.I));
    }
}

TEST_CASE("Transfer: the light that leaves the air at its top is PSTAR's, within 2e-6") {
    // The same table's other end; view zenith angles of 180° − z.
    struct Row {
        double depolarization, sun_zenith, view_zenith, azimuth, I, Q, U;
    };
    for (const Row& row : {
             Row{0.03, 30.0, 160.0, 65.0, 4.868928E-02, -1.105297E-03, 1.148260E-02},
             Row{0.03, 30.0, 160.0, 300.0, 4.816767E-02, -2.490173E-03, -1.173368E-02},
             Row{0.03, 30.0, 120.0, 65.0, 5.819503E-02, -1.917220E-02, 3.171269E-02},
             Row{0.03, 30.0, 120.0, 120.0, 7.300461E-02, -5.707682E-03, 2.277640E-02},
         }) {
        const double mu = -std::cos(to_radians(row.view_zenith));
        const Stokes<double> S =
            light_at_ground(rayleigh(0.5, row.depolarization, 0),
                            std::cos(to_radians(row.sun_zenith)), std::array{mu},
                            std::array{to_radians(row.azimuth)})
                .top[0];
        CAPTURE(row.view_zenith, row.azimuth);
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
    const double black = ground_irradiance(rayleigh(tau, rho, 0), 0.6);
    const double grey = ground_irradiance(rayleigh(tau, rho, 0.5), 0.6);
    const double s = (1 - black / grey) / 0.5;
    double through = 0;
    const Quadrature suns;
    for (std::size_t i = 0; i < suns.mu.size(); ++i)
        through += 2 * suns.weight[i] * ground_irradiance(rayleigh(tau, rho, 0), suns.mu[i]);
    CHECK(s > 0.1);
    CHECK(through == near(1 - s, 1e-6));
}

TEST_CASE("Transfer: haze that absorbs nothing loses no light, mixed or below, over any ground") {
    // What the sun sends goes back up or into the ground; 1e-6 of it may be lost.
    const Scatterer air{0.25, 1, rayleigh_matrix(0.03)};
    for (double g : {0.7, 0.85}) {
        const Scatterer haze{0.4, 1, henyey_greenstein_matrix(g, 0.45)};
        for (const auto& layers :
             {std::vector<std::vector<Scatterer>>{{air, haze}}, {{air}, {haze}}})
            for (double albedo : {0.0, 0.5}) {
                const double mu0 = 0.5;
                const GroundLight light = light_at_ground({layers, albedo}, mu0, {}, {});
                const double into_ground = (1 - albedo) * (light.diffuse + mu0 * light.direct);
                CHECK(light.escaping + into_ground == near(mu0, 1e-6 * mu0));
            }
    }
}

TEST_CASE("Transfer: a layer cut in two, and one that scatters nothing, change nothing") {
    const Scatterer air{0.2, 1, rayleigh_matrix(0.03)};
    const Scatterer haze{0.3, 0.9, henyey_greenstein_matrix(0.6, 0.45)};
    const auto half = [](Scatterer whole) {
        whole.optical_depth /= 2;
        return whole;
    };
    const Atmosphere whole{{{air, haze}}, 0.3};
    const Atmosphere cut{{{half(air), half(haze)}, {half(air), half(haze)}}, 0.3};
    const std::array<double, 2> mu{0.9, 0.3}, azimuths{0.4, 2.5};
    const GroundLight a = light_at_ground(whole, 0.5, mu, azimuths),
                      b = light_at_ground(cut, 0.5, mu, azimuths);
    for (std::size_t i = 0; i < a.sky.size(); ++i) {
        CHECK(a.sky[i].s0 == near(b.sky[i].s0, 1e-7));
        CHECK(a.sky[i].s1 == near(b.sky[i].s1, 1e-7));
        CHECK(a.sky[i].s2 == near(b.sky[i].s2, 1e-7));
    }
    CHECK(a.escaping == near(b.escaping, 1e-7));
    // Soot below the air dims what comes down by its own depth alone.
    const Scatterer soot{0.5, 0, rayleigh_matrix(0)};
    const GroundLight c = light_at_ground({{{air}}, 0}, 0.5, mu, azimuths),
                      d = light_at_ground({{{air}, {soot}}, 0}, 0.5, mu, azimuths);
    for (std::size_t i = 0; i < c.sky.size(); ++i)
        CHECK(d.sky[i].s0 == near(c.sky[i].s0 * std::exp(-0.5 / mu[i / 2]), 1e-9));
    CHECK(d.direct == near(std::exp(-(0.2 + 0.5) / 0.5), 1e-12));
}

TEST_CASE("Transfer: deep haze is finite and physical down to the horizon") {
    // Slant depths of a thousand and more, where exponentials vanish; layers whose modes differ.
    const Scatterer air{2, 1, rayleigh_matrix(0.03)};
    const Scatterer haze{5, 0.96, henyey_greenstein_matrix(0.7, 0.45)};
    const std::array<double, 3> mu{0.9, 0.01, 1e-4}, azimuths{0, 1, 3};
    for (const auto& layers :
         {std::vector<std::vector<Scatterer>>{{air, haze}}, {{air}, {haze}}, {{haze}, {air}}}) {
        const GroundLight light = light_at_ground({layers, 0.3}, 0.5, mu, azimuths);
        for (const Stokes<double>& S : light.sky) {
            CHECK(S.s0 > 0);
            CHECK(std::hypot(S.s1, S.s2) < S.s0);
        }
        // What a thick cloud sends down: even, within a factor of two of its mean.
        const double mean = light.diffuse / kPi;
        CHECK(light.sky[0].s0 / mean == Approx(1.2).epsilon(0.3));
    }
}

TEST_CASE("Transfer: a table of a sharp peak loses no light, or is refused") {
    // Half of the light within a Gaussian of σ = 0.3°, the rest even; conservative.
    const auto peaked = [](double sigma_deg) {
        std::vector<ScatteringRow> rows;
        for (double a = 0; a < 180; a += a < 20 * sigma_deg ? sigma_deg / 4 : 5) {
            const double F11 =
                0.5 + std::exp(-0.5 * sqr(a / sigma_deg)) / sqr(to_radians(sigma_deg));
            rows.push_back({to_radians(a), {F11, 0, F11, F11 * std::cos(to_radians(a))}});
        }
        rows.push_back({kPi, {0.5, 0, 0.5, -0.5}});
        return tabulated_matrix(rows);
    };
    const double mu0 = 0.5;
    const GroundLight light =
        light_at_ground({{{{0.5, 1, peaked(0.3)}}}, 0}, mu0, std::array{0.9}, std::array{1.0});
    CHECK(light.escaping + light.diffuse + mu0 * light.direct == near(mu0, 1e-6 * mu0));
    CHECK_THROWS_WITH(light_at_ground({{{{0.5, 1, peaked(0.02)}}}, 0}, mu0, {}, {}),
                      Catch::Contains("changes too fast"));
}

TEST_CASE("Sun: its light is that of ASTM G173, and dims by the depth of the air") {
    // G173-03 gives 1347.93 W/m² from 280 to 4000 nm, and these rows.
    double sum = 0;
    for (double nm = 280; nm < 4000; nm += 0.5)
        sum += 0.25 * (solar_irradiance(nm) + solar_irradiance(nm + 0.5));
    CHECK(sum == near(1347.93, 0.1));
    CHECK(solar_irradiance(440) == near(1.830, 1e-9));
    CHECK(solar_irradiance(550) == near(1.863, 1e-9));
    CHECK_THROWS_WITH(solar_irradiance(279), Catch::Contains("280 to 4000 nm"));

    ClearSky model;
    model.aerosol.optical_depth_550 = 0.3;
    const Sky sky = make_clear_sky(model, std::array{440.0, 550.0}, 2, 4);
    REQUIRE(sky.sun->irradiance.size() == 2);
    // Sun at 60°: twice the vertical depth; 0.242605 and 0.097065 of air.
    CHECK(sky.sun->irradiance[1] == near(1.863 * std::exp(-2 * (0.097065 + 0.3)), 1e-5));
    CHECK(sky.sun->irradiance[0] ==
          near(1.830 * std::exp(-2 * (0.242605 + 0.3 * std::pow(550.0 / 440, 1.3))), 1e-5));
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
        const Atmosphere air = air_at(kWavelengths[i], 0.25);
        CHECK(60 - neutral_point(air, 59.5, -0.5) == near(babinet[i], 0.1));
        CHECK(neutral_point(air, 60.5, 0.45) - 60 == near(brewster[i], 0.1));
    }
}

TEST_CASE("Hazy sky: the degree of polarization measured over Lapland, within 0.06 rms") {
    // Gál et al. (2001), 450 nm, sun at 83.1°, digitized to ±0.05. The aerosol's depth and the ground
    // are those that fit best, its other properties the defaults; air alone is off by 0.13.
    ClearSky model;
    model.sun_zenith = to_radians(83.1), model.ground_albedo = 0.15;
    model.aerosol.optical_depth_550 = 0.15;
    const std::vector<double> blue{450};
    const auto deviation = [&](std::ofstream* table) {
        const SkyDome dome(make_clear_sky(model, blue, 90, 360), blue);
        double sum = 0, count = 0;
        for (const auto& cell : table_rows("gal2001_450nm_dolp.csv")) {
            const double zenith = std::stod(cell[0]), azimuth = std::stod(cell[1]);
            const double measured = std::stod(cell[2]);
            const double computed = dolp(dome.radiance(
                direction(to_radians(zenith), model.sun_azimuth + to_radians(azimuth)), 0));
            sum += sqr(computed - measured), ++count;
            if (table)
                *table << zenith << ',' << azimuth << ',' << measured << ',' << computed << '\n';
        }
        REQUIRE(count == 35);
        return std::sqrt(sum / count);
    };
    std::ofstream table(MALUS_TEST_OUTPUT "/measured_sky.csv");  // for tools/plot-measured-sky
    table << "zenith_deg,relative_azimuth_deg,measured,computed\n";
    CHECK(deviation(&table) < 0.06);
    model.aerosol.optical_depth_550 = 0;
    CHECK(deviation(nullptr) > 0.1);
}
