// hard_cases_test.cpp — where formulas have removable singularities and floats run out: no NaN, no
// infinity, no refused sample, and the right limit.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/frame.h"
#include "support/agreement.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kOne{550};

// Renders and checks that every number of the film is finite and nothing was refused.
Film checked_render(const Scene& scene, const Material& paint, const Sky& sky, const Camera& camera,
                    RenderSettings settings = {}) {
    if (settings.width == 512) settings.width = settings.height = 8;
    if (settings.spp == 64) settings.spp = 256;
    settings.sky_table = false;  // means over pixels are judged here, so their errors must be apart
    const PreparedScene prepared(scene, std::vector<int>(scene.instances.size(), 0), {paint}, sky,
                                 kOne);
    const RenderResult result = render(prepared, camera, settings);
    CHECK(result.refused == 0);
    for (const PixelStokes& pixel : result.film.stokes) {
        REQUIRE(std::isfinite(pixel.mean.s0 + pixel.mean.s1 + pixel.mean.s2 + pixel.mean.s3));
        REQUIRE(pixel.mean.s0 >= 0);
        REQUIRE(dop(pixel.mean) <= 1);
        REQUIRE(std::isfinite(stderr_dolp(pixel) + stderr_aolp(pixel)));
    }
    return result.film;
}

PictureMean panel_mean(const Material& paint, const Sky& sky, double view_zenith_deg) {
    // A patch of 2 mm on the panel, however much the view foreshortens it.
    const double half = 1e-3 * std::cos(to_radians(view_zenith_deg));
    const Camera camera = look_at({0, 0, 0}, view_zenith_deg, 70, half);
    return picture_mean(checked_render(panel_scene(), paint, sky, camera), 0);
}

double reference_s0(const Material& paint, double view_zenith_deg) {
    const Camera camera = look_at({0, 0, 0}, view_zenith_deg, 70, 1);
    return reference::panel(reference_paint(paint, 550), {0, 1, 0}, -camera.forward, camera.right,
                            smooth_sky(), 1e-6)
        .value[0];
}

const Sky& smooth_map() {
    static const Sky sky = sample_sky(smooth_sky(), kOne, 90, 360);
    return sky;
}

}  // namespace

// Each comparison with the reference allows 4 standard errors of 64 pixels and 1 % of S0 for the
// map's cells; |t| > 4 has probability 1e-4.
TEST_CASE("Grazing view: from 89° to 89.99999° radiance agrees with quadrature", "[render]") {
    for (double view : {89.0, 89.9, 89.999, 89.99999}) {
        CAPTURE(view);
        for (const Material* paint : {&green_paint(), &black_paint()}) {
            const PictureMean found = panel_mean(*paint, smooth_map(), view);
            const double expected = reference_s0(*paint, view);
            CAPTURE(paint->name, found.mean.s0, found.error.s0, expected);
            CHECK(std::abs(found.mean.s0 - expected) < 4 * found.error.s0 + 0.01 * expected);
        }
    }
}

TEST_CASE("Slopes from a mirror to a brush: σ from 1e-5 to 10", "[render]") {
    for (double sigma : {1e-5, 1e-3, 0.05, 1.0, 10.0}) {
        const Material paint = single_row("paint", {1.5, 0.2, 1, sigma, 1, 0, 0, 0});
        const PictureMean found = panel_mean(paint, smooth_map(), 50);
        CAPTURE(sigma, found.mean.s0, found.error.s0);
        CHECK(found.error.s0 < 0.05 * found.mean.s0);
        if (sigma < 1e-2) {
            // A mirror shows the sky in the specular direction through the Fresnel matrix; σ = 1e-3
            // blurs it over 0.1°.
            const Vec3 wo = -look_at({0, 0, 0}, 50, 70, 1).forward;
            const Vec3 wi{-wo.x, wo.y, -wo.z};
            const reference::Stokes L = smooth_sky()(wi);
            const reference::Mueller m =
                reference::facet(reference_paint(paint, 550), std::cos(to_radians(50)));
            // The plane of incidence is the meridian: s is horizontal, S1 in the s frame −S1.
            const double expected = m[0][0] * L[0] - m[0][1] * L[1];
            CHECK(found.mean.s0 == Approx(expected).epsilon(2e-3));
        } else {
            CHECK(found.mean.s0 ==
                  Approx(reference_s0(paint, 50)).margin(4 * found.error.s0).epsilon(1e-3));
        }
    }
}

