// error_curve_test.cpp — deviations from a reference, slopes and times of error curves.
// SPDX-License-Identifier: Apache-2.0
#include "tools/error_curve.h"

#include "support/catch.h"

using namespace malus;

namespace {

// error = 0.5 N^-0.8 and 0.1 s for 1000 samples, in doublings from 8: a power law of both.
ErrorCurve power_law(int points) {
    ErrorCurve curve;
    for (int i = 0; i < points; ++i) {
        const double samples = 8 << i;
        curve.push_back({samples, 1e-4 * samples, 0.5 * std::pow(samples, -0.8)});
    }
    return curve;
}

// Pixels with these S0 and S1 at 440 and 600 nm, S0 = 1 at 600 nm; the last shows only the sky.
Film film_of(const std::vector<std::pair<double, double>>& pixels) {
    Film film(static_cast<int>(pixels.size()), 1, {440, 600});
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        film.stokes[2 * i].mean = {pixels[i].first, pixels[i].second, 0, 0};
        film.stokes[2 * i + 1].mean = {1, 0, 0, 0};
        film.coverage[i] = i + 1 < pixels.size() ? 1 : 0;
    }
    return film;
}

}  // namespace

TEST_CASE("Error curves: a power law's slope is its exponent, against samples and seconds") {
    for (int points : {3, 4, 12}) {
        const ErrorCurve curve = power_law(points);
        for (double CurvePoint::*work : {&CurvePoint::samples, &CurvePoint::seconds}) {
            const auto line = slope(curve, work);
            REQUIRE(line);
            CHECK(line->value == Approx(-0.8).epsilon(1e-12));
            CHECK(line->error < 1e-7);
        }
    }
    CHECK_FALSE(slope(power_law(2), &CurvePoint::samples));
}

TEST_CASE("Error curves: the slope is of the last half, with the standard error of the line") {
    // Flat, then points about a line of log2: y = 3, 2, 3, 0 at x = 0 to 3. By hand: slope −4/5,
    // squares of the residuals 6 − 16/5 = 14/5, standard error √(14/5 / 2 / 5) = √0.28.
    ErrorCurve curve;
    for (double x : {-4., -3., -2., -1.}) curve.push_back({std::exp2(x), std::exp2(x), 1000});
    const std::array<double, 4> y{3, 2, 3, 0};
    for (int x = 0; x < 4; ++x)
        curve.push_back({std::exp2(x), std::exp2(x), std::exp2(y[static_cast<std::size_t>(x)])});
    const auto line = slope(curve, &CurvePoint::samples);
    REQUIRE(line);
    CHECK(line->value == Approx(-0.8));
    CHECK(line->error == Approx(std::sqrt(0.28)));
}

TEST_CASE("Error curves: the time to an error is the power law's, within the curve and beyond") {
    // 0.5 (t/1e-4)^-0.8 = e at t = 1e-4 (0.5/e)^1.25.
    const auto closed = [](double error) { return 1e-4 * std::pow(0.5 / error, 1.25); };
    const ErrorCurve curve = power_law(8);  // 0.095 to 0.00194
    const TimeTo inside = time_to(curve, 0.01), beyond = time_to(curve, 1e-4);
    CHECK(inside.kind == TimeTo::Kind::kMeasured);
    CHECK(inside.seconds == Approx(closed(0.01)));
    CHECK(beyond.kind == TimeTo::Kind::kExtrapolated);
    CHECK(beyond.seconds == Approx(closed(1e-4)));
    CHECK(time_to(curve, 0.5).kind == TimeTo::Kind::kSooner);
    CHECK(time_to(curve, 0.5).seconds == Approx(8e-4));
}

TEST_CASE("Error curves: an error counts as reached only when it is no more exceeded") {
    const ErrorCurve curve{{1, 1, 0.1}, {2, 2, 0.01}, {4, 4, 0.04}, {8, 8, 0.01}};
    CHECK(time_to(curve, 0.02).seconds == Approx(4 * std::sqrt(2)));
}

