// quantity_test.cpp — quantities and their errors, by hand.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/quantity.h"

#include "malus/core/error.h"
#include "support/catch.h"

using namespace malus;
using Catch::Contains;

namespace {

Image one_pixel() {
    Image image;
    image.width = image.height = 1;
    for (const auto& [name, value] : {std::pair("S0", 2.f),
                                      {"S1", 0.6f},
                                      {"S2", -0.8f},
                                      {"S3", 0.1f},
                                      {"StdErr_S0", 0.2f},
                                      {"StdErr_S1", 0.1f},
                                      {"Cov_S0S1", 0.004f}})
        image.channel(std::string(name) + ".550,000000nm") = {value};
    return image;
}

}  // namespace

TEST_CASE("Quantity: what the image lacks follows from its Stokes vectors") {
    const Image image = one_pixel();
    CHECK(read_quantity(image, "DoLP", 550).value[0] == near(0.5, 1e-7));  // |(0.6, −0.8)|/2
    const Quantity aolp = read_quantity(image, "AoLP", 550);
    // ½ atan2(−0.8, 0.6) = −26.565051177° (half the angle of a 3-4-5 triangle), folded.
    CHECK(aolp.value[0] == near(180 - 26.565051177, 1e-5));
    CHECK(aolp.period == 180);
    CHECK(aolp.error.empty());
    const Quantity q = read_quantity(image, "S1/S0", 550);
    CHECK(q.value[0] == near(0.3, 1e-7));
    // (0.01 − 2·0.3·0.004 + 0.09·0.04)/4
    CHECK(q.error[0] == near(std::sqrt((0.01 - 0.0024 + 0.0036) / 4), 1e-7));
    CHECK(read_quantity(image, "S2/S0", 550).error.empty());
    CHECK(read_quantity(image, "S0", 550).error[0] == 0.2f);
    CHECK(read_quantity(image, "StdErr_S1", 550).value[0] == 0.1f);
    CHECK_THROWS_WITH(read_quantity(image, "S9", 550), Contains("'S9.550,000000nm' is missing"));
    CHECK_THROWS_WITH(wavelengths_of(image, {440}), Contains("no 440 nm") && Contains("550"));
    CHECK(wavelengths_of(image, {}) == std::vector<double>{550});
}

TEST_CASE("Quantity: angles differ by the shorter way round") {
    CHECK(difference(179, 1, 180) == near(-2, 1e-12));
    CHECK(difference(1, 179, 180) == near(2, 1e-12));
    CHECK(difference(90, 0, 180) == -90);
    CHECK(difference(3, 1, 0) == 2);
}