TEST_CASE("Indices: n < 1, k = 10, and no contrast at all", "[render]") {
    for (const auto& [n, k] : {std::pair{0.3, 0.0}, {0.2, 3.0}, {1.5, 10.0}, {1.0, 0.0}}) {
        const Material paint = single_row("paint", {n, k, 1, 0.3, 1, 0, 0, 0});
        const PictureMean found = panel_mean(paint, smooth_map(), 60);
        CAPTURE(n, k, found.mean.s0);
        if (n == 1 && k == 0)
            CHECK(found.mean.s0 < 1e-12);
        else
            CHECK(found.mean.s0 == Approx(reference_s0(paint, 60)).epsilon(5e-3));
    }
}

TEST_CASE("Black: a paint without B and ρ, and any paint under a black sky, are 0 and known so") {
    const Material black = single_row("black", {1.5, 0.2, 0, 0.3, 1, 0, 0, 0});
    const PictureMean none = panel_mean(black, smooth_map(), 30);
    CHECK(none.mean.s0 == 0);
    CHECK(none.error.s0 == 0);
    const Sky night = sample_sky(reference::uniform_sky(0), kOne, 4, 4);
    const Film film =
        checked_render(panel_scene(), green_paint(), night, look_at({0, 0, 0}, 30, 0, 0.1));
    CHECK(film.at(0, 0).mean.s0 == 0);
    CHECK(dolp(film.at(0, 0).mean) == 0);
    CHECK(aolp(film.at(0, 0).mean) == 0);
}

TEST_CASE("Bright pixel: one node a million times brighter is found and weighed right",
          "[render]") {
    // Lambert under a black sky but for one node of a 2° grid: its bilinear hat holds a known
    // share of the hemisphere's light. E = Σ over the four cells of ∫ hat cosθ dω, by midpoint.
    Sky sky = sample_sky(reference::uniform_sky(0), kOne, 45, 180);
    const std::size_t z0 = 20, a0 = 33;
    sky.nodes[z0 * 180 + a0] = {1e6, 0, 0, 0};
    const double step = kPi / 90;
    double irradiance = 0;
    const int fine = 400;
    for (int i = 0; i < fine; ++i)
        for (int j = 0; j < fine; ++j) {
            const double dz = (2 * (i + 0.5) / fine - 1), da = (2 * (j + 0.5) / fine - 1);
            const double z = sky.zeniths[z0] + dz * step;
            irradiance += 1e6 * (1 - std::abs(dz)) * (1 - std::abs(da)) * std::cos(z) *
                          std::sin(z) * sqr(2 * step / fine);
        }
    const PictureMean found = panel_mean(lambertian(0.5), sky, 30);
    CHECK(found.mean.s0 == Approx(0.5 / kPi * irradiance).margin(4 * found.error.s0).epsilon(1e-4));
    CHECK(found.error.s0 < 0.01 * found.mean.s0);
}

TEST_CASE("Fully polarized sky: reflected as quadrature says, and never more than light",
          "[render]") {
    // DoP = 1 everywhere: the field runs around an axis below the horizon, where alone it would have
    // no direction; the ellipse goes from linear to circular with ε.
    const Vec3 axis = normalize(Vec3{0.3, -0.8, 0.5});
    for (double circular : {0.0, 0.6, 1.0, -1.0}) {
        const auto light = [&](Vec3 w) -> reference::Stokes {
            if (w.y <= 0) return {};
            const double linear = std::sqrt(1 - circular * circular);
            return polarized_along(cross(axis, w), w, 1, linear, circular);
        };
        const Sky sky = sample_sky(light, kOne, 90, 360);
        const Material metal = single_row("metal", {0.9, 6, 1, 0.2, 1, 0, 0, 0});
        for (double view : {0.0, 45.0, 85.0}) {
            const Camera camera = look_at({0, 0, 0}, view, 70, 1e-3 * std::cos(to_radians(view)));
            const Film film = checked_render(panel_scene(), metal, sky, camera);
            const Agreement a =
                agreement(as_one_pixel(film, 0),
                          reference::panel(reference_paint(metal, 550), {0, 1, 0}, -camera.forward,
                                           camera.right, light, 1e-6));
            CAPTURE(circular, view, a.stokes, a.noise.stokes);
            CHECK(a.noise.stokes < 5e-3);
            CHECK(a.stokes < 4 * a.noise.stokes + 3e-4);  // 48 numbers: false alarms 0.3 %
        }
    }
}

