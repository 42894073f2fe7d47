// bounces_test.cpp — light that is reflected more than once.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/frame.h"
#include "malus/io/gltf.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kOne{550};

// Ground of 2 m × 2 m and a wall of 2 m × 1 m at its northern edge, of one paint.
Scene corner_scene() {
    Scene scene;
    add_rectangle(scene, "ground", {-1, 0, 2}, {2, 0, 0}, {0, 0, -2});
    add_rectangle(scene, "wall", {-1, 0, 0}, {2, 0, 0}, {0, 1, 0});
    return scene;
}

reference::Rectangle ground(const reference::Paint& paint) {
    return {{-1, 0, 0}, {2, 0, 0}, {0, 0, 2}, {0, 1, 0}, paint};
}
reference::Rectangle wall(const reference::Paint& paint) {
    return {{-1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, paint};
}

void compare_corner(const Material& paint, const Vec3& p, double view_zenith_deg) {
    const Sky sky = sample_sky(smooth_sky(150), kOne, 180, 720);
    const PreparedScene prepared(corner_scene(), {0, 0}, {paint}, sky, kOne);
    const Camera camera = look_at(p, view_zenith_deg, 160, 1e-4);
    RenderSettings settings;
    settings.width = settings.height = 8;
    settings.spp = 4096;
    const auto at_depth = [&](int depth) {
        settings.max_depth = depth;
        return picture_mean(render(prepared, camera, settings).film, 0);
    };
    const PictureMean one = at_depth(1), two = at_depth(2);
    const reference::Paint q = reference_paint(paint, 550);
    const reference::Integral first = reference::corner_first_bounce(
        ground(q), wall(q), p, -camera.forward, camera.right, smooth_sky(150), 1e-5);
    const reference::Integral second = reference::corner_second_bounce(
        ground(q), wall(q), p, -camera.forward, camera.right, smooth_sky(150), 2e-4);
    const auto check = [&](double value, double error, double right, double reference_error) {
        CAPTURE(value, error, right);
        // The two depths share their numbers, so their difference is better than this says.
        CHECK(std::abs(value - right) <= 4 * error + reference_error);
    };
    check(one.mean.s0, one.error.s0, first.value[0], first.error[0]);
    check(one.mean.s1, one.error.s1, first.value[1], first.error[1]);
    check(one.mean.s2, one.error.s2, first.value[2], first.error[2]);
    check(one.mean.s3, one.error.s3, first.value[3], first.error[3]);
    check(two.mean.s0 - one.mean.s0, std::hypot(one.error.s0, two.error.s0), second.value[0],
          second.error[0]);
    check(two.mean.s1 - one.mean.s1, std::hypot(one.error.s1, two.error.s1), second.value[1],
          second.error[1]);
    check(two.mean.s2 - one.mean.s2, std::hypot(one.error.s2, two.error.s2), second.value[2],
          second.error[2]);
    check(two.mean.s3 - one.mean.s3, std::hypot(one.error.s3, two.error.s3), second.value[3],
          second.error[3]);
    // The test can only speak if the second bounce is resolved.
    CHECK(two.error.s0 < 0.02 * second.value[0]);
}

}  // namespace

// 24 comparisons of means of 64 pixels: |t| > 4 has probability 1e-4 each.
TEST_CASE("Corner: depth 2 minus depth 1 is the second bounce integrated independently",
          "[render]") {
    const Material facets = single_row("facets", {1.5, 0.3, 1, 0.4, 1, 0, 0.02, 0.01});
    const Material polished = single_row("polished", {1.4, 1.2, 1, 0.3, 0.8, 2, 0, 0});
    compare_corner(facets, {0.2, 0, 0.3}, 40);
    compare_corner(polished, {-0.1, 0, 0.5}, 55);
    compare_corner(lambertian(0.6), {0.3, 0, 0.1}, 20);
}

TEST_CASE("Corner: a wavelength alone is what it is among others, where volume light is clamped",
          "[render]") {
    // Green paint at 600 nm has ρv < 0: at grazing views its volume light lives near the normal
    // only. Ground of it beside a matte wall.
    const std::vector<double> two{440, 600};
    const Sky sky = sample_sky(smooth_sky(150), two, 90, 360);
    Material wall = lambertian(0.9);
    RenderSettings settings;
    settings.width = settings.height = 8;
    settings.spp = 2048;
    const Camera camera = look_at({0.2, 0, 0.3}, 78, 90, 1e-4);
    const auto bounce = [&](const std::vector<double>& wavelengths) {
        const PreparedScene prepared(corner_scene(), {0, 1}, {green_paint(), wall}, sky,
                                     wavelengths);
        return picture_mean(render(prepared, camera, settings).film, wavelengths.size() - 1);
    };
    const PictureMean alone = bounce({600}), among = bounce(two);
    // False alarms 1e-4.
    CHECK(std::abs(alone.mean.s0 - among.mean.s0) < 4 * std::hypot(alone.error.s0, among.error.s0));
    settings.max_depth = 1;
    CHECK(alone.mean.s0 > 1.02 * bounce({600}).mean.s0);
}

TEST_CASE("Sphere with a hole: every depth is the geometric series", "[render]") {
    // Area fraction f is open; a uniform sky L shines in: a f L Σ_{k<d} (a(1−f))^k everywhere
    // inside, since every point of a sphere sees every other under the same form factor.
    const double a = 0.7, f = 0.1, L = 2;
    const Scene scene = read_gltf(MALUS_SOURCE_DIR "/scenes/sphere_with_hole.glb");
    REQUIRE(scene.cameras.size() == 1);
    const Camera camera = scene.cameras[0];
    const Sky sky = sample_sky(reference::uniform_sky(L), kOne, 20, 40);
    const PreparedScene prepared(scene, {0}, {lambertian(a)}, sky, kOne);
    RenderSettings settings;
    settings.width = settings.height = 16;
    settings.spp = 4096;
    double series = 0;
    for (int depth = 1; depth <= 8; ++depth) {
        series += std::pow(a * (1 - f), depth - 1);
        if (depth == 4 || depth == 6 || depth == 7) continue;
        settings.max_depth = depth;
        const RenderResult result = render(prepared, camera, settings);
        const PictureMean found = picture_mean(result.film, 0);
        CAPTURE(depth, found.mean.s0, found.error.s0);
        // 256 × 128 facets stand for the sphere: the hole's edge is a polygon, its area and the
        // chords are off by up to (2π/256)²/6 = 1e-4 a bounce.
        const double expected = a * f * L * series;
        CHECK(std::abs(found.mean.s0 - expected) < 4 * found.error.s0 + 3e-4 * depth * expected);
        CHECK(found.error.s0 < 2e-3 * expected);
        CHECK(result.refused == 0);
        // Everywhere: the left, middle and right thirds of the picture, too.
        for (int third = 0; third < 3; ++third) {
            double sum = 0;
            for (std::size_t i = 0; i < result.film.pixel_count(); ++i)
                if (static_cast<int>(i % 16) * 3 / 16 == third) sum += result.film.at(i, 0).mean.s0;
            const double columns = third == 1 ? 5 : third == 0 ? 6 : 5;
            CHECK(sum / (16 * columns) == Approx(expected).epsilon(0.01));
        }
    }
}
