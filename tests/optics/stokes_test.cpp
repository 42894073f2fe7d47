// stokes_test.cpp — frames and turns of Stokes vectors.
// SPDX-License-Identifier: Apache-2.0
#include "malus/optics/stokes.h"

#include "malus/core/frame.h"
#include "support/catch.h"
#include "support/statistics.h"

using namespace malus;

namespace {

// Intensity behind an ideal linear polarizer whose axis lies at ψ from x toward y (Malus' law for
// Stokes vectors: ½(S0 + S1 cos2ψ + S2 sin2ψ), Goldstein, Polarized Light, 3rd ed., ch. 5).
double behind_polarizer(const Stokes<double>& S, double psi) {
    return 0.5 * (S.s0 + S.s1 * std::cos(2 * psi) + S.s2 * std::sin(2 * psi));
}

}  // namespace

TEST_CASE("Frames: a polarizer fixed in space passes the same light in every frame") {
    const Vec3 k = normalize(Vec3{0.3, -0.8, 0.5});
    const BeamFrame frame{k, any_perpendicular(k)};
    const Stokes<double> S{1.0, 0.4, -0.5, 0.3};
    for (double alpha : {0.0, 0.3, 1.2, 2.5, -0.7}) {
        const BeamFrame other{k, std::cos(alpha) * frame.x + std::sin(alpha) * frame.y()};
        const Stokes<double> T = measured_in(Beam<double>{S, frame}, other).stokes;
        for (double psi : {0.0, 0.4, 1.0, 2.0})
            CHECK(behind_polarizer(T, psi - alpha) == near(behind_polarizer(S, psi), 1e-14));
        CHECK(T.s3 == S.s3);
    }
}

TEST_CASE("Frames: light polarized along x has S1 > 0, at +45° toward y S2 > 0") {
    // Light fully polarized along the direction e, seen in a frame where e = x cos ψ + y sin ψ.
    const Vec3 k{0, 0, 1}, e{1, 0, 0};
    const Beam<double> beam{{1, 1, 0, 0}, {k, e}};
    const auto seen_from = [&](double turn) {
        return measured_in(beam, BeamFrame{k, {std::cos(turn), std::sin(turn), 0}}).stokes;
    };
    const double quarter = kPi / 4;
    // y = k × x = +Y here, so turning x by −45° puts e at +45° of it.
    CHECK(seen_from(-quarter).s2 == Approx(1));
    CHECK(seen_from(quarter).s2 == Approx(-1));
    CHECK(seen_from(2 * quarter).s1 == Approx(-1));
}

TEST_CASE("Frames: there and back again is where one was") {
    Uniform u(1);
    for (int i = 0; i < 100; ++i) {
        const Vec3 k = normalize(Vec3{u() - 0.5, u() - 0.5, u() - 0.5});
        const BeamFrame a{k, any_perpendicular(k)};
        const double alpha = 7 * u();
        const BeamFrame b{k, std::cos(alpha) * a.x + std::sin(alpha) * a.y()};
        const Beam<double> beam{{1, u() - 0.5, u() - 0.5, u() - 0.5}, a};
        const Stokes<double> back = measured_in(measured_in(beam, b), a).stokes;
        CHECK(back.s1 == near(beam.stokes.s1, 1e-14));
        CHECK(back.s2 == near(beam.stokes.s2, 1e-14));
        CHECK(dolp(measured_in(beam, b).stokes) == near(dolp(beam.stokes), 1e-14));
    }
}

TEST_CASE("AoLP: each quadrant of (S1, S2) has its angle, from 0° to below 180°") {
    const auto degrees = [](double s1, double s2) {
        return to_degrees(aolp(Stokes<double>{1, s1, s2, 0}));
    };
    CHECK(degrees(1, 0) == 0);
    CHECK(degrees(0, 1) == Approx(45));
    CHECK(degrees(-1, 0) == Approx(90));
    CHECK(degrees(0, -1) == Approx(135));
    CHECK(degrees(0.5, -0.5) == Approx(157.5));
    CHECK(degrees(1, -1e-300) == 0);
    CHECK(aolp(Stokes<double>{0, 0, 0, 0}) == 0);
    CHECK(dolp(Stokes<double>{0, 0, 0, 0}) == 0);
    CHECK(dop(Stokes<double>{2, 1, 1, 1}) == Approx(std::sqrt(3.0) / 2));
}
