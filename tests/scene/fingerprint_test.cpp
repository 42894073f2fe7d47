// fingerprint_test.cpp — what changes a picture changes its marks, and nothing else does.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/fingerprint.h"

#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

TEST_CASE("Fingerprint: of a scene, changed by what a ray could meet") {
    const Scene scene = panel_scene();
    const std::string mark = fingerprint(scene);
    CHECK(mark.size() == 16);
    CHECK(fingerprint(panel_scene()) == mark);
    Scene moved = scene;
    moved.instances[0].to_world.t.y += 1e-3;
    CHECK(fingerprint(moved) != mark);
    Scene bent = scene;
    bent.meshes[0].positions[0].x += 1e-3f;
    CHECK(fingerprint(bent) != mark);
    Scene renamed = scene;
    renamed.nodes[0].name += "x";
    CHECK(fingerprint(renamed) != mark);
    // Not by what a computed zero happens to be, nor by cameras that are not used.
    Scene rounded = scene;
    rounded.instances[0].to_world.x.y = 1e-17;
    rounded.cameras.emplace_back();
    CHECK(fingerprint(rounded) == mark);
}

TEST_CASE("Fingerprint: of paints, at the wavelengths in use") {
    const std::vector<double> both{440, 600};
    const std::string mark = fingerprint({green_paint()}, {0}, both);
    CHECK(fingerprint({black_paint(), green_paint()}, {1}, both) == mark);  // one is not in use
    CHECK(fingerprint({black_paint()}, {0}, both) != mark);
    CHECK(fingerprint({green_paint()}, {0}, std::vector<double>{440}) != mark);
    Material rougher = green_paint();
    rougher.rows[1].p.sigma *= 1.01;  // 550 nm
    CHECK(fingerprint({rougher}, {0}, both) == mark);
    rougher.rows[0].p.sigma *= 1.01;  // 440 nm
    CHECK(fingerprint({rougher}, {0}, both) != mark);
}

TEST_CASE("Fingerprint: of sky and view") {
    const std::vector<double> one{440};
    Sky sky = sample_sky(reference::uniform_sky(1), {440, 600}, 4, 8);
    const std::string mark = fingerprint(sky, one);
    sky.nodes.back().s0 *= 2;  // of 600 nm
    CHECK(fingerprint(sky, one) == mark);
    sky.nodes.front().s1 += 0.1;
    CHECK(fingerprint(sky, one) != mark);

    const Camera camera = look_at({0, 0, 0}, 30, 20, 1);
    Camera turned = camera;
    turned.name = "other";
    CHECK(fingerprint(turned) == fingerprint(camera));
    turned.right = camera.up, turned.up = -camera.right;
    CHECK(fingerprint(turned) != fingerprint(camera));
}

TEST_CASE("Fingerprint: with and without the sun's disc") {
    const std::vector<double> one{440};
    Sky sky = sample_sky(reference::uniform_sky(1), one, 4, 8);
    const std::string dark = fingerprint(sky, one);
    sky.sun = Sun{0.5, 1, {1.2}};
    const std::string sunny = fingerprint(sky, one);
    CHECK(sunny != dark);
    sky.sun->irradiance[0] = 1.3;
    CHECK(fingerprint(sky, one) != sunny);
    sky.sun->irradiance.clear();  // only says where the sun is: no light
    CHECK(fingerprint(sky, one) == dark);
}
