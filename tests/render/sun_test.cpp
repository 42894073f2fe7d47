// sun_test.cpp — the sun's disc as a light, seen by rough surfaces, by mirrors, and directly.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/sun_disc.h"

#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kOne{550};
constexpr double kIrradiance = 1.5;
const double kRadiance = kIrradiance / (kPi * sqr(std::sin(to_radians(0.267))));

// A black sky with a sun.
Sky sun_at(double zenith_deg, double azimuth_deg) {
    Sky sky = sample_sky(reference::uniform_sky(0), kOne, 4, 4);
    sky.sun = Sun{to_radians(zenith_deg), to_radians(azimuth_deg), {kIrradiance}};
    return sky;
}

PictureMean seen(const Scene& scene, const Material& paint, const Sky& sky, const Camera& camera,
                 std::uint32_t spp = 256, Lighting lighting = Lighting::kBoth, int pixels = 4) {
    RenderSettings settings;
    settings.width = settings.height = pixels;
    settings.spp = spp;
    settings.max_depth = 1;
    settings.lighting = lighting;
    const std::vector<int> paints(scene.instances.size(), 0);
    return picture_mean(
        render(PreparedScene(scene, paints, {paint}, sky, kOne), camera, settings).film, 0);
}

// A square of 1 m that stands upright and faces south.
Scene wall_scene() {
    Scene scene;
    add_rectangle(scene, "wall", {-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0});
    return scene;
}

// Light that a level panel sends toward wo, by midpoints over the disc, even in solid angle.
reference::Stokes reflected_disc(const reference::Paint& paint, const Vec3& middle, const Vec3& wo,
                                 const Vec3& x_out, int rings) {
    const double edge = to_radians(0.267), whole = 1 - std::cos(edge);
    reference::Stokes sum{};
    const Basis basis(middle);
    const int spokes = 3 * rings;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < spokes; ++j) {
            const double c = 1 - whole * (i + 0.5) / rings, s = std::sqrt(1 - c * c);
            const double turn = 2 * kPi * (j + 0.5) / spokes;
            const Vec3 wi = basis.to_world({s * std::cos(turn), s * std::sin(turn), c});
            const reference::Mueller f =
                reference::brdf(paint, kUp, wi, wo, any_perpendicular(wi), x_out);
            const double weight = kRadiance * wi.y * 2 * kPi * whole / (rings * spokes);
            for (std::size_t k = 0; k < 4; ++k) sum[k] += weight * f[k][0];
        }
    return sum;
}

}  // namespace

TEST_CASE("Sun: a plane that faces its disc receives the irradiance of the sky file") {
    // Lambert: L = a/π E cosθ, exactly, for an even disc: the mean of its directions is its middle.
    // Of the lobes' samples one in 50 000 meets the disc, and stands for as much: 1.5e-5 each here.
    for (double zenith : {0.0, 40.0, 75.0}) {
        const PictureMean lit = seen(panel_scene(), lambertian(0.4), sun_at(zenith, 130),
                                     look_at({0, 0, 0}, 30, 20, 0.1), 4096);
        CHECK(lit.mean.s0 ==
              Approx(0.4 / kPi * kIrradiance * std::cos(to_radians(zenith))).epsilon(5e-5));
        CHECK(lit.mean.s1 == 0);
    }
}

TEST_CASE("Sun: a mirror shows the disc at its full radiance, polarized as Fresnel has it") {
    // σ = 1e-5: facets turn light by 0.001°, the disc is 0.267° wide. Green 550 at 60°: R = 0.0910,
    // DoLP = 0.915, s-polarized: along image right, for the plane of incidence is upright.
    const Material mirror = single_row("mirror", {1.366, 0.2746, 1, 1e-5, 1, 0, 0, 0});
    const Camera opposite = look_at({0, 0, 0}, 60, 40 + 180, 0.1);
    const PictureMean glint = seen(panel_scene(), mirror, sun_at(60, 40), opposite, 256);
    CHECK(glint.mean.s0 == Approx(0.0910 * kRadiance).epsilon(1e-3));
    CHECK(dolp(glint.mean) == near(0.915, 1e-3));
    CHECK(to_degrees(std::remainder(aolp(glint.mean), kPi)) == near(0, 0.1));
    // 0.3° beside the disc it shows nothing; 0.2° beside its middle, all.
    CHECK(seen(panel_scene(), mirror, sun_at(60.3, 40), opposite).mean.s0 == 0);
    CHECK(seen(panel_scene(), mirror, sun_at(60.2, 40), opposite).mean.s0 ==
          Approx(0.0910 * kRadiance).epsilon(5e-3));
}

TEST_CASE("Sun: glints narrower and wider than the disc agree with quadrature", "[render]") {
    // Lobes from 0.03° to 6°; samples of the disc, of the lobes, and both. Four errors of the mean
    // and 0.1 %: false alarms below 4 × 3 × 6e-5.
    for (double sigma : {0.0005, 0.003, 0.01, 0.1}) {
        const Material paint = single_row("glossy", {1.5, 0.3, 1, sigma, 1, 0, 0, 0});
        const Camera camera = look_at({0, 0, 0}, 49.85, 70 + 180, 0.1);
        const reference::Stokes expected =
            reflected_disc(reference_paint(paint, 550), direction(to_radians(50), to_radians(70)),
                           -camera.forward, camera.right, 400);
        const PictureMean both =
            seen(panel_scene(), paint, sun_at(50, 70), camera, 4096, Lighting::kBoth);
        CAPTURE(sigma, both.mean.s0, both.error.s0, expected[0]);
        const std::array<double, 3> found{both.mean.s0, both.mean.s1, both.mean.s2},
            error{both.error.s0, both.error.s1, both.error.s2};
        for (std::size_t k = 0; k < 3; ++k)
            CHECK(std::abs(found[k] - expected[k]) < 4 * error[k] + 1e-3 * expected[0]);
        CHECK(both.error.s0 < 3e-3 * expected[0]);
    }
}