TEST_CASE("Circular sky: each of 24 like wavelengths is what one of them is alone", "[render]") {
    // Same numbers, same directions: no noise to judge. Rows of 24 are read apart from each other, and those
    // of S3 only where there is some; metal makes S3 of what is linear, so that light of
    // other surfaces, which stands in the same place, has some in any case.
    std::vector<double> many;
    for (int i = 0; i < 24; ++i) many.push_back(440 + 5 * i);
    Material metal = single_row("metal", {0.9, 6, 1, 0.2, 1, 0, 0, 0});
    metal.rows.push_back(metal.rows[0]);
    metal.rows.front().wavelength_nm = many.front(), metal.rows.back().wavelength_nm = many.back();
    for (double circular : {0.0, 0.6}) {
        const auto light = [&](Vec3 w) -> reference::Stokes {
            if (w.y <= 0) return {};
            const double linear = std::sqrt(1 - circular * circular);
            return polarized_along(cross({0.3, -0.8, 0.5}, w), w, 1, linear, circular);
        };
        const auto pixel_at = [&](const std::vector<double>& nm, std::size_t wavelength) {
            const PreparedScene prepared(corner_scene(), {0, 0}, {metal},
                                         sample_sky(light, nm, 90, 360), nm);
            RenderSettings settings;
            settings.width = settings.height = 1, settings.spp = 64;
            return render(prepared, look_at({0.2, 0, 0.3}, 45, 70, 1e-3), settings)
                .film.at(0, wavelength)
                .mean;
        };
        const Stokes<double> alone = pixel_at({440}, 0);
        CHECK(std::abs(alone.s3) > 0.01 * alone.s0);
        for (std::size_t w : {0u, 11u, 23u}) {
            const Stokes<double> among = pixel_at(many, w);
            CAPTURE(circular, w);
            CHECK(among.s0 == Approx(alone.s0).epsilon(1e-5));
            CHECK(among.s1 == near(alone.s1, 1e-5 * alone.s0));
            CHECK(among.s2 == near(alone.s2, 1e-5 * alone.s0));
            CHECK(among.s3 == near(alone.s3, 1e-5 * alone.s0));
        }
    }
}

TEST_CASE("Maps of one node and of 4096 × 1024 nodes", "[render]") {
    const Sky one = sample_sky(reference::uniform_sky(3), kOne, 1, 1);
    CHECK(panel_mean(lambertian(0.5), one, 20).mean.s0 == Approx(1.5).epsilon(1e-3));
    const Sky fine = sample_sky(smooth_sky(), kOne, 1024, 4096);
    const PictureMean found = panel_mean(green_paint(), fine, 40);
    CHECK(found.mean.s0 ==
          Approx(reference_s0(green_paint(), 40)).margin(4 * found.error.s0).epsilon(1e-3));
}