TEST_CASE("Error curves: without a fall nothing is extrapolated") {
    const ErrorCurve flat{{1, 1, 0.1}, {2, 2, 0.1}, {4, 4, 0.1}, {8, 8, 0.1}};
    CHECK(time_to(flat, 0.01).kind == TimeTo::Kind::kUnknown);
    CHECK(time_to({}, 0.01).kind == TimeTo::Kind::kUnknown);
    CHECK(time_to(power_law(2), 1e-4).kind == TimeTo::Kind::kUnknown);
}

TEST_CASE("Error curves: the figure of merit of N^-1/2 does not depend on N") {
    // 1/(σ²T) with σ = 0.2 N^-½ and T = N/1000: 25 × 1000.
    for (double n : {8., 8192.})
        CHECK(figure_of_merit({n, n / 1000, 0.2 / std::sqrt(n)}) == Approx(25000));
}

TEST_CASE("Error curves: they end at the first point within reach of the reference's error") {
    const ErrorCurve curve = cut_below({{1, 1, 4}, {2, 2, 1}, {4, 4, 3}, {8, 8, 0.5}}, 2);
    REQUIRE(curve.size() == 1);
    CHECK(curve.front().error == 4);
}

TEST_CASE("Deviations: relative in S0, absolute in DoLP, of surfaces only, the right wavelength") {
    const Film truth = film_of({{1, 0.5}, {2, 0}, {4, 0}, {1, 0}});
    Film other = film_of({{1.1, 0.55}, {1.8, 0.36}, {4, 0.4}, {9, 9}});
    Deviations deviations;
    add_deviations(other, 0, truth, deviations);
    const Errors errors = summarize(deviations);
    CHECK(errors[0] == Approx(std::sqrt(0.02 / 3)));  // S0: 0.1, 0.1, 0
    CHECK(errors[1] == Approx(0.1));
    CHECK(errors[3] == Approx(std::sqrt(0.05 / 3)));  // DoLP: 0, 0.2, 0.1
    CHECK(errors[4] == Approx(0.1));
    CHECK(errors[5] == Approx(0.2));
    Film single(4, 1, {600});  // finds its wavelength in the reference
    for (PixelStokes& pixel : single.stokes) pixel.mean = {1.25, 0, 0, 0};
    Deviations of_single;
    add_deviations(single, 0, truth, of_single);
    CHECK(summarize(of_single)[0] == Approx(0.25));
    CHECK(worst({errors, summarize(of_single)}) ==
          Errors{0.25, 0.25, 0.25, errors[3], 0.1, errors[5]});
}

TEST_CASE("Deviations: those expected of a film are normal deviates of its error bars") {
    Film film(2500, 1, {440});
    for (PixelStokes& pixel : film.stokes) {
        pixel.mean = {2, 0, 0, 0};
        pixel.covariance[0] = 0.04f * 0.04f;  // 2 % of S0
    }
    std::fill(film.coverage.begin(), film.coverage.end(), 1.f);
    const Errors errors = summarize(expected_deviations(film, 0));
    // Of 40 000 deviates: standard errors 0.35 %, 0.6 % and 0.5 %; 4 of them each.
    CHECK(errors[0] == Approx(0.02).epsilon(0.014));
    CHECK(errors[1] == Approx(0.6745 * 0.02).epsilon(0.024));  // quartile of the normal
    CHECK(errors[2] == Approx(1.9600 * 0.02).epsilon(0.02));   // its 2.5 %
    CHECK(errors[3] == 0);
}

TEST_CASE("Deviations: a pixel that one sample of the reference carries judges nobody") {
    // C00 = S0²: all light is in one of the replicates (film.h: m = 1).
    Film truth = film_of({{1, 0}, {1, 0}, {1, 0}});
    truth.stokes[0].covariance[0] = 1;
    const Film other = film_of({{9, 9}, {1.1, 0}, {1, 0}});
    Deviations deviations;
    add_deviations(other, 0, truth, deviations);
    REQUIRE(deviations.s0.size() == 1);
    CHECK(deviations.s0.front() == Approx(0.1));
    CHECK(deviations.dolp == std::vector<double>{0});
    CHECK(unknown_pixels(truth) == 1);
    CHECK(expected_deviations(truth, 0).dolp.size() ==
          expected_deviations(truth, 1).dolp.size() / 2);
}
