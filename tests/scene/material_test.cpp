// material_test.cpp — paints between their rows, and onto the scene.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/material.h"

#include "malus/core/error.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

// target (hull, wheel) and ground, with glTF materials "paint_a" and "paint_b".
Scene small_scene() {
    Scene scene;
    scene.nodes = {{"target", -1}, {"hull", 0}, {"wheel", 0}, {"ground", -1}};
    scene.surfaces = {"paint_a", "paint_b"};
    Mesh hull, wheel, ground;
    hull.name = "hull_mesh", hull.surface = 0;
    wheel.name = "wheel_mesh", wheel.surface = 0;
    ground.name = "ground_mesh", ground.surface = 1;
    scene.meshes = {hull, wheel, ground};
    scene.instances = {{0, 1, {}}, {1, 2, {}}, {2, 3, {}}};
    return scene;
}

std::vector<Material> paints(const std::vector<std::string>& names) {
    std::vector<Material> out;
    for (const std::string& name : names) {
        out.push_back(lambertian(0.5));
        out.back().name = name;
    }
    return out;
}

}  // namespace

TEST_CASE("Paint: between rows parameters are linear, τ and Ω in radians whatever their unit") {
    const auto a = parameters_at(green_paint(), 440), b = parameters_at(green_paint(), 550);
    const auto mid = parameters_at(green_paint(), 495);
    CHECK(mid.n == Approx((1.3766 + 1.366) / 2));
    CHECK(mid.sigma == Approx((0.468383 + 0.1288) / 2));
    CHECK(mid.rho_v == Approx((0.001769 - 1.285e-3) / 2));
    // Ω: 1.68383 rad and 149.9°.
    CHECK(1 / a.inv_omega == Approx(1.68383));
    CHECK(1 / b.inv_omega == Approx(149.9 * kPi / 180));
    CHECK(1 / mid.inv_omega == Approx((1.68383 + 149.9 * kPi / 180) / 2));
    CHECK(mid.tau == Approx((0.22121 + 87.89 * kPi / 180) / 2));
}

TEST_CASE("Paint: outside its rows there is an error that says what is covered") {
    CHECK_THROWS_WITH(parameters_at(green_paint(), 439.9),
                      Catch::Contains("439.9") && Catch::Contains("440 to 600"));
    CHECK(green_paint().covers(600));
    CHECK_FALSE(green_paint().covers(600.1));
}

TEST_CASE("Assigning: without rules each surface takes the paint of its own name") {
    CHECK(assign_paints(small_scene(), {}, paints({"paint_b", "paint_a"})) ==
          std::vector<int>{1, 1, 0});
}

TEST_CASE("Assigning: node before mesh before glTF material before the rest") {
    const auto book = paints({"paint_a", "x", "y", "z"});
    CHECK(assign_paints(small_scene(), {{"*", "x"}}, book) == std::vector<int>{1, 1, 1});
    CHECK(assign_paints(small_scene(), {{"*", "x"}, {"paint_a", "y"}}, book) ==
          std::vector<int>{2, 2, 1});
    CHECK(assign_paints(small_scene(), {{"*", "x"}, {"paint_a", "y"}, {"wheel_mesh", "z"}}, book) ==
          std::vector<int>{2, 3, 1});
    CHECK(assign_paints(small_scene(), {{"*", "x"}, {"target", "y"}, {"wheel_mesh", "z"}}, book) ==
          std::vector<int>{2, 2, 1});
    CHECK(assign_paints(small_scene(), {{"*", "x"}, {"target", "y"}, {"wheel", "z"}}, book) ==
          std::vector<int>{2, 3, 1});
}

TEST_CASE("Assigning: slips of the pen are named, with the nearest known name") {
    const auto book = paints({"paint_a", "paint_b"});
    CHECK_THROWS_WITH(assign_paints(small_scene(), {{"hul", "paint_a"}}, book),
                      Catch::Contains("did you mean 'hull'"));
    CHECK_THROWS_WITH(assign_paints(small_scene(), {{"hull", "paint_c"}}, book),
                      Catch::Contains("unknown material"));
    CHECK_THROWS_WITH(assign_paints(small_scene(), {}, paints({"paint_a"})),
                      Catch::Contains("'ground'") && Catch::Contains("--assign"));
}