TEST_CASE("Straight down and straight up: the zenith of camera and sky", "[render]") {
    const PictureMean down = panel_mean(black_paint(), smooth_map(), 0);
    // The frame of the vertical view: image right is east.
    const reference::Integral expected = reference::panel(
        reference_paint(black_paint(), 550), {0, 1, 0}, {0, 1, 0}, {1, 0, 0}, smooth_sky(), 1e-6);
    CHECK(down.mean.s0 == Approx(expected.value[0]).margin(4 * down.error.s0).epsilon(1e-3));
    CHECK(down.mean.s1 == near(expected.value[1], 4 * down.error.s1 + 1e-6));
    CHECK(down.mean.s2 == near(expected.value[2], 4 * down.error.s2 + 1e-6));
    // Up past the panel's edge into the zenith.
    const Film up = checked_render(panel_scene(), black_paint(), smooth_map(),
                                   look_at({0, 1, 0}, 180, 0, 1e-4));
    Camera beside = look_at({3, 1, 0}, 180, 0, 1e-4);
    const Film sky = checked_render(panel_scene(), black_paint(), smooth_map(), beside);
    CHECK(up.coverage[0] == 1);
    CHECK(sky.coverage[0] == 0);
    // Looking up, north at the top, right is west: the sky's own S1 there about that axis.
    const reference::Stokes zenith = smooth_sky()({0, 1, 0});
    CHECK(sky.at(0, 0).mean.s0 == Approx(zenith[0]).epsilon(1e-3));
    CHECK(dolp(sky.at(0, 0).mean) ==
          Approx(std::hypot(zenith[1], zenith[2]) / zenith[0]).epsilon(2e-3));
}

TEST_CASE("Facing mirrors: fifty bounces, each by its Fresnel amplitude", "[render]") {
    Scene scene;
    add_rectangle(scene, "left", {-0.5, 0, 5}, {0, 0, -10}, {0, 4, 0});
    add_rectangle(scene, "right", {0.5, 0, -5}, {0, 0, 10}, {0, 4, 0});
    const Material mirror = single_row("mirror", {0.2, 5, 1, 1e-5, 1, 0, 0, 0});
    RenderSettings settings;
    settings.width = settings.height = 8, settings.spp = 64;
    // From height 2 each crossing of the gap of 1 m climbs 2/49.5 m: the fiftieth wall is met at
    // 3.98 m, the next would be at 4.02.
    const double elevation = std::atan(2 / 49.5);
    Camera camera = look_at({-0.5, 2, 0}, 90 + to_degrees(elevation), 90, 1e-4);
    camera.position = Vec3{-0.5, 2, 0} - 0.8 * camera.forward;  // between the walls
    const auto seen = [&](int depth) {
        settings.max_depth = depth;
        return picture_mean(checked_render(scene, mirror, smooth_map(), camera, settings), 0).mean;
    };
    CHECK(seen(49).s0 == 0);
    const Stokes<double> through = seen(50);
    // An even number of walls leaves the direction as it was. All reflect in the one vertical plane
    // through it, whose s axis is across the meridian: S1 there is −S1 of the map.
    const reference::FresnelAmplitudes r = reference::fresnel({0.2, 5}, std::cos(elevation));
    const reference::Stokes L = smooth_sky()(camera.forward);
    const double s = 0.5 * std::pow(std::norm(r.rs), 50) * (L[0] - L[1]);
    const double p = 0.5 * std::pow(std::norm(r.rp), 50) * (L[0] + L[1]);
    CHECK(through.s0 == Approx(s + p).epsilon(2e-3));
    CHECK(std::abs(through.s1) == Approx(std::abs(s - p)).epsilon(5e-3));
    CHECK(seen(60).s0 == Approx(through.s0).epsilon(1e-6));
}

TEST_CASE("Degenerate triangles: zero area, duplicates, a needle of 1 km × 1 µm", "[render]") {
    Scene scene = panel_scene();
    Mesh& mesh = scene.meshes[0];
    mesh.positions.push_back({0.1f, 0, 0.1f});
    const auto extra = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    mesh.triangles.push_back({extra, extra, extra});
    mesh.triangles.push_back({0, 1, 1});
    mesh.triangles.push_back({0, 1, 2});  // once more
    Mesh needle;
    needle.positions = {{-500, 0.5f, 0}, {500, 0.5f, 0}, {500, 0.5f, 1e-6f}};
    needle.triangles = {{0, 1, 2}};
    scene.meshes.push_back(needle);
    scene.instances.push_back({1, 0, {}});
    const Film film =
        checked_render(scene, green_paint(), smooth_map(), look_at({0, 0, 0}, 30, 45, 0.3));
    const Film plain =
        checked_render(panel_scene(), green_paint(), smooth_map(), look_at({0, 0, 0}, 30, 45, 0.3));
    CHECK(picture_mean(film, 0).mean.s0 == Approx(picture_mean(plain, 0).mean.s0).epsilon(0.01));
}

