// fresnel_test.cpp — reflection of a plane facet.
// SPDX-License-Identifier: Apache-2.0
#include "malus/optics/fresnel.h"

#include <complex>

#include "support/catch.h"

using namespace malus;

namespace {

FacetMueller<double> at(double n, double k, double beta_deg) {
    return fresnel(n, k, std::cos(to_radians(beta_deg)));
}

// rs and rp from Snell's law in complex arithmetic, another road than fresnel.h's.
struct Amplitudes {
    std::complex<double> rs, rp;
};
Amplitudes amplitudes(double n, double k, double beta) {
    const std::complex<double> N(n, k), t = std::asin(std::sin(beta) / N);
    const std::complex<double> c = std::cos(beta), ct = std::cos(t);
    return {(c - N * ct) / (c + N * ct), (N * c - ct) / (N * c + ct)};
}

}  // namespace

TEST_CASE("Fresnel: green paint at 550 nm reflects and polarizes as computed independently") {
    // R, DoLP and arg(rs rp*) of Born & Wolf's formulas for N = 1.366 + 0.2746i, worked out apart.
    CHECK(at(1.366, 0.2746, 0).a() == near(0.0369, 5e-5));
    const auto m45 = at(1.366, 0.2746, 45), m60 = at(1.366, 0.2746, 60);
    CHECK(m45.a() == near(0.0482, 5e-5));
    CHECK(m45.b() / m45.a() == near(0.837, 5e-4));
    CHECK(m60.a() == near(0.0910, 5e-5));
    CHECK(m60.b() / m60.a() == near(0.915, 5e-4));
    CHECK(to_degrees(std::atan2(m45.im, m45.re)) == near(155.63, 5e-3));
    CHECK(to_degrees(std::atan2(m60.im, m60.re)) == near(47.19, 5e-3));
}

TEST_CASE("Fresnel: light at 0° and 45° leaves a facet as Mitsuba 3.8 has it, signs included") {
    const Stokes<double> S = at(1.366, 0.2746, 60) * Stokes<double>{0.5, 0, 0.5, 0};
    CHECK(S.s0 == near(0.04550, 5e-6));
    CHECK(S.s1 == near(0.04164, 5e-6));
    CHECK(S.s2 == near(0.01246, 5e-6));
    CHECK(S.s3 == near(0.01345, 5e-6));
}

TEST_CASE("Fresnel: amplitudes agree with Snell's law in complex arithmetic") {
    for (double n : {0.2, 1.0, 1.125, 1.366, 2.5})
        for (double k : {0.0, 0.01, 0.2746, 1.0, 10.0})
            for (double beta : {0.0, 0.3, 0.7, 1.2, 1.55}) {
                // asin leaves the principal branch of √ past the critical angle without loss.
                if (k == 0 && std::sin(beta) >= n) continue;
                if (n == 1 && k == 0) continue;
                const auto [rs, rp] = amplitudes(n, k, beta);
                const auto m = fresnel(n, k, std::cos(beta));
                CAPTURE(n, k, beta);
                CHECK(m.Rs == near(std::norm(rs), 1e-14));
                CHECK(m.Rp == near(std::norm(rp), 1e-14));
                CHECK(m.re == near((rs * std::conj(rp)).real(), 1e-13));
                CHECK(m.im == near((rs * std::conj(rp)).imag(), 1e-13));
            }
}

TEST_CASE("Brewster: reflected light is fully s-polarized") {
    const double brewster = to_degrees(std::atan(1.5));
    for (double beside : {0.0, 1e-3, 1e-6, 1e-12}) {
        const Stokes<double> S = at(1.5, 0, brewster + beside) * Stokes<double>{1, 0, 0, 0};
        // rp = (n⁴ − 1)/(2n³) δ to lowest order in the distance δ to Brewster's angle, and
        // DoLP = 1 − 2 Rp/Rs.
        const double rp = (std::pow(1.5, 4) - 1) / (2 * std::pow(1.5, 3)) * to_radians(beside);
        const double Rs = sqr((1.5 * 1.5 - 1) / (1.5 * 1.5 + 1));
        CHECK(S.s1 / S.s0 == near(1 - 2 * rp * rp / Rs, 1e-14 + 1e-3 * rp * rp));
        CHECK(S.s0 == Approx(0.5 * sqr((1.5 * 1.5 - 1) / (1.5 * 1.5 + 1))).epsilon(0.001));
    }
}

TEST_CASE("Normal incidence: a mirror keeps S1 and flips S2 and S3") {
    const double R = (sqr(0.366) + sqr(0.2746)) / (sqr(2.366) + sqr(0.2746));
    for (const Stokes<double>& in :
         {Stokes<double>{1, 1, 0, 0}, Stokes<double>{1, 0, 1, 0}, Stokes<double>{1, 0, -1, 0},
          Stokes<double>{1, 0, 0, 1}, Stokes<double>{1, 0, 0, -1}, Stokes<double>{1, -1, 0, 0}}) {
        const Stokes<double> out = at(1.366, 0.2746, 0) * in;
        CHECK(out.s0 == Approx(R));
        CHECK(out.s1 == near(R * in.s1, 1e-15));
        CHECK(out.s2 == near(-R * in.s2, 1e-15));
        CHECK(out.s3 == near(-R * in.s3, 1e-15));
    }
}

