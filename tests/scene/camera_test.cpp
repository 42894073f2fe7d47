// camera_test.cpp — rays, frames and automatic views.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/camera.h"

#include "malus/core/frame.h"
#include "support/catch.h"

using namespace malus;

namespace {

Box unit_box() {
    Box box;
    box.add({-1, 0, -1});
    box.add({1, 0.5, 1});
    return box;
}

void check_equal(const Vec3& a, const Vec3& b) {
    CHECK(a.x == near(b.x, 1e-12));
    CHECK(a.y == near(b.y, 1e-12));
    CHECK(a.z == near(b.z, 1e-12));
}

}  // namespace

TEST_CASE("Directions: north is −Z, east is +X, azimuth runs clockwise from above") {
    check_equal(direction(0, 1), {0, 1, 0});
    check_equal(direction(kPi / 2, 0), {0, 0, -1});
    check_equal(direction(kPi / 2, kPi / 2), {1, 0, 0});
    check_equal(direction(kPi / 2, kPi), {0, 0, 1});
    for (double z : {0.01, 0.5, 1.5})
        for (double a : {0.1, 1.9, 4.0, 6.2}) {
            CHECK(zenith_of(direction(z, a)) == Approx(z));
            CHECK(azimuth_of(direction(z, a)) == Approx(a));
        }
}

TEST_CASE("Directions: a hair west of north is north, not a full turn") {
    CHECK(azimuth_of({-1e-17, 0, -1}) == 0);
    CHECK(azimuth_of({-1e-12, 0, -1}) == near(2 * kPi, 1e-11));
    CHECK(azimuth_of({-1e-12, 0, -1}) < 2 * kPi);
}

TEST_CASE("View: from the north, image right is west, up is away from the ground") {
    const Camera camera = frame_view({to_radians(60), 0, {}, 0.05}, unit_box(), 100, 100);
    check_equal(camera.right, {-1, 0, 0});
    CHECK(camera.up.y > 0);
    check_equal(cross(camera.right, camera.up), -camera.forward);
    check_equal(-camera.forward, direction(to_radians(60), 0));
}

TEST_CASE("View: straight down and straight up have north at the top") {
    for (double zenith : {0.0, 180.0}) {
        const Camera camera =
            frame_view({to_radians(zenith), to_radians(77), {}, 0.05}, unit_box(), 100, 100);
        check_equal(camera.up, kNorth);
        check_equal(camera.forward, {0, zenith == 0 ? -1.0 : 1.0, 0});
        check_equal(cross(camera.right, camera.up), -camera.forward);
    }
}

TEST_CASE("View: the whole box is in the picture, and the margin is free") {
    for (double zenith : {0.0, 30.0, 85.0})
        for (double fov : {0.0, 20.0, 60.0}) {
            View view{to_radians(zenith), to_radians(40), {}, 0.05};
            if (fov > 0) view.yfov = to_radians(fov);
            const Box box = unit_box();
            const Camera camera = frame_view(view, box, 200, 100);
            double most = 0;
            for (int i = 0; i < 8; ++i) {
                const Vec3 d = box.corner(i) - camera.position;
                const double depth = dot(d, camera.forward);
                CHECK(depth > 0);
                const double scale = fov > 0 ? 1 / (depth * std::tan(to_radians(fov) / 2))
                                             : 1 / std::max(camera.ymag, camera.xmag / 2);
                most = std::max({most, std::abs(dot(d, camera.up)) * scale,
                                 std::abs(dot(d, camera.right)) * scale / 2});
            }
            CHECK(most == Approx(0.9).epsilon(1e-6));
        }
}

TEST_CASE("Camera: rays of the corners span the field of view") {
    Camera camera;
    camera.projection = Projection::kPerspective;
    camera.yfov = to_radians(90);
    const Ray top = Picture(camera, 400, 200).ray(200, 0);
    check_equal(top.direction, normalize(Vec3{0, 1, -1}));
    const Ray left = Picture(camera, 400, 200).ray(0, 100);
    check_equal(left.direction, normalize(Vec3{-2, 0, -1}));
}

TEST_CASE("Camera frame: x is image right made perpendicular to the beam, y is image up") {
    Camera camera;
    const BeamFrame center = image_frame(camera, -camera.forward);
    check_equal(center.x, camera.right);
    check_equal(center.y(), camera.up);
    const Vec3 k = normalize(Vec3{0.4, -0.2, 1});
    const BeamFrame frame = image_frame(camera, k);
    CHECK(dot(frame.x, k) == near(0, 1e-15));
    CHECK(dot(frame.x, camera.right) > 0);
    CHECK(dot(frame.y(), camera.up) > 0);
}

TEST_CASE("Camera roll: turning the camera by r changes AoLP by −r and leaves DoLP alone") {
    const Vec3 k{0, 0, 1};
    const Beam<double> light{{1, 0.3, 0.4, 0.1}, {k, {1, 0, 0}}};
    Camera camera;
    const auto seen = [&](double roll) {
        Camera rolled = camera;
        // Counter-clockwise as the observer behind the camera sees it: right turns toward up.
        rolled.right = std::cos(roll) * camera.right + std::sin(roll) * camera.up;
        rolled.up = std::cos(roll) * camera.up - std::sin(roll) * camera.right;
        return measured_in(light, image_frame(rolled, k)).stokes;
    };
    for (double roll : {0.1, 0.7, 2.0, -1.0}) {
        CHECK(dolp(seen(roll)) == Approx(dolp(seen(0))));
        CHECK(std::sin(aolp(seen(roll)) - (aolp(seen(0)) - roll)) == near(0, 1e-12));
    }
}