TEST_CASE("Shading normals: opposed, facing away, or of no length", "[render]") {
    for (const Vec3f& n :
         {Vec3f(0, -1, 0), Vec3f(0.99f, 0.1f, 0), Vec3f(-0.99f, 0.1f, 0), Vec3f()}) {
        Scene scene = panel_scene();
        scene.meshes[0].normals.assign(4, n);
        for (double view : {0.0, 60.0, 89.0})
            checked_render(scene, green_paint(), smooth_map(), look_at({0, 0, 0}, view, 90, 0.1));
    }
}

TEST_CASE("Shading normals: those that point to the other side are turned to the detector's",
          "[render]") {
    const Camera camera = look_at({0, 0, 0}, 40, 90, 0.1);
    const Film plain = checked_render(panel_scene(), green_paint(), smooth_map(), camera);
    Scene scene = panel_scene();
    scene.meshes[0].normals.assign(4, Vec3f(0, -1, 0));
    const Film opposed = checked_render(scene, green_paint(), smooth_map(), camera);
    CHECK(picture_mean(opposed, 0).mean.s0 == Approx(picture_mean(plain, 0).mean.s0).epsilon(1e-6));
}

TEST_CASE("Pictures of 1 × 1 and of 20000 × 1 pixels", "[render]") {
    RenderSettings settings;
    settings.width = settings.height = 1, settings.spp = 8;
    CHECK(checked_render(panel_scene(), green_paint(), smooth_map(), look_at({0, 0, 0}, 30, 0, 1),
                         settings)
              .coverage[0] > 0);
    settings.width = 20000;
    const Film film = checked_render(panel_scene(), green_paint(), smooth_map(),
                                     look_at({0, 0, 0}, 30, 0, 1e-3), settings);
    CHECK(film.pixel_count() == 20000);
}

TEST_CASE("Scale: a feature of 1 mm on a ground of 10 km", "[render]") {
    // A step 1 mm high near the middle of the ground shades what lies beside it.
    Scene scene;
    add_rectangle(scene, "ground", {-5000, 0, 5000}, {10000, 0, 0}, {0, 0, -10000});
    add_rectangle(scene, "step", {-0.5, 0, 0}, {1, 0, 0}, {0, 0.001, 0});
    const Film film = checked_render(scene, lambertian(0.5), smooth_map(),
                                     look_at({0, 0.0005, 0}, 60, 180, 0.0005));
    // The lower half of the step fills the middle rows of the picture: all of it is surface.
    for (float a : film.coverage) CHECK(a == 1);
    CHECK(film.instance[3 * 8 + 4] == 1);
    CHECK(film.instance[7 * 8 + 4] == 0);
}

TEST_CASE("Refusals: a sample that overflows is left out, counted, and named by its pixel",
          "[render]") {
    // A sky of 1e38, which no file can have, in a mirror whose f is 1e11 at its peak.
    const Sky sky = sample_sky(reference::uniform_sky(1e38), kOne, 9, 36);
    const Material mirror = single_row("mirror", {0.2, 5, 1, 1e-6, 1, 0, 0.1, 0});
    const PreparedScene scene(panel_scene(), {0}, {mirror}, sky, kOne);
    RenderSettings settings;
    settings.width = 4, settings.height = 3, settings.spp = 16;
    const RenderResult result = render(scene, look_at({0, 0, 0}, 40, 70, 0.01), settings);
    CHECK(result.refused > 0);
    std::uint64_t kept = 0;
    for (std::uint32_t n : result.film.samples) kept += n;
    CHECK(kept + result.refused == 4u * 3u * 16u);
    REQUIRE(result.first_refused.size() == std::min<std::size_t>(result.refused, 16));
    for (const RefusedSample& r : result.first_refused) {
        CHECK((r.x >= 0 && r.x < 4 && r.y >= 0 && r.y < 3));
        CHECK((r.replicate < kReplicates && r.sample < 2));
        // The pixel named is one that lacks samples.
        const auto index = static_cast<std::size_t>(r.y * 4 + r.x);
        CHECK(result.film.samples[index] < 16);
    }
    for (const PixelStokes& pixel : result.film.stokes) CHECK(std::isfinite(pixel.mean.s0));
}
