// render_test.cpp — determinism, coverage, error bars and geometry of whole renders.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/render.h"

#include <cstring>

#include "malus/core/frame.h"
#include "malus/io/gltf.h"
#include "render/accel.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/statistics.h"

using namespace malus;

namespace {

const std::vector<double> kTwo{440, 600};

Sky smooth_map() {
    return sample_sky(
        reference::rayleigh_sky(direction(to_radians(50), to_radians(150)), 1.0, 0.8, 0.1), kTwo,
        45, 180);
}

PreparedScene shipped_target(const std::string& file) {
    Scene scene = read_gltf(MALUS_SOURCE_DIR "/scenes/" + file);
    const std::vector<Material> paints{green_paint(), black_paint()};
    const std::vector<int> of = assign_paints(scene, {}, paints);
    return PreparedScene(std::move(scene), of, paints, smooth_map(), kTwo);
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

}  // namespace

TEST_CASE("Threads: one and two give the same picture, bit for bit", "[render]") {
    const PreparedScene scene = shipped_target("target_a.glb");
    const Camera camera = scene.scene().cameras.at(0);
    RenderSettings settings;
    settings.width = 61, settings.height = 47, settings.spp = 16;
    settings.threads = 1;
    const RenderResult one = render(scene, camera, settings);
    settings.threads = 2;
    const RenderResult two = render(scene, camera, settings);
    CHECK(same_bits(one.film.stokes, two.film.stokes));
    CHECK(same_bits(one.film.coverage, two.film.coverage));
    CHECK(same_bits(one.film.distance, two.film.distance));
    CHECK(same_bits(one.film.instance, two.film.instance));
    CHECK(one.rays == two.rays);
    settings.seed = 1;
    CHECK_FALSE(same_bits(render(scene, camera, settings).film.stokes, two.film.stokes));
}

TEST_CASE("Shipped scenes: no sample is refused and light stays light", "[render]") {
    for (const char* file : {"target_a.glb", "target_b.glb"}) {
        const PreparedScene scene = shipped_target(file);
        RenderSettings settings;
        settings.width = 64, settings.height = 48, settings.spp = 64, settings.max_depth = 3;
        const RenderResult result = render(scene, scene.scene().cameras.at(0), settings);
        CHECK(result.refused == 0);
        CHECK(result.paths == 64u * 48u * 64u);
        for (const PixelStokes& pixel : result.film.stokes) {
            REQUIRE(std::isfinite(pixel.mean.s0));
            REQUIRE(pixel.mean.s0 >= 0);
            REQUIRE(dop(pixel.mean) <= 1);
        }
    }
}

TEST_CASE("Coverage: a panel that fills a quarter of the picture has A, Z and ids there") {
    Scene panel;
    add_rectangle(panel, "panel", {-1, 0, 1}, {1, 0, 0}, {0, 0, -1});
    const PreparedScene scene(panel, {0}, {lambertian(0.5)},
                              sample_sky(reference::uniform_sky(1), kTwo, 4, 4), kTwo);
    // From above, north up: x −1..0 is left, z 0..1 is below.
    Camera camera = look_at({0, 0, 0}, 0, 0, 1);
    RenderSettings settings;
    settings.width = settings.height = 8, settings.spp = 8;
    const Film film = render(scene, camera, settings).film;
    for (std::size_t i = 0; i < 64; ++i) {
        const bool on = i % 8 < 4 && i / 8 >= 4;
        CAPTURE(i);
        CHECK(film.coverage[i] == (on ? 1.0f : 0.0f));
        CHECK(film.instance[i] == (on ? 0 : -1));
        CHECK(film.distance[i] == Approx(on ? 10.0 : 0.0));
        CHECK(film.samples[i] == 8);
    }
    // Looking down past the panel there is no sky: black.
    CHECK(film.at(0, 0).mean.s0 == 0);
}

TEST_CASE("Sky seen directly: its own Stokes vector, in the image frame") {
    // A sky of light polarized along the meridian, seen by a level camera: vertical E, AoLP 90°.
    Sky sky = sample_sky([](Vec3) { return reference::Stokes{1, 0.5, 0, 0.25}; }, kTwo, 90, 720);
    Scene speck;
    add_rectangle(speck, "speck", {0, -5, 0}, {0.1, 0, 0}, {0, 0, 0.1});
    const PreparedScene scene(speck, {0}, {lambertian(0.5)}, sky, kTwo);
    Camera camera;
    camera.projection = Projection::kPerspective;
    camera.forward = normalize(Vec3{0, 0.3, -1});
    camera.right = {1, 0, 0};
    camera.up = cross(camera.right, camera.forward);
    camera.yfov = to_radians(2);
    RenderSettings settings;
    settings.width = settings.height = 3, settings.spp = 64;
    const Film film = render(scene, camera, settings).film;
    const Stokes<double>& center = film.at(4, 0).mean;
    CHECK(center.s0 == Approx(1));
    CHECK(dolp(center) == Approx(0.5).epsilon(1e-4));
    CHECK(to_degrees(aolp(center)) == near(90, 0.1));
    CHECK(center.s3 == Approx(0.25));
    CHECK(film.coverage[4] == 0);
}

TEST_CASE("Leaving a surface: rays never meet the surface they start from") {
    // A closed convex box seen from inside and outside, far from the centre of a large plate, at
    // all slopes down to 1e-6 rad of grazing.
    Scene scene;
    add_rectangle(scene, "plate", {-5000, 0, 5000}, {10000, 0, 0}, {0, 0, -10000});
    add_rectangle(scene, "tile", {3000, 1, 2000}, {2, 0.3, 0}, {0, 0.1, -2});
    const Accel accel(scene);
    Uniform u(9);
    int hits = 0, wrong = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3 target = i % 2 ? Vec3{3000 + 2 * u(), 1.2, 1999 - u()}
                                  : Vec3{1e4 * (u() - 0.5), 0, 1e4 * (u() - 0.5)};
        const Vec3 from = direction(1.5 * u(), 7 * u());
        const auto hit = accel.intersect(target + 5.0 * from - accel.center(), -from);
        if (!hit) continue;
        ++hits;
        const Basis basis(hit->ng);
        const double height = std::pow(10.0, -6 * u()), phi = 7 * u();
        const double across = std::sqrt(1 - height * height);
        const Vec3 away = basis.to_world({across * std::cos(phi), across * std::sin(phi), height});
        const auto next = accel.intersect(hit->leave(away), away);
        wrong += next && next->instance == hit->instance ? 1 : 0;
    }
    CHECK(hits > 15000);
    CHECK(wrong == 0);
}