TEST_CASE(
    "Total reflection: n < 1 without absorption reflects everything past the critical angle") {
    for (double beta : {60.0, 75.0, 89.0}) {
        const auto m = at(0.8, 0, beta);
        CHECK(m.a() == near(1, 1e-14));
        CHECK(std::hypot(m.re, m.im) == near(1, 1e-14));
    }
    // Born & Wolf eq. 1.5 (61): tan(δ/2) = cosβ √(sin²β − n²)/sin²β is the phase between p and s.
    const double b = to_radians(75),
                 delta = 2 * std::atan(std::cos(b) * std::sqrt(sqr(std::sin(b)) - 0.64) /
                                       sqr(std::sin(b)));
    const auto m = at(0.8, 0, 75);
    // rp has the opposite sign convention there, which turns the phase by 180°.
    CHECK(std::abs(std::remainder(std::atan2(m.im, m.re) - delta, kPi)) < 1e-12);
}

TEST_CASE("No contrast: n = 1, k = 0 reflects nothing at any angle") {
    for (double beta : {0.0, 45.0, 89.0, 89.999, 89.999999}) {
        const auto m = at(1, 0, beta);
        CHECK(std::abs(m.a()) + std::abs(m.b()) + std::abs(m.re) + std::abs(m.im) < 1e-14);
    }
}

TEST_CASE("No contrast: beside n = 1 a facet reflects (ε/2)² at normal incidence") {
    for (double beside : {1e-12, 1e-6, 1e-3, -1e-12, -1e-6, -1e-3}) {
        const double n = 1 + beside, epsilon = n - 1;
        // r = (1 − n)/(1 + n); the numerator is known to 1e-16.
        CHECK(at(n, 0, 0).a() == Approx(sqr(epsilon / (2 + epsilon))).epsilon(1e-3));
        CHECK(std::abs(at(n, 0, 0).b()) < 1e-3 * at(n, 0, 0).a() + 1e-30);
    }
    // k beside 0: r = −ik/(2 + ik).
    for (double k : {1e-12, 1e-6, 1e-3})
        CHECK(at(1, k, 0).a() == Approx(k * k / (4 + k * k)).epsilon(1e-9));
}

TEST_CASE("Total reflection: without absorption is the limit of ever less of it, phase included") {
    for (double beta : {54.0, 60.0, 75.0, 89.0}) {
        const auto m = at(0.8, 0, beta), limit = at(0.8, 1e-13, beta);
        CHECK(m.im == near(limit.im, 1e-9));
        CHECK(m.re == near(limit.re, 1e-9));
        CHECK(std::abs(m.im) > 1e-2);
    }
}

TEST_CASE("Critical angle: total at and beyond it, and short of it by √ of the distance") {
    const double critical = std::asin(0.8);
    for (double beside : {0.0, 1e-12, 1e-6, 1e-3}) {
        const auto beyond = fresnel(0.8, 0.0, std::cos(critical + beside));
        // At the angle itself rounding may fall to either side.
        CHECK(beyond.Rs == near(1, beside == 0 ? 1e-7 : 1e-14));
        CHECK(beyond.Rp == near(1, beside == 0 ? 1e-7 : 1e-14));
        // Rs = 1 − 4 g/cosβ + …, g = √(2δ sinβ cosβ): to lowest order in the distance δ.
        const auto before = fresnel(0.8, 0.0, std::cos(critical - beside));
        const double g = std::sqrt(2 * beside * 0.8 * 0.6);
        CHECK(1 - before.Rs == Approx(4 * g / 0.6).epsilon(0.2).margin(1e-7));
        CHECK(1 - before.Rp == Approx(4 * g / (0.64 * 0.6)).epsilon(0.3).margin(2e-7));
    }
}

TEST_CASE("Physicality: a facet never makes light more than fully polarized") {
    for (double n : {0.1, 0.9, 1.0, 1.5, 4.0})
        for (double k : {0.0, 1e-6, 0.3, 10.0})
            for (double beta = 0; beta < 89.9; beta += 3.7) {
                const auto m = at(n, k, beta);
                CHECK(m.a() <= 1 + 1e-15);
                for (const Stokes<double>& in :
                     {Stokes<double>{1, 0, 0, 0}, Stokes<double>{1, 1, 0, 0},
                      Stokes<double>{1, -1, 0, 0}, Stokes<double>{1, 0, 1, 0},
                      Stokes<double>{1, 0, -1, 0}, Stokes<double>{1, 0, 0, 1},
                      Stokes<double>{1, 0.6, 0, -0.8}}) {
                    const Stokes<double> out = m * in;
                    CHECK(out.s0 >= 0);
                    CHECK(dop(out) <= 1 + 1e-12);
                }
            }
}
