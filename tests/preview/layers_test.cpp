// layers_test.cpp — means over squares of pixels, by hand.
// SPDX-License-Identifier: Apache-2.0
#include "preview/layers.h"

#include "support/catch.h"

using namespace malus::preview;

namespace {

// Two pixels side by side, of S = (1, 0.6, 0) and (3, 0, 0.6), and below them two without light.
Layers four_pixels() {
    Layers layers;
    layers.width = layers.height = 2;
    layers.wavelength_nm = 440;
    layers.s0 = {1, 3, 0, 0};
    layers.dolp = {0.6f, 0.2f, 0, 0};
    layers.aolp_deg = {0, 45, 0, 0};
    layers.s1_s0 = {0.6f, 0, 0, 0};
    layers.s2_s0 = {0, 0.2f, 0, 0};
    layers.stderr_s0 = {0.3f, 0.4f, 0, 0};
    layers.stderr_dolp = {0.06f, 0.01f, 0, 0};
    layers.stderr_aolp_deg = {3, 4, 90, 90};
    layers.coverage = {1, 0.5f, 0, 0};
    return layers;
}

}  // namespace

TEST_CASE("Layers of a large image: a square shows its mean Stokes vector and that mean's errors") {
    const Layers one = reduced(four_pixels(), 2);
    REQUIRE(one.width == 1);
    REQUIRE(one.height == 1);
    CHECK(one.s0[0] == 1);
    // The sum of the vectors is (4, 0.6, 0.6).
    CHECK(one.s1_s0[0] == near(0.15, 1e-7));
    CHECK(one.s2_s0[0] == near(0.15, 1e-7));
    CHECK(one.dolp[0] == near(0.15 * std::sqrt(2.0), 1e-7));
    CHECK(one.aolp_deg[0] == near(22.5, 1e-5));
    CHECK(one.coverage[0] == 0.375f);
    CHECK(one.stderr_s0[0] == near(0.5 / 4, 1e-7));  // 3-4-5
    CHECK(one.stderr_dolp[0] == near(std::hypot(0.06, 0.03) / 4, 1e-7));
    // Polarized light of 0.6 each; its vectors stand at right angles.
    CHECK(one.stderr_aolp_deg[0] == near(0.6 * 5 / (0.6 * std::sqrt(2.0)), 1e-5));
    CHECK(one.wavelength_nm == 440);
}

TEST_CASE("Layers of a large image: squares at the edges are smaller, and without light all is 0") {
    Layers layers = four_pixels();
    CHECK(reduced(layers, 1).s0 == layers.s0);
    layers.width = 1, layers.height = 4;
    const Layers two = reduced(layers, 3);
    REQUIRE(two.width == 1);
    REQUIRE(two.height == 2);
    CHECK(two.s0[0] == near(4 / 3.0, 1e-6));
    CHECK(two.s0[1] == 0);
    CHECK(two.dolp[1] == 0);
    CHECK(two.s1_s0[1] == 0);
    CHECK(two.stderr_dolp[1] == 0);
    layers.stderr_s0.clear(), layers.stderr_dolp.clear(), layers.stderr_aolp_deg.clear();
    CHECK_FALSE(reduced(layers, 3).has_errors());
}

TEST_CASE("Layers of a large image: n equal pixels have an error of 1/sqrt n") {
    Layers layers;
    layers.width = layers.height = 4;
    layers.s0.assign(16, 2);
    layers.dolp.assign(16, 0.3f);
    layers.aolp_deg.assign(16, 90);
    layers.s1_s0.assign(16, -0.3f);
    layers.s2_s0.assign(16, 0);
    layers.stderr_s0.assign(16, 0.2f);
    layers.stderr_dolp.assign(16, 0.1f);
    layers.stderr_aolp_deg.assign(16, 8);
    const Layers one = reduced(layers, 4);
    CHECK(one.dolp[0] == near(0.3, 1e-6));
    CHECK(one.aolp_deg[0] == near(90, 1e-4));
    CHECK(one.stderr_s0[0] == near(0.05, 1e-7));
    CHECK(one.stderr_dolp[0] == near(0.025, 1e-7));
    CHECK(one.stderr_aolp_deg[0] == near(2, 1e-5));
    // Where nothing is known of one of the angles, little light is polarized.
    layers.dolp[0] = 0, layers.s1_s0[0] = 0, layers.stderr_aolp_deg[0] = 90;
    CHECK(reduced(layers, 4).stderr_aolp_deg[0] == near(8 * std::sqrt(15.0) / 15, 1e-5));
}