TEST_CASE("Instances: a mesh placed many times looks like as many meshes", "[render]") {
    // The same three tiles, once as one shared mesh and once as three.
    const Affine tilt{{1, 0, 0}, {0, 0.9, 0.3}, {0, -0.3, 0.9}, {0.4, 0.2, -1}};
    const Affine mirror{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-0.6, 0.1, 0.8}};
    Scene shared, apart;
    add_rectangle(shared, "tile", {-0.5, 0, 0.5}, {1, 0, 0}, {0, 0, -1});
    shared.meshes[0].normals.assign(4, Vec3f(0, 1, 0));
    for (const Affine& place : {tilt, mirror}) {
        shared.instances.push_back({0, 0, place});
    }
    for (std::size_t i = 0; i < 3; ++i) {
        apart.meshes.push_back(shared.meshes[0]);
        apart.instances.push_back({static_cast<int>(i), 0, shared.instances[i].to_world});
    }
    apart.nodes = shared.nodes, apart.surfaces = shared.surfaces;
    RenderSettings settings;
    settings.width = settings.height = 24, settings.spp = 64;
    const Camera camera = look_at({0, 0, 0}, 35, 50, 2);
    const Film a = render(PreparedScene(shared, {0, 0, 0}, {green_paint()}, smooth_map(), kTwo),
                          camera, settings)
                       .film;
    const Film b = render(PreparedScene(apart, {0, 0, 0}, {green_paint()}, smooth_map(), kTwo),
                          camera, settings)
                       .film;
    for (std::size_t i = 0; i < a.pixel_count(); ++i) {
        // A sample on an edge may fall to either side.
        CHECK(std::abs(a.coverage[i] - b.coverage[i]) <= 1.0f / 32);
        if (a.coverage[i] != b.coverage[i] || a.coverage[i] < 1) continue;
        CHECK(a.at(i, 0).mean.s0 == Approx(b.at(i, 0).mean.s0).epsilon(1e-3));
        CHECK(a.distance[i] == Approx(b.distance[i]).epsilon(1e-5));
    }
}

