// material_check_test.cpp — reflectances and rules of paints.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/material_check.h"

#include "malus/core/frame.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using Catch::Contains;

namespace {

// By reciprocity the radiance of a panel under an even sky of 1 is its reflectance.
double reference_reflectance(const Material& material, double nm, double zenith_deg) {
    const Vec3 wo = direction(to_radians(zenith_deg), 0);
    return reference::panel(reference_paint(material, nm), {0, 1, 0}, wo, any_perpendicular(wo),
                            reference::uniform_sky(1), 1e-6)
        .value[0];
}

std::string all_of(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
}

}  // namespace

TEST_CASE("Reflectance: the shipped rows agree with the independent quadrature") {
    for (const Material* paint : {&green_paint(), &black_paint()})
        for (const MaterialRow& row : paint->rows)
            for (double zenith : {0.0, 45.0, 75.0, 89.0}) {
                const Reflectance found = reflectance(*paint, row, zenith);
                CAPTURE(paint->name, row.wavelength_nm, zenith, found.error);
                CHECK(
                    found.value ==
                    Approx(reference_reflectance(*paint, row.wavelength_nm, zenith)).epsilon(2e-3));
                CHECK(found.error < 5e-3 * found.value);
            }
}

TEST_CASE("Reflectance: a matte paint reflects its albedo at every angle") {
    const Material matte = lambertian(0.6);
    for (double zenith : {0.0, 60.0, 89.0})
        CHECK(reflectance(matte, matte.rows[0], zenith).value == Approx(0.6).epsilon(1e-6));
}

TEST_CASE("Reflectance: bare perfect facets exceed 1 at grazing, attenuated ones do not") {
    // Rs = Rp = 1 of k = 1e6, B = 1, σ = 0.1288 at 89°: 3.39 bare and 0.975 attenuated, by a
    // midpoint sum over slopes made apart from this program.
    const PriestGermer<double> perfect{1, 1e6, 1, 0.1288, 1, 0, 0, 0};
    const Material bare = single_row("bare", perfect);
    const Material attenuated =
        single_row("attenuated", perfect, Slopes::kGaussian, Attenuation::kTorranceSparrow);
    CHECK(reflectance(bare, bare.rows[0], 89).value == Approx(3.39).epsilon(0.005));
    CHECK(reflectance(attenuated, attenuated.rows[0], 89).value == Approx(0.975).epsilon(0.005));
    CHECK_THAT(all_of(verdicts(bare, check_row(bare, bare.rows[0]))),
               Contains("reflects more than it receives") && Contains("torrance-sparrow"));
    CHECK_THAT(all_of(verdicts(attenuated, check_row(attenuated, attenuated.rows[0]))),
               Contains("reflects at most"));
}

TEST_CASE("Rules: the published rows' faults are found and named") {
    // Green 550 nm as printed: f00 < 0 in 96.4 % of directions, worked out apart.
    const RowCheck green = check_row(green_paint(), green_paint().rows[1]);
    CHECK(green.share_negative == near(0.964, 0.01));
    CHECK_THAT(all_of(verdicts(green_paint(), green)), Contains("negative in 96 %"));
    const RowCheck black = check_row(black_paint(), black_paint().rows[0]);
    CHECK(black.share_negative == 0);
    CHECK(black.least_f00 > 0);
    for (const RowCheck& check : {green, black}) {
        CHECK(check.most_dop <= 1 + 1e-12);
        CHECK(check.reciprocity_error < 1e-12);
    }
}
