// singular_points_test.cpp — renders at points where angles have no value or numbers no digits, and
// 1e-12, 1e-6 and 1e-3 beside them: nothing refused, and the light that quadrature or a closed form
// says.
// SPDX-License-Identifier: Apache-2.0
#include <cfenv>
#include <utility>

#include "malus/core/frame.h"
#include "malus/io/gltf.h"
#include "support/agreement.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kOne{550};
constexpr std::array<double, 4> kBeside{0, 1e-12, 1e-6, 1e-3};  // rad

PixelStokes render_mean(const Scene& scene, const Material& paint, const Sky& sky,
                        const Camera& camera, std::uint32_t spp = 2048) {
    const PreparedScene prepared(scene, std::vector<int>(scene.instances.size(), 0), {paint}, sky,
                                 kOne);
    RenderSettings settings;
    settings.width = settings.height = 8, settings.spp = spp;
    const RenderResult result = render(prepared, camera, settings);
    CHECK(result.refused == 0);
    return as_one_pixel(result.film, 0);
}

// The panel's light within 4 standard errors (448 degrees of freedom: false alarms 6e-5 a number)
// and the 3e-4 by which cells of 1° miss a smooth sky.
void compare_panel(const Material& paint, double view_zenith, double view_azimuth,
                   const Vec3& sun) {
    const auto light = reference::rayleigh_sky(sun, 1.0, 0.8, 0.15);
    const Sky sky = sample_sky(light, kOne, 90, 360);
    const Camera camera = look_at({0, 0, 0}, to_degrees(view_zenith), to_degrees(view_azimuth),
                                  1e-3 * std::cos(view_zenith));
    const PixelStokes found = render_mean(panel_scene(), paint, sky, camera);
    const reference::Integral expected = reference::panel(
        reference_paint(paint, 550), {0, 1, 0}, -camera.forward, camera.right, light, 1e-6);
    const Agreement a = agreement(found, expected);
    CAPTURE(paint.name, view_zenith, view_azimuth, sun.x, sun.y, sun.z, a.noise.stokes);
    CHECK(a.noise.stokes < 1e-3);
    CHECK(a.stokes < 4 * a.noise.stokes + 3e-4);
}

// A map whose nodes lie on the zenith, the horizon and azimuth 0; sample_sky's lie beside them.
Sky sample_on_axes(const reference::SkyFunction& light) {
    Sky sky;
    sky.wavelengths_nm = kOne;
    for (int i = 0; i <= 90; ++i) sky.zeniths.push_back(to_radians(i));
    for (int i = 0; i < 360; ++i) sky.azimuths.push_back(to_radians(i));
    for (double z : sky.zeniths)
        for (double a : sky.azimuths) {
            // At the zenith each azimuth has a meridian frame of its own; at the horizon there
            // must be light.
            const reference::Stokes S = light(direction(std::clamp(z, 1e-9, kPi / 2 - 1e-9), a));
            sky.nodes.push_back({S[0], S[1], S[2], S[3]});
        }
    return sky;
}

// What a detector that looks along w sees of the sky, in its own frame.
void compare_sky(const Sky& sky, const reference::SkyFunction& light, const Vec3& w) {
    Scene speck;
    add_rectangle(speck, "speck", {0, 0, 0}, {0.01, 0, 0}, {0, 0, 0.01});
    Camera camera;
    camera.forward = w;
    camera.right = any_perpendicular(w);
    camera.up = cross(camera.right, w);
    camera.position = {3, 1, 3};
    camera.xmag = camera.ymag = 1e-3;
    const Stokes<double> found = render_mean(speck, lambertian(0.5), sky, camera, 8).mean;
    const reference::Stokes S = reference::multiply(
        reference::rotation(-w, reference::meridian_axis(w), camera.right), light(w));
    CAPTURE(w.x, w.y, w.z, found.s0, found.s1, found.s2, found.s3, S[0], S[1], S[2], S[3]);
    CHECK(std::abs(found.s0 - S[0]) < 3e-4 * S[0]);
    CHECK(std::abs(found.s1 - S[1]) < 3e-4 * S[0]);
    CHECK(std::abs(found.s2 - S[2]) < 3e-4 * S[0]);
    CHECK(std::abs(found.s3 - S[3]) < 3e-4 * S[0]);
}

}  // namespace