TEST_CASE("Instances: a mesh far from its own origin does not shadow itself", "[render]") {
    // Vertices at 1e5 m, placed back at the origin: once alone (triangles in the world) and twice
    // (an instance), which must be lit alike.
    Scene scene;
    add_rectangle(scene, "tile", {1e5 - 0.5, 0, 0.5}, {1, 0.25, 0}, {0, 0.25, -1});
    scene.instances[0].to_world.t = {-1e5, 0, 0};
    const Sky sky = sample_sky(reference::uniform_sky(1), kTwo, 8, 8);
    RenderSettings settings;
    settings.width = settings.height = 8, settings.spp = 64;
    const Camera camera = look_at({0, 0.25, 0}, 20, 0, 0.2);
    const Film alone =
        render(PreparedScene(scene, {0}, {lambertian(0.5)}, sky, kTwo), camera, settings).film;
    scene.instances.push_back(scene.instances[0]);
    scene.instances[1].to_world.t = {-1e5, -50, 0};
    const Film twice =
        render(PreparedScene(scene, {0, 0}, {lambertian(0.5)}, sky, kTwo), camera, settings).film;
    const double a = picture_mean(alone, 0).mean.s0, b = picture_mean(twice, 0).mean.s0;
    CHECK(b == Approx(a).epsilon(0.005));
    CHECK(a > 0.4);
}

TEST_CASE("Instances: placements that flatten a mesh are legal") {
    Scene scene;
    add_rectangle(scene, "tile", {-0.5, 0, 0.5}, {1, 0.2, 0}, {0, 0, -1});
    for (const Vec3& scale : {Vec3{1, 0, 1}, Vec3{0, 0, 0}, Vec3{1, 1e-30, 1}, Vec3{1e-20, 1, 1}})
        scene.instances.push_back(
            {0, 0, {{scale.x, 0, 0}, {0, scale.y, 0}, {0, 0, scale.z}, {2, 0, 0}}});
    RenderSettings settings;
    settings.width = settings.height = 32, settings.spp = 8;
    const PreparedScene prepared(scene, std::vector<int>(5, 0), {green_paint()}, smooth_map(),
                                 kTwo);
    const RenderResult result = render(prepared, look_at({1, 0, 0}, 10, 0, 2), settings);
    CHECK(result.refused == 0);
    for (const PixelStokes& pixel : result.film.stokes) CHECK(std::isfinite(pixel.mean.s0));
}

TEST_CASE("Distant camera: a satellite sees what a camera nearby sees") {
    Scene scene;
    add_rectangle(scene, "tile", {-0.5, 0, 0.5}, {1, 0, 0}, {0, 0, -1});
    const PreparedScene prepared(scene, {0}, {lambertian(0.5)},
                                 sample_sky(reference::uniform_sky(1), kTwo, 8, 8), kTwo);
    RenderSettings settings;
    settings.width = settings.height = 16, settings.spp = 64;
    for (double away : {0.0, 7e5, 1e7}) {
        Camera camera = look_at({0, 0, 0}, 20, 0, 1.0);
        camera.position = camera.position - away * camera.forward;
        const Film film = render(prepared, camera, settings).film;
        double coverage = 0;
        for (float a : film.coverage) coverage += static_cast<double>(a) / 256;
        // The tile fills ½ × ½ cos 20° of the picture.
        CHECK(coverage == Approx(0.25 * std::cos(to_radians(20))).epsilon(0.01));
        // That pixel's centre looks 1/16 m below the tile's.
        const double nearer = std::tan(to_radians(20)) / 16;
        CHECK(film.distance[8 * 16 + 8] == Approx(10 + away - nearer).epsilon(1e-4));
    }
}

