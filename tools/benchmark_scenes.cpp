// benchmark_scenes.cpp — grids, boxes and a sphere.
// SPDX-License-Identifier: Apache-2.0
#include "tools/benchmark_scenes.h"

#include <cmath>
#include <functional>

namespace malus {
namespace {

// A sheet of (columns × rows) quads through the points of `place`, with smooth normals.
Mesh sheet(int columns, int rows, const std::function<Vec3(double u, double v)>& place) {
    Mesh mesh;
    mesh.surface = 0;
    const auto point = [&](int i, int j) {
        return place(static_cast<double>(i) / columns, static_cast<double>(j) / rows);
    };
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            mesh.positions.push_back(Vec3f(point(i, j)));
            const Vec3 across = point(i + 1, j) - point(i - 1, j),
                       along = point(i, j + 1) - point(i, j - 1);
            const Vec3 normal = cross(along, across);
            // Where a row is a point, a sphere's pole.
            mesh.normals.push_back(
                Vec3f(length(normal) > 1e-12 ? normalize(normal) : Vec3{0, 1, 0}));
        }
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i),
                       b = static_cast<std::uint32_t>(a + static_cast<std::uint32_t>(columns) + 1);
            mesh.triangles.push_back({a, b, a + 1});
            mesh.triangles.push_back({a + 1, b, b + 1});
        }
    return mesh;
}

// An upright box without a bottom, flat.
Mesh box(const Vec3& half) {
    Mesh mesh;
    mesh.surface = 0;
    for (int i = 0; i < 8; ++i)
        mesh.positions.push_back(Vec3f(
            Vec3{i & 1 ? half.x : -half.x, i & 2 ? 2 * half.y : 0, i & 4 ? half.z : -half.z}));
    const auto face = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    };
    face(0, 1, 3, 2), face(4, 5, 7, 6), face(0, 4, 6, 2), face(1, 5, 7, 3), face(2, 3, 7, 6);
    return mesh;
}

void place(BenchmarkScene& to, const std::string& name, int mesh, const Vec3& at, int paint) {
    to.scene.nodes.push_back({name, -1});
    Instance instance;
    instance.mesh = mesh;
    instance.node = static_cast<int>(to.scene.nodes.size()) - 1;
    instance.to_world.t = at;
    to.scene.instances.push_back(instance);
    to.paints.push_back(paint);
}

Camera camera_from(const Vec3& eye, const Vec3& target, double yfov_deg) {
    Camera camera;
    camera.name = "view";
    camera.projection = Projection::kPerspective;
    camera.yfov = to_radians(yfov_deg);
    camera.position = eye;
    camera.forward = normalize(target - eye);
    camera.right = normalize(cross(camera.forward, Vec3{0, 1, 0}));
    camera.up = cross(camera.right, camera.forward);
    return camera;
}

BenchmarkScene named(const std::string& name, const std::vector<Material>& materials) {
    BenchmarkScene scene;
    scene.name = name;
    scene.scene.surfaces = {"surface"};
    scene.materials = materials;
    return scene;
}

}  // namespace

BenchmarkScene relief_scene(const std::vector<Material>& materials) {
    BenchmarkScene to = named("relief, 1 million triangles", materials);
    constexpr double kSide = 40;  // m
    to.scene.meshes.push_back(sheet(707, 707, [](double u, double v) {
        const double x = kSide * (u - 0.5), z = kSide * (v - 0.5);
        const double y = 0.06 * std::sin(0.9 * x + 0.3 * z) + 0.05 * std::sin(1.7 * z - 0.6 * x) +
                         0.01 * std::sin(7.1 * x) * std::sin(6.3 * z);
        return Vec3{x, y, z};
    }));
    to.scene.meshes.push_back(box({1.2, 0.6, 0.7}));
    place(to, "ground", 0, {0, 0, 0}, 1);
    place(to, "target", 1, {0, -0.1, 0}, 0);
    to.scene.cameras = {camera_from({4, 7, 11}, {0, 0.3, 0}, 30)};
    return to;
}

BenchmarkScene plain_scene(const std::vector<Material>& materials) {
    BenchmarkScene to = named("plain with a box", materials);
    to.scene.meshes.push_back(sheet(1, 1, [](double u, double v) {
        return Vec3{40 * (u - 0.5), 0, 40 * (v - 0.5)};
    }));
    to.scene.meshes.push_back(box({1.2, 0.6, 0.7}));
    place(to, "ground", 0, {0, 0, 0}, 1);
    place(to, "target", 1, {0, 0, 0}, 0);
    to.scene.cameras = {camera_from({4, 7, 11}, {0, 0.3, 0}, 30)};
    return to;
}

BenchmarkScene canyon_scene(const std::vector<Material>& materials) {
    BenchmarkScene to = named("canyon, most sky hidden", materials);
    constexpr int kTowers = 24;
    to.scene.meshes.push_back(sheet(64, 64, [](double u, double v) {
        return Vec3{120 * (u - 0.5), 0.02 * std::sin(40 * u) * std::sin(37 * v), 120 * (v - 0.5)};
    }));
    to.scene.meshes.push_back(box({1.5, 6, 1.5}));
    to.scene.meshes.push_back(box({1.5, 9, 1.5}));
    place(to, "ground", 0, {0, 0, 0}, 1);
    for (int i = 0; i < kTowers; ++i)
        for (int j = 0; j < kTowers; ++j)
            place(to, "tower", 1 + (i + 2 * j) % 2,
                  {5.0 * (i - kTowers / 2) + 2.5, 0, 5.0 * (j - kTowers / 2) + 2.5}, (i + j) % 2);
    to.scene.cameras = {camera_from({0.4, 3, 14}, {-1, 2.2, 0}, 60)};
    return to;
}

BenchmarkScene bumps_scene() {
    Material paint;
    paint.name = paint.place = "rough conductor";
    // B = 1, no shadowing, no volume; σ = α/√2 for Mitsuba's α = 0.18.
    const PriestGermer<double> p{1.366, 0.2746, 1, 0.13, 1, 0, 0, 0};
    paint.rows = {{400, p}, {700, p}};
    BenchmarkScene to = named("bumps, as Mitsuba's", {paint});
    to.scene.meshes.push_back(sheet(1, 1, [](double u, double v) {
        return Vec3{40 * (u - 0.5), 0, 40 * (v - 0.5)};
    }));
    to.scene.meshes.push_back(sheet(320, 156, [](double u, double v) {
        const double z = kPi * v, a = 2 * kPi * u;
        const double r = 1 + 0.03 * std::sin(9 * z) * std::sin(14 * a) * std::sin(z);
        return Vec3{r * std::sin(z) * std::sin(a), r * std::cos(z), -r * std::sin(z) * std::cos(a)};
    }));
    place(to, "ground", 0, {0, 0, 0}, 0);
    place(to, "sphere", 1, {0, 1, 0}, 0);
    to.scene.cameras = {camera_from({2, 4.2, 4.5}, {0, 0.7, 0}, 35)};
    to.max_depth = 3;
    return to;
}

Sky even_sky(const std::vector<double>& wavelengths_nm) {
    Sky sky;
    sky.wavelengths_nm = wavelengths_nm;
    for (int i = 0; i <= 18; ++i) sky.zeniths.push_back(to_radians(5.0 * i));
    for (int i = 0; i < 36; ++i) sky.azimuths.push_back(to_radians(10.0 * i));
    sky.nodes.assign(wavelengths_nm.size() * sky.zeniths.size() * sky.azimuths.size(),
                     {1, 0, 0, 0});
    return sky;
}

}  // namespace malus