TEST_CASE("View straight down, and beside", "[render]") {
    const Vec3 sun = direction(to_radians(50), to_radians(200));
    for (double beside : kBeside)
        for (double azimuth : {0.0, 2.0}) compare_panel(black_paint(), beside, azimuth, sun);
}

TEST_CASE("Sun at the zenith, at the horizon and across the azimuth seam, and beside", "[render]") {
    for (double beside : kBeside) {
        compare_panel(green_paint(), 0.7, 1.0, direction(beside, 4));
        compare_panel(green_paint(), 0.7, 1.0, direction(kPi / 2 - beside, 4));
        compare_panel(green_paint(), 0.7, kPi + beside, direction(0.9, beside));
        compare_panel(green_paint(), 0.7, kPi - beside, direction(0.9, -beside));
    }
}

TEST_CASE("Sky seen straight up and across the azimuth seam, and beside", "[render]") {
    const auto light = smooth_sky(37);
    const Sky on_axes = sample_on_axes(light), beside_axes = sample_sky(light, kOne, 90, 360);
    for (const Sky& sky : {beside_axes, on_axes})
        for (double beside : kBeside) {
            for (double azimuth : {0.0, 1.0, 4.0})
                compare_sky(sky, light, direction(beside, azimuth));
            for (double zenith : {1e-3, 0.5, 1.5}) {
                compare_sky(sky, light, direction(zenith, beside));
                compare_sky(sky, light, direction(zenith, -beside));
            }
            compare_sky(sky, light, direction(kPi / 2 - 1e-9 - beside, 3));
        }
}

TEST_CASE("Grazing light: a bright spot 0.1° and 0.001° above the horizon", "[render]") {
    // One node's bilinear hat between rows of zenith angle z0 − h, z0 and 90°; its reflection by
    // quadrature of the hat (midpoint rule, 300 × 300).
    for (double above_deg : {0.1, 0.001})
        for (const Material* paint : {&green_paint(), &black_paint()}) {
            const double h = to_radians(above_deg), step = to_radians(1);
            Sky sky;
            sky.wavelengths_nm = kOne;
            sky.zeniths = {0.5, kPi / 2 - 2 * h, kPi / 2 - h, kPi / 2};
            for (int i = 0; i < 360; ++i) sky.azimuths.push_back(to_radians(i));
            sky.nodes.assign(4 * 360, {});
            const std::size_t spot = 220;
            sky.nodes[2 * 360 + spot] = {1e6, 0, 0, 0};
            const Camera camera = look_at({0, 0, 0}, 60, 70, 1e-3);
            const Vec3 wo = -camera.forward;
            const reference::Paint p = reference_paint(*paint, 550);
            reference::Stokes expected{};
            constexpr int kFine = 300;
            for (int i = 0; i < kFine; ++i)
                for (int j = 0; j < kFine; ++j) {
                    const double dz = 2 * (i + 0.5) / kFine - 1, da = 2 * (j + 0.5) / kFine - 1;
                    const Vec3 wi = direction(kPi / 2 - h + dz * h, sky.azimuths[spot] + da * step);
                    const double light = 1e6 * (1 - std::abs(dz)) * (1 - std::abs(da)) * wi.y *
                                         std::hypot(wi.x, wi.z) * h * step * 4 / sqr(kFine);
                    const reference::Mueller f = reference::brdf(
                        p, {0, 1, 0}, wi, wo, reference::meridian_axis(wi), camera.right);
                    for (std::size_t c = 0; c < 4; ++c) expected[c] += light * f[c][0];
                }
            const PixelStokes found = render_mean(panel_scene(), *paint, sky, camera);
            const Agreement a = agreement(found, {expected, {}});
            CAPTURE(above_deg, paint->name, a.stokes, a.noise.stokes);
            CHECK(a.noise.stokes < 2e-3);
            CHECK(a.stokes < 4 * a.noise.stokes + 1e-4);
        }
}