TEST_CASE("Smooth normals: interpolated from the corners, transformed as normals are") {
    // One triangle (0,0,0), (1,0,0), (0,0,−1) with three normals, placed with scales (2, 1, 1).
    Scene scene;
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, -1}};
    const auto unit = [](double x, double y, double z) { return Vec3f(normalize(Vec3{x, y, z})); };
    mesh.normals = {unit(0, 1, 0), unit(0.6, 0.8, 0), unit(0, 0.8, -0.6)};
    mesh.triangles = {{0, 1, 2}};
    scene.meshes = {mesh};
    scene.nodes = {{"n", -1}};
    scene.instances = {{0, 0, {{2, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}}};
    const Accel accel(scene);
    // At u = 0.5 along the first edge, v = 0.25 along the second: world (1, 0, −0.25).
    const auto hit = accel.intersect(Vec3{1, 3, -0.25} - accel.center(), {0, -1, 0});
    REQUIRE(hit);
    // ¼(0,1,0) + ½(0.6,0.8,0) + ¼(0,0.8,−0.6) = (0.3, 0.85, −0.15); the inverse transpose of
    // (2,1,1) halves x.
    const Vec3 expected = normalize(Vec3{0.15, 0.85, -0.15});
    CHECK(length(hit->n - expected) < 1e-6);
    CHECK(length(hit->ng - Vec3{0, 1, 0}) < 1e-12);
    CHECK(length(hit->position + accel.center() - Vec3{1, 0, -0.25}) < 1e-6);
}

TEST_CASE("Leaning normals: no light from behind the surface leaks through it", "[render]") {
    // A wall that faces south with normals that lean 60° toward north and up: the shading
    // hemisphere reaches behind it. Only the northern sky, behind the wall, is bright.
    Scene scene;
    add_rectangle(scene, "wall", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    scene.meshes[0].normals.assign(4, Vec3f(normalize(Vec3{0, std::sin(1.0), std::cos(1.0)})));
    const Sky sky = sample_sky(
        [](Vec3 w) {
            return reference::Stokes{w.z < -0.1 ? 1.0 : 0.0, 0, 0, 0};
        },
        kTwo, 30, 60);
    const Camera camera = look_at({0, 0, 0}, 70, 180, 0.2);
    RenderSettings settings;
    settings.width = settings.height = 4, settings.spp = 256;
    for (Lighting lighting : {Lighting::kLightSamples, Lighting::kSurfaceSamples}) {
        settings.lighting = lighting;
        const PreparedScene prepared(scene, {0}, {lambertian(0.5)}, sky, kTwo);
        CHECK(picture_mean(render(prepared, camera, settings).film, 0).mean.s0 == 0);
    }
}

TEST_CASE("Brewster: light without a reflected part is black, not refused") {
    // A smooth surface at Brewster's angle under a sky wholly polarized in the plane of incidence.
    Scene scene;
    add_rectangle(scene, "glass", {-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
    const Sky sky = sample_sky([](Vec3) { return reference::Stokes{1, 1, 0, 0}; }, {550}, 90, 360);
    const Material glass = single_row("glass", {1.5, 0, 1, 1e-5, 1, 0, 0, 0});
    const PreparedScene prepared(scene, {0}, {glass}, sky, {550});
    RenderSettings settings;
    settings.width = settings.height = 8, settings.spp = 256;
    const Camera camera = look_at({0, 0, 0}, to_degrees(std::atan(1.5)), 30, 1e-3);
    const RenderResult result = render(prepared, camera, settings);
    CHECK(result.refused == 0);
    // Bilinear in cells of 1°, the map is depolarized by up to (1°)²/2 = 1.5e-4 in a frame that does
    // not spin, of which |rs|²/2 = 0.074 comes back.
    CHECK(picture_mean(result.film, 0).mean.s0 < 1.2e-5);
}

TEST_CASE("Stopping: a render told to stop says so and does not finish") {
    const PreparedScene scene = shipped_target("target_a.glb");
    RenderSettings settings;
    settings.width = settings.height = 400, settings.spp = 1024;
    std::atomic<bool> stop{true};
    settings.stop = &stop;
    const RenderResult result = render(scene, scene.scene().cameras.at(0), settings);
    CHECK(result.stopped_by == StoppedBy::kRequest);
    CHECK_FALSE(result.complete());
    CHECK(result.paths == 0);
}
