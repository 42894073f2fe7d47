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
Scene slanted_corner() {
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

Film picture(const Scene& scene, const Sky& sky, const Camera& camera,
             Lighting lighting = Lighting::kBoth) {
    RenderSettings settings;
    settings.width = settings.height = 16, settings.spp = 128, settings.max_depth = 3;
    settings.lighting = lighting;
    const PreparedScene prepared(scene, std::vector<int>(scene.instances.size(), 0),
                                 {green_paint()}, sky, kTwo);
    return render(prepared, camera, settings).film;
}

// Largest difference of S0 to S3, relative to S0.
double difference(const Stokes<double>& a, const Stokes<double>& b) {
    return std::max({std::abs(a.s0 - b.s0), std::abs(a.s1 - b.s1), std::abs(a.s2 - b.s2),
                     std::abs(a.s3 - b.s3)}) /
           a.s0;
}

// Largest difference of the picture's mean. A sample that changes sides at an edge is one of 32768.
double difference(const Film& a, const Film& b) {
    double most = 0;
    for (std::size_t w = 0; w < kTwo.size(); ++w)
        most = std::max(most, difference(picture_mean(a, w).mean, picture_mean(b, w).mean));
    return most;
}

// The difference that nine pixels in ten stay below; the tenth may have a sample at an edge.
double typical_difference(const Film& a, const Film& b) {
    std::vector<double> all;
    for (std::size_t i = 0; i < a.stokes.size(); ++i)
        if (a.stokes[i].mean.s0 > 0) all.push_back(difference(a.stokes[i].mean, b.stokes[i].mean));
    const auto ninth =
        all.begin() + static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(all.size()));
    std::nth_element(all.begin(), ninth, all.end());
    return *ninth;
}

// The picture after the scene and the camera have been mapped by a similarity.
Film mapped_picture(const Affine& map, const Sky& sky, Camera camera,
                    Lighting lighting = Lighting::kBoth) {
    Scene scene = slanted_corner();
    for (Instance& instance : scene.instances) instance.to_world = map * instance.to_world;
    camera.position = map.point(camera.position);
    for (Vec3* axis : {&camera.right, &camera.up, &camera.forward})
        *axis = normalize(map.vector(*axis));
    return picture(scene, sky, camera, lighting);
}

// About the unit axis by `angle`: Rodrigues' formula.
Affine rotation(const Vec3& axis, double angle) {
    const auto turned = [&](const Vec3& v) {
        return std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
               (1 - std::cos(angle)) * dot(axis, v) * axis;
    };
    return {turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1}), {}};
}

// A cap of light 25° wide, 30° off the zenith before `turn`, that stays above the horizon after it.
// Its electric field runs around an axis fixed in the cap, so that nothing but `turn` tells where
// up is.
Sky turned_cap(const Affine& turn) {
    const Vec3 center = turn.vector(direction(to_radians(30), to_radians(150)));
    const Vec3 axis = turn.vector(normalize(Vec3{0.8, 0.3, 0.5}));
    const auto light = [&](Vec3 w) -> reference::Stokes {
        const double angle = std::atan2(length(cross(center, w)), dot(center, w));
        const double x = angle / to_radians(25);
        if (x >= 1) return {};
        const double s0 = std::pow(1 - x * x, 3);
        return polarized_along(cross(axis, w), w, s0, 0.6 * s0, 0.3 * s0);
    };
    return sample_sky(light, kTwo, 360, 1440);
}

}  // namespace

