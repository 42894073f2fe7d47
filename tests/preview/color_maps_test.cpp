// color_maps_test.cpp — the colour maps, judged by OKLab written down a second time.
//
//   8-bit sRGB → linear (IEC 61966-2-1) → XYZ → LMS by M1 → cube root → Lab by M2
//
// The program goes the other way, with one matrix for LMS to sRGB; here M1 and M2 are applied to
// XYZ as in "The color space" of Ottosson's page, so an error in either shows.
// Source  B. Ottosson (2020), https://bottosson.github.io/posts/oklab/
// SPDX-License-Identifier: Apache-2.0
#include "preview/color_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "support/catch.h"

namespace {

using namespace malus::preview;
using Vec = std::array<double, 3>;
using Matrix = std::array<Vec, 3>;

// sRGB to XYZ, D65: IEC 61966-2-1, equation F.7 with its seven digits.
constexpr Matrix kXyzFromRgb{{{0.4124564, 0.3575761, 0.1804375},
                              {0.2126729, 0.7151522, 0.0721750},
                              {0.0193339, 0.1191920, 0.9503041}}};
// XYZ to linear sRGB: the inverse, IEC 61966-2-1, with its four digits.
constexpr Matrix kRgbFromXyz{
    {{3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}}};
constexpr Matrix kM1{{{0.8189330101, 0.3618667424, -0.1288597137},
                      {0.0329845436, 0.9293118715, 0.0361456387},
                      {0.0482003018, 0.2643662691, 0.6338517070}}};
constexpr Matrix kM2{{{0.2104542553, 0.7936177850, -0.0040720468},
                      {1.9779984951, -2.4285922050, 0.4505937099},
                      {0.0259040371, 0.7827717662, -0.8086757660}}};

Vec times(const Matrix& m, const Vec& v) {
    Vec result{};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t i = 0; i < 3; ++i) result[row] += m[row][i] * v[i];
    return result;
}

OkLab lab_of_xyz(const Vec& xyz) {
    Vec lms = times(kM1, xyz);
    for (double& x : lms) x = std::cbrt(x);
    const Vec lab = times(kM2, lms);
    return {lab[0], lab[1], lab[2]};
}

OkLab lab_of(const Color& c) {
    const auto linear = [](std::uint8_t code) {
        const double e = code / 255.0;
        return e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4);
    };
    return lab_of_xyz(times(kXyzFromRgb, {linear(c.r), linear(c.g), linear(c.b)}));
}

Color shown(const OkLab& lab) {
    return to_color(linear_rgb(lab));
}

double chroma(const OkLab& lab) {
    return std::hypot(lab.a, lab.b);
}

double distance(const OkLab& p, const OkLab& q) {
    return std::hypot(p.L - q.L, p.a - q.a, p.b - q.b);
}

}  // namespace

TEST_CASE("OKLab as printed on Ottosson's page gives back the XYZ it belongs to", "[unit]") {
    struct Row {
        Vec xyz;
        OkLab lab;  // the page's table of test values, three decimals
    };
    const std::array<Row, 4> rows{{{{0.950, 1.000, 1.089}, {1.000, 0.000, 0.000}},
                                   {{1, 0, 0}, {0.450, 1.236, -0.019}},
                                   {{0, 1, 0}, {0.922, -0.671, 0.263}},
                                   {{0, 0, 1}, {0.153, -1.415, -0.449}}}};
    for (const Row& row : rows) {
        CHECK(distance(lab_of_xyz(row.xyz), row.lab) < 1e-3);
        const LinearRgb got = linear_rgb(row.lab);
        const Vec expected = times(kRgbFromXyz, row.xyz);
        // Half a unit of the third decimal, times the slope of the cube and of the matrices.
        CHECK(got.r == near(expected[0], 0.02));
        CHECK(got.g == near(expected[1], 0.02));
        CHECK(got.b == near(expected[2], 0.02));
    }
}

TEST_CASE("OKLab to sRGB and the second way back agree to a step of 8 bits", "[unit]") {
    for (int r = 0; r < 256; r += 51)
        for (int g = 0; g < 256; g += 51)
            for (int b = 0; b < 256; b += 51) {
                const Color c{static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g),
                              static_cast<std::uint8_t>(b)};
                const Color back = shown(lab_of(c));
                CHECK(std::abs(back.r - c.r) <= 1);
                CHECK(std::abs(back.g - c.g) <= 1);
                CHECK(std::abs(back.b - c.b) <= 1);
            }
}

TEST_CASE("The sRGB curve and its inverse undo each other and halve light at code 188", "[unit]") {
    for (int code = 0; code < 256; ++code)
        CHECK(srgb_from_linear(linear_from_srgb(code / 255.0)) == near(code / 255.0, 1e-7));
    CHECK(255 * srgb_from_linear(0.5) == near(187.5, 0.1));  // known: 50 % light is 188
}

TEST_CASE("Sequential map: lightness rises in even steps", "[unit]") {
    constexpr int kSteps = 40;
    const double first = lab_of(shown(sequential(0))).L, last = lab_of(shown(sequential(1))).L;
    CHECK(last - first > 0.75);
    for (int i = 0; i <= kSteps; ++i) {
        const double t = static_cast<double>(i) / kSteps;
        // 8 bits leave up to 0.004 of lightness in the darkest colours.
        CHECK(lab_of(shown(sequential(t))).L == near(first + t * (last - first), 0.005));
    }
}

TEST_CASE("Sequential map: no two of 41 even steps differ in size by more than a factor 2.5",
          "[unit]") {
    double least = 1, most = 0;
    for (int i = 0; i < 40; ++i) {
        const double step = distance(sequential(i / 40.0), sequential((i + 1) / 40.0));
        least = std::min(least, step);
        most = std::max(most, step);
    }
    CHECK(most < 2.5 * least);
}

