// invariance_test.cpp — what must not change a picture: where the scene stands, how it is turned, its
// size, and how its surfaces are cut into triangles.
//
// The same random numbers are used before and after, so pictures agree to the rounding of float
// rays; only a sample that grazes an edge may fall to its other side.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/frame.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kTwo{440, 600};

// Ground and a slanted wall, with concave light between them.
Scene corner_scene() {
    Scene scene;
    add_rectangle(scene, "ground", {-1, 0, 2}, {2, 0, 0}, {0, 0, -2});
    add_rectangle(scene, "wall", {-1, 0, 0}, {2, 0, 0}, {0, 1, 0.3});
    return scene;
}

Sky polarized_map() {
    return sample_sky(
        reference::rayleigh_sky(direction(to_radians(50), to_radians(150)), 1.0, 0.8, 0.1), kTwo,
        45, 180);
}

Camera camera_at(double azimuth_deg) {
    Camera camera = look_at({0, 0.3, 0.5}, 50, azimuth_deg, 0.4);
    camera.projection = Projection::kPerspective;
    camera.yfov = to_radians(6);
    return camera;
}

Film picture(const Scene& scene, const Sky& sky, const Camera& camera) {
    RenderSettings settings;
    settings.width = settings.height = 16, settings.spp = 128, settings.max_depth = 3;
    const PreparedScene prepared(scene, std::vector<int>(scene.instances.size(), 0),
                                 {green_paint()}, sky, kTwo);
    return render(prepared, camera, settings).film;
}

// Largest relative difference of S0, and of S1 and S2 relative to S0, over means of 4 × 4 pixels:
// a sample that changes sides at an edge is one of 2048.
double difference(const Film& a, const Film& b) {
    double most = 0;
    for (std::size_t w = 0; w < kTwo.size(); ++w) {
        const Stokes<double> x = picture_mean(a, w).mean, y = picture_mean(b, w).mean;
        most = std::max({most, std::abs(x.s0 - y.s0) / x.s0, std::abs(x.s1 - y.s1) / x.s0,
                         std::abs(x.s2 - y.s2) / x.s0, std::abs(x.s3 - y.s3) / x.s0});
    }
    return most;
}

// The picture after the scene and the camera have been mapped by a similarity.
Film mapped_picture(const Affine& map, const Sky& sky, Camera camera) {
    Scene scene = corner_scene();
    for (Instance& instance : scene.instances) instance.to_world = map * instance.to_world;
    camera.position = map.point(camera.position);
    for (Vec3* axis : {&camera.right, &camera.up, &camera.forward})
        *axis = normalize(map.vector(*axis));
    return picture(scene, sky, camera);
}

}  // namespace

TEST_CASE("Invariance: scene, sky and camera turned about the vertical together", "[render]") {
    const Film before = picture(corner_scene(), polarized_map(), camera_at(160));
    for (double turn_deg : {1.0, 37.3, 90.0, 211.0}) {
        // Azimuth grows clockwise from above: x' = x cos a − z sin a, z' = x sin a + z cos a.
        const double a = to_radians(turn_deg), c = std::cos(a), s = std::sin(a);
        const Affine turn{{c, 0, s}, {0, 1, 0}, {-s, 0, c}, {0, 0, 0}};
        Sky sky = polarized_map();
        for (double& azimuth : sky.azimuths) azimuth += a;
        CAPTURE(turn_deg);
        CHECK(difference(before, mapped_picture(turn, sky, camera_at(160))) < 2e-5);
    }
}

TEST_CASE("Invariance: map coordinates of (5e5, 0, 4e6) m", "[render]") {
    const Film before = picture(corner_scene(), polarized_map(), camera_at(160));
    const Affine move{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5e5, 0, 4e6}};
    CHECK(difference(before, mapped_picture(move, polarized_map(), camera_at(160))) < 1e-5);
}

TEST_CASE("Invariance: a scene a thousand times smaller and ten thousand times larger",
          "[render]") {
    const Film before = picture(corner_scene(), polarized_map(), camera_at(160));
    for (double scale : {1e-3, 1e4}) {
        const Affine size{{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}, {0, 0, 0}};
        CAPTURE(scale);
        CHECK(difference(before, mapped_picture(size, polarized_map(), camera_at(160))) < 1e-5);
    }
}

TEST_CASE("Invariance: triangles split into four", "[render]") {
    const Film before = picture(corner_scene(), polarized_map(), camera_at(160));
    Scene scene = corner_scene();
    for (Mesh& mesh : scene.meshes) {
        std::vector<std::array<std::uint32_t, 3>> split;
        for (const auto& t : mesh.triangles) {
            std::array<std::uint32_t, 3> mid{};
            for (std::size_t i = 0; i < 3; ++i) {
                mid[i] = static_cast<std::uint32_t>(mesh.positions.size());
                const Vec3f &p = mesh.positions[t[i]], &q = mesh.positions[t[(i + 1) % 3]];
                mesh.positions.push_back(0.5f * (p + q));
            }
            split.push_back({t[0], mid[0], mid[2]});
            split.push_back({mid[0], t[1], mid[1]});
            split.push_back({mid[2], mid[1], t[2]});
            split.push_back(mid);
        }
        mesh.triangles = split;
    }
    CHECK(difference(before, picture(scene, polarized_map(), camera_at(160))) < 1e-5);
}