TEST_CASE("Invariance: scene, sky and camera turned about the vertical together", "[render]") {
    const Film before = picture(slanted_corner(), polarized_map(), camera_at(160));
    for (double turn_deg : {1.0, 37.3, 90.0, 211.0}) {
        // Azimuth grows clockwise from above: x' = x cos a − z sin a, z' = x sin a + z cos a.
        const double a = to_radians(turn_deg), c = std::cos(a), s = std::sin(a);
        const Affine turn{{c, 0, s}, {0, 1, 0}, {-s, 0, c}, {0, 0, 0}};
        Sky sky = polarized_map();
        for (double& azimuth : sky.azimuths) azimuth += a;
        CAPTURE(turn_deg);
        const Film after = mapped_picture(turn, sky, camera_at(160));
        CHECK(difference(before, after) < 1e-5);
        CHECK(typical_difference(before, after) < 1e-5);
    }
}

TEST_CASE("Invariance: scene, sky and camera turned about any axis together", "[render]") {
    // Directions drawn by the surface turn with it and see the same sky, but for the cells of the
    // map, which do not turn: 0.25° under a cap whose second derivative is 30 rad⁻² leaves 7e-5 at
    // its steepest, of either sign.
    const auto surface_light = Lighting::kSurfaceSamples;
    const Film before = picture(slanted_corner(), turned_cap({}), camera_at(160), surface_light);
    const Film both = picture(slanted_corner(), turned_cap({}), camera_at(160));
    for (const auto& [axis, degrees] :
         {std::pair{Vec3{1, 0, 0}, 25.0}, {Vec3{0, 0, 1}, -20.0}, {Vec3{1, 0.6, -0.4}, 28.0}}) {
        const Affine turn = rotation(normalize(axis), to_radians(degrees));
        CAPTURE(axis.x, axis.z, degrees);
        const Sky sky = turned_cap(turn);
        const Film after = mapped_picture(turn, sky, camera_at(160), surface_light);
        CHECK(difference(before, after) < 3e-5);
        CHECK(typical_difference(before, after) < 1e-4);
        // Directions drawn by the sky's cells differ: within 4 standard errors (24 numbers: false
        // alarms 0.2 %).
        const Film drawn = mapped_picture(turn, sky, camera_at(160));
        for (std::size_t w = 0; w < kTwo.size(); ++w) {
            const PictureMean a = picture_mean(both, w), b = picture_mean(drawn, w);
            CHECK(std::abs(a.mean.s0 - b.mean.s0) < 4 * std::hypot(a.error.s0, b.error.s0));
            CHECK(std::abs(a.mean.s1 - b.mean.s1) < 4 * std::hypot(a.error.s1, b.error.s1));
            CHECK(std::abs(a.mean.s2 - b.mean.s2) < 4 * std::hypot(a.error.s2, b.error.s2));
            CHECK(std::abs(a.mean.s3 - b.mean.s3) < 4 * std::hypot(a.error.s3, b.error.s3));
        }
    }
}

TEST_CASE("Invariance: map coordinates of (5e5, 0, 4e6) m", "[render]") {
    const Film before = picture(slanted_corner(), polarized_map(), camera_at(160));
    const Affine move{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5e5, 0, 4e6}};
    const Film after = mapped_picture(move, polarized_map(), camera_at(160));
    CHECK(difference(before, after) < 1e-5);
    CHECK(typical_difference(before, after) < 1e-5);
}

TEST_CASE("Invariance: a scene a thousand times smaller and ten thousand times larger",
          "[render]") {
    const Film before = picture(slanted_corner(), polarized_map(), camera_at(160));
    for (double scale : {1e-3, 1e4}) {
        const Affine size{{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}, {0, 0, 0}};
        CAPTURE(scale);
        const Film after = mapped_picture(size, polarized_map(), camera_at(160));
        CHECK(difference(before, after) < 1e-5);
        CHECK(typical_difference(before, after) < 1e-5);
    }
}

TEST_CASE("Invariance: triangles split into four", "[render]") {
    const Film before = picture(slanted_corner(), polarized_map(), camera_at(160));
    Scene scene = slanted_corner();
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
    const Film after = picture(scene, polarized_map(), camera_at(160));
    CHECK(difference(before, after) < 1e-5);
    CHECK(typical_difference(before, after) < 1e-5);
}