TEST_CASE("Sequential map: what lies outside 0 to 1 looks like the nearer end", "[unit]") {
    CHECK(shown(sequential(-0.5)) == shown(sequential(0)));
    CHECK(shown(sequential(1.5)) == shown(sequential(1)));
}

TEST_CASE("Cyclic map: constant lightness and chroma within 0.01", "[unit]") {
    for (double aolp_deg = 0; aolp_deg < 180; aolp_deg += 0.5) {
        const OkLab lab = lab_of(shown(cyclic(aolp_deg)));
        CHECK(lab.L == near(0.74, 0.01));
        CHECK(chroma(lab) == near(0.125, 0.01));
    }
}

TEST_CASE("Cyclic map: 0 and 180 degrees are one colour, perpendicular angles opposite ones",
          "[unit]") {
    CHECK(shown(cyclic(0)) == shown(cyclic(180)));
    CHECK(distance(cyclic(0), cyclic(179.99)) < 1e-4);
    for (double aolp_deg = 0; aolp_deg < 90; aolp_deg += 15)
        CHECK(distance(cyclic(aolp_deg), cyclic(aolp_deg + 90)) == Approx(2 * 0.125));
}

TEST_CASE("Cyclic map: without vividness all angles are one neutral grey", "[unit]") {
    const Color grey = shown(cyclic(0, 0));
    CHECK(grey.r == grey.g);
    CHECK(grey.g == grey.b);
    CHECK(shown(cyclic(77, 0)) == grey);
    CHECK(lab_of(grey).L == near(0.74, 0.01));
}

TEST_CASE("Diverging map: white in the middle, both sides equally light, blue below, red above",
          "[unit]") {
    const OkLab white = lab_of(shown(diverging(0)));
    CHECK(white.L > 0.96);
    CHECK(chroma(white) < 0.003);
    for (double t = 0.1; t <= 1; t += 0.1) {
        const OkLab low = lab_of(shown(diverging(-t))), high = lab_of(shown(diverging(t)));
        CHECK(low.L == near(high.L, 0.005));
        CHECK(high.L == near(white.L - 0.42 * t, 0.01));
        CHECK(shown(diverging(t)).r > shown(diverging(t)).b);
        CHECK(shown(diverging(-t)).b > shown(diverging(-t)).r);
        CHECK(chroma(high) > 0.15 * t);
        CHECK(chroma(low) > 0.15 * t);
    }
    CHECK(shown(diverging(-3)) == shown(diverging(-1)));
    CHECK(shown(diverging(3)) == shown(diverging(1)));
}

TEST_CASE("Combined map: hue by angle and strength by polarization at any radiance", "[unit]") {
    for (double lightness : {0.0, 0.3, 1.0})
        for (double aolp_deg = 0; aolp_deg < 180; aolp_deg += 15) {
            const OkLab full = lab_of(shown(combined(aolp_deg, 1, lightness)));
            CHECK(chroma(full) == near(0.1, 0.01));
            const OkLab hue = cyclic(aolp_deg);
            CHECK((full.a * hue.a + full.b * hue.b) / (chroma(full) * chroma(hue)) > 0.995);
        }
    // In the dark, what is strongly polarized is seen, and what is not stays dark.
    CHECK(lab_of(shown(combined(30, 1, 0))).L > 0.55);
    CHECK(shown(combined(30, 0, 0)) == Color{0, 0, 0});
    // Brighter light never looks darker.
    for (double p : {0.0, 0.5, 1.0})
        for (int l = 0; l < 10; ++l)
            CHECK(combined(30, p, (l + 1) / 10.0).L > combined(30, p, l / 10.0).L);
}

TEST_CASE("All maps stay in the gamut of sRGB", "[unit]") {
    for (int i = 0; i <= 1000; ++i) {
        CHECK(in_gamut(linear_rgb(cyclic(0.18 * i))));
        CHECK(in_gamut(linear_rgb(diverging(0.002 * i - 1))));
    }
    std::size_t outside = 0;
    for (int angle = 0; angle < 180; angle += 3)
        for (int p = 0; p <= 20; ++p)
            for (int l = 0; l <= 20; ++l)
                outside += !in_gamut(linear_rgb(combined(angle, p / 20.0, l / 20.0)));
    CHECK(outside == 0);
}

TEST_CASE("Fitting to the gamut keeps lightness and hue and takes no more chroma than it must",
          "[unit]") {
    const double hue = 150;
    const OkLab fitted = fit_to_gamut(0.5, 0.4, hue);
    CHECK(in_gamut(linear_rgb(fitted)));
    CHECK(fitted.L == 0.5);
    CHECK(std::atan2(fitted.b, fitted.a) * 180 / std::acos(-1.0) == Approx(hue));
    CHECK_FALSE(in_gamut(linear_rgb({fitted.L, 1.001 * fitted.a, 1.001 * fitted.b})));
    CHECK(chroma(fit_to_gamut(0.5, 0.05, hue)) == Approx(0.05));  // fits as it is
}

TEST_CASE("Angles are vivid up to 5 degrees of error and grey from 30 or below 3 sigma of DoLP",
          "[unit]") {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    CHECK(vividness(4.9, 0.5, 0.01) == 1);
    CHECK(vividness(17.5, 0.5, 0.01) == Approx(0.5));  // halfway from 5 to 30
    CHECK(vividness(30, 0.5, 0.01) == 0);
    CHECK(vividness(1, 0.0299, 0.01) == 0);
    CHECK(vividness(0, 0.5, 0) == 1);  // exact images have no error
    CHECK(vividness(kNan, 0.5, 0.01) == 0);
    CHECK(vividness(1, 0.5, kNan) == 0);
}