TEST_CASE("Fireflies: a mirror shows a pixel of 1e6 at its full radiance", "[render]") {
    Sky sky = sample_sky(reference::uniform_sky(1), kOne, 90, 360);
    const std::size_t z0 = 40, a0 = 250;
    sky.nodes[z0 * 360 + a0] = {1e6, 0, 0, 0};
    const Material mirror = single_row("mirror", {0.2, 5, 1, 1e-5, 1, 0, 0, 0});
    const double zenith = sky.zeniths[z0], step = to_radians(1);
    const double R = reference::facet(reference_paint(mirror, 550), std::cos(zenith))[0][0];
    for (double beside : {0.0, 1e-3, 0.5 * step}) {
        // Seen from across: light of azimuth a leaves toward a + 180°.
        const Camera camera = look_at({0, 0, 0}, to_degrees(zenith),
                                      to_degrees(sky.azimuths[a0] + beside) - 180, 1e-3);
        const PixelStokes found = render_mean(panel_scene(), mirror, sky, camera, 4096);
        const double L = 1 + (1e6 - 1) * (1 - beside / step);
        CAPTURE(beside, found.mean.s0 / (R * L));
        // Slopes of 1e-5 blur the hat's tip over some 1e-3 of its width.
        CHECK(found.mean.s0 == Approx(R * L).epsilon(3e-3));
    }
}

TEST_CASE("Dim: light of 1e-12 and a paint of B = 1e-12 are only scaled", "[render]") {
    const Camera camera = look_at({0, 0, 0}, 50, 70, 1e-3);
    const auto picture = [&](double radiance, double B) {
        const auto light =
            reference::rayleigh_sky(direction(to_radians(50), 3), radiance, 0.8, 0.15);
        return render_mean(panel_scene(), single_row("paint", {1.5, 0.2, B, 0.3, 1, 0, 0, 0}),
                           sample_sky(light, kOne, 45, 180), camera)
            .mean;
    };
    const Stokes<double> bright = picture(1, 1);
    for (double scale : {1e-12, 1e-6, 1e-3, 1e6})
        for (const Stokes<double>& dim : {picture(scale, 1), picture(1, scale)}) {
            CAPTURE(scale);
            CHECK(dim.s0 == Approx(scale * bright.s0).epsilon(1e-5));
            CHECK(dolp(dim) == Approx(dolp(bright)).epsilon(1e-5));
            CHECK(aolp(dim) == Approx(aolp(bright)).epsilon(1e-5));
        }
}

TEST_CASE("Float exceptions: no invalid operation or division by zero in a render", "[render]") {
    // Armed traps end the program. They rest inside Embree (support/embree_traps.cpp); one thread,
    // so that they are armed where the work is done.
    RenderSettings settings;
    settings.width = settings.height = 16, settings.spp = 64, settings.max_depth = 4;
    settings.threads = 1;
    constexpr int kTraps = FE_INVALID | FE_DIVBYZERO;
    int armed = 0;  // where pixels are made
    settings.progress = [&](double) { armed = ::fegetexcept(); };
    const auto trapped_render = [&](const PreparedScene& scene, const Camera& camera) {
        std::feclearexcept(FE_ALL_EXCEPT);
        REQUIRE(::feenableexcept(kTraps) != -1);
        const RenderResult result = render(scene, camera, settings);
        ::fedisableexcept(kTraps);
        CHECK(armed == kTraps);
        CHECK(result.refused == 0);
        CHECK(result.paths == 16u * 16u * 64u);
    };
    const Material mirror = single_row("mirror", {0.2, 5, 1, 1e-5, 1, 0, 0, 0});
    const Material nothing = single_row("nothing", {1, 0, 0, 0.3, 1, 0, 0, 0});
    Material cauchy = green_paint();
    cauchy.slopes = Slopes::kCauchy;
    const Sky day = sample_sky(smooth_sky(), kOne, 45, 180);
    const Sky night = sample_sky(reference::uniform_sky(0), kOne, 4, 4);
    for (double view : {0.0, 45.0, 89.0})
        for (const Material* paint :
             {&green_paint(), &black_paint(), &std::as_const(cauchy), &mirror, &nothing})
            for (const Sky* sky : {&day, &night}) {
                const PreparedScene scene(corner_scene(), {0, 0}, {*paint}, *sky, kOne);
                trapped_render(scene, look_at({0, 0, 0.5}, view, 160, 0.4));
            }
    const Scene target = read_gltf(MALUS_SOURCE_DIR "/scenes/target_a.glb");
    const std::vector<Material> paints{green_paint(), black_paint()};
    const PreparedScene scene(target, assign_paints(target, {}, paints), paints,
                              sample_sky(smooth_sky(), {440, 600}, 45, 180), {440, 600});
    trapped_render(scene, target.cameras.at(0));
}
