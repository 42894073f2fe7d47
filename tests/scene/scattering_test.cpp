// scattering_test.cpp — scattering matrices, and their expansion, against what is known in closed form.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/scattering.h"

#include "malus/core/vec.h"
#include "scene/scattering_expansion.h"
#include "support/catch.h"

using namespace malus;

namespace {

// ½ ∫ f(c) dc over [−1, 1] by Simpson's rule in the angle.
template <class Function>
double mean_over_sphere(const Function& f) {
    constexpr int kSteps = 2000;
    double sum = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const double angle = kPi * i / kSteps;
        sum += (i == 0 || i == kSteps ? 1
                : i % 2 == 1          ? 4
                                      : 2) *
               std::sin(angle) * f(std::cos(angle));
    }
    return 0.5 * sum * kPi / kSteps / 3;
}

void check_equal(const ScatteringElements& a, const ScatteringElements& b, double margin) {
    CHECK(a.F11 == near(b.F11, margin));
    CHECK(a.F12 == near(b.F12, margin));
    CHECK(a.F22 == near(b.F22, margin));
    CHECK(a.F33 == near(b.F33, margin));
}

std::vector<ScatteringRow> rows_of(const ScatteringMatrix& F, double step_deg, double unit) {
    std::vector<ScatteringRow> rows;
    for (double a = 0; a <= 180; a += step_deg)
        rows.push_back({to_radians(a), unit * F(std::cos(to_radians(a)))});
    return rows;
}

}  // namespace

TEST_CASE("Scattering: matrices scatter all light once, forward as their asymmetry says") {
    const auto norm = [](const ScatteringMatrix& F) {
        return mean_over_sphere([&](double c) { return F(c).F11; });
    };
    const auto mean_cosine = [](const ScatteringMatrix& F) {
        return mean_over_sphere([&](double c) { return c * F(c).F11; });
    };
    CHECK(norm(rayleigh_matrix(0.03)) == near(1, 1e-9));
    CHECK(mean_cosine(rayleigh_matrix(0.03)) == near(0, 1e-9));
    for (double g : {-0.4, 0.0, 0.7, 0.9}) {
        CHECK(norm(henyey_greenstein_matrix(g, 0.45)) == near(1, 1e-8));
        CHECK(mean_cosine(henyey_greenstein_matrix(g, 0.45)) == near(g, 1e-8));
    }
}

TEST_CASE("Scattering: natural light turned by 90° is polarized across the plane of scattering") {
    // Molecules: (1−ρ)/(1+ρ); aerosol: p.
    const ScatteringElements air = rayleigh_matrix(0.03)(0);
    CHECK(-air.F12 / air.F11 == near(0.97 / 1.03, 1e-12));
    const ScatteringElements haze = henyey_greenstein_matrix(0.7, 0.45)(0);
    CHECK(-haze.F12 / haze.F11 == near(0.45, 1e-12));
    // Straight on nothing changes, straight back S2 is reversed.
    CHECK(rayleigh_matrix(0)(1).F33 == near(rayleigh_matrix(0)(1).F11, 1e-12));
    CHECK(rayleigh_matrix(0)(-1).F33 == near(-rayleigh_matrix(0)(-1).F11, 1e-12));
}

TEST_CASE("Scattering: a table of a known matrix gives it back, in any unit") {
    const ScatteringMatrix closed = henyey_greenstein_matrix(0.7, 0.45);
    const ScatteringMatrix table = tabulated_matrix(rows_of(closed, 0.25, 42));
    for (double angle : {0.0, 0.1, 3.3, 45.1, 90.0, 137.7, 180.0}) {
        const double c = std::cos(to_radians(angle));
        check_equal(table(c), closed(c), 1e-4 * closed(c).F11);
    }
}

TEST_CASE(
    "Expansion: Henyey and Greenstein's moments are powers of g, its peak the first left out") {
    for (double g : {-0.4, 0.3, 0.7, 0.85}) {
        const ScatteringExpansion expansion(henyey_greenstein_matrix(g, 0.45), 30);
        CHECK(expansion.peak() == near(std::pow(g, 30), 1e-12));
        // Σ over degrees below 30 of (2l+1) (gˡ − f) P_l, at c = 1 and −1.
        double on = 0, back = 0;
        for (int l = 0; l < 30; ++l) {
            const double term = (2 * l + 1) * (std::pow(g, l) - expansion.peak());
            on += term;
            back += l % 2 == 0 ? term : -term;
        }
        CHECK(expansion.smooth(1).F11 == near(on, 1e-9));
        CHECK(expansion.smooth(-1).F11 == near(back, 1e-9));
    }
}

TEST_CASE("Expansion: all elements come back where the degrees suffice") {
    // F22 ≠ F11 tells d22 from P; degrees enough for 1e-9.
    const ScatteringMatrix F = [](double c) {
        const ScatteringElements a = henyey_greenstein_matrix(0.5, 0.6)(c);
        const double across = 1 - c * c;
        return ScatteringElements{a.F11, a.F12 * (1 + 0.2 * c), a.F22 - 0.1 * across * across,
                                  a.F33 + 0.05 * c * across * across};
    };
    const ScatteringExpansion aerosol(F, 60), air(rayleigh_matrix(0.03), 48);
    CHECK(air.degree() == 2);
    CHECK(air.peak() == 0);
    for (double c : {-1.0, -0.9, -0.3, 0.0, 0.5, 0.99, 1.0}) {
        check_equal(aerosol.smooth(c), F(c), 1e-9);
        check_equal(air.smooth(c), rayleigh_matrix(0.03)(c), 1e-12);
    }
}