TEST_CASE("Sun: samples of the disc and of the surface's lobes find the same light", "[render]") {
    const Material paint = single_row("glossy", {1.5, 0.3, 1, 0.005, 1, 0, 0, 0});
    const Camera camera = look_at({0, 0, 0}, 50, 70 + 180, 0.1);
    const auto estimate = [&](Lighting lighting) {
        return seen(panel_scene(), paint, sun_at(50.2, 70), camera, 4096, lighting);
    };
    const PictureMean disc = estimate(Lighting::kLightSamples),
                      lobes = estimate(Lighting::kSurfaceSamples);
    // |z| < 4: false alarms 6e-5.
    CHECK(std::abs(disc.mean.s0 - lobes.mean.s0) < 4 * std::hypot(disc.error.s0, lobes.error.s0));
    CHECK(disc.error.s0 + lobes.error.s0 < 0.01 * disc.mean.s0);
}

TEST_CASE("Sun: at the horizon only what stands above it shines") {
    // On a wall that faces the sun, a/π E times the share of the disc above the horizon:
    // 1 − (acos h − h √(1−h²))/π, h the height of its middle in radii.
    // |z| < 4 and 1e-4: false alarms 4 × 6e-5.
    const auto lit = [](double height) {
        const Sky sky = sun_at(90 - 0.267 * height, 180);
        return seen(wall_scene(), lambertian(0.4), sky, look_at({0, 0, 0}, 80, 180, 0.1), 4096);
    };
    for (double height : {1.1, 0.5, 0.0, -0.5}) {
        const double h = std::clamp(height, -1.0, 1.0);
        const double share = 1 - (std::acos(h) - h * std::sqrt(1 - h * h)) / kPi;
        const double whole = 0.4 / kPi * kIrradiance;
        const PictureMean found = lit(height);
        CAPTURE(height, found.error.s0 / whole);
        CHECK(std::abs(found.mean.s0 - whole * share) < 4 * found.error.s0 + 1e-4 * whole);
        CHECK(found.error.s0 < 1e-3 * whole);
    }
    CHECK(lit(-1.1).mean.s0 == 0);
}

TEST_CASE("Sun: seen directly it fills its disc, and a target before it hides it") {
    // The camera looks up at the sun at 30° through 2°: ∫ L dω over the picture is E.
    const Vec3 sun = direction(to_radians(30), to_radians(250));
    Camera camera;
    camera.projection = Projection::kPerspective;
    camera.position = {0, 0, 0};
    camera.forward = sun;
    camera.right = normalize(cross(sun, kUp));
    camera.up = cross(camera.right, camera.forward);
    camera.yfov = to_radians(2);
    Scene far_away;
    add_rectangle(far_away, "elsewhere", {100, 0, 100}, {1, 0, 0}, {0, 0, -1});
    const auto flux = [&](const Scene& scene) {
        const double pixel = 4 * sqr(std::tan(to_radians(1)));  // of the picture, sr
        return pixel *
               seen(scene, lambertian(0.4), sun_at(30, 250), camera, 64, Lighting::kBoth, 64)
                   .mean.s0;
    };
    CHECK(flux(far_away) == Approx(kIrradiance).epsilon(2e-3));
    // A target of 1 m at 20 m, wider than the disc (0.19 m there): its dark side, without the sun.
    const Vec3 centre = 20.0 * sun;
    Scene before;
    add_rectangle(before, "target", centre - 0.5 * camera.right - 0.5 * camera.up, camera.right,
                  camera.up);
    CHECK(flux(before) == 0);
    // Moved aside until its edge cuts the disc in half.
    Scene half;
    add_rectangle(half, "target", centre - 0.5 * camera.up, camera.right, camera.up);
    CHECK(flux(half) == Approx(kIrradiance / 2).epsilon(5e-3));
}

TEST_CASE("Sun: a shadow's edge lies where half of the disc is hidden") {
    // A wall 10 m high, its upper edge in the line from the point looked at to the sun's middle: half
    // the disc is seen. 0.267° further away all of it, as much nearer none.
    const double height = 10, distance = height * std::tan(to_radians(60));
    Scene scene;
    add_rectangle(scene, "ground", {-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
    add_rectangle(scene, "wall", {-20, 0, -distance}, {40, 0, 0}, {0, height, 0});
    const auto lit = [&](double sun_zenith_deg) {
        return seen(scene, lambertian(0.4), sun_at(sun_zenith_deg, 0),
                    look_at({0, 0, 0}, 0, 0, 1e-4), 4096)
                   .mean.s0 /
               (0.4 / kPi * kIrradiance * std::cos(to_radians(sun_zenith_deg)));
    };
    CHECK(lit(60) == near(0.5, 3e-3));
    CHECK(lit(60 - 0.28) == near(1, 1e-4));
    CHECK(lit(60 + 0.28) == 0);
}
