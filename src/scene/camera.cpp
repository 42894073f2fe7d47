// camera.cpp — rays and automatic framing.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/camera.h"

#include "malus/core/frame.h"

namespace malus {
namespace {

void orient(Camera& camera, const View& view) {
    const Vec3 d = direction(view.zenith, view.azimuth);
    camera.forward = -d;
    // Exactly up or down the vertical has no image; sin π is not 0 in double.
    const bool vertical = std::hypot(d.x, d.z) < 1e-12;
    if (vertical) camera.forward = {0, d.y > 0 ? -1.0 : 1.0, 0};
    const Vec3 up = vertical ? kNorth : kUp;
    camera.up = normalize(up - dot(up, camera.forward) * camera.forward);
    camera.right = cross(camera.forward, camera.up);
}

}  // namespace

Picture::Picture(const Camera& camera, int width, int height)
    : projection_(camera.projection), position_(camera.position), forward_(camera.forward) {
    const double aspect = static_cast<double>(width) / height;
    // Half the height of what is seen: at distance 1, or on the camera's plane.
    const double half = projection_ == Projection::kPerspective
                            ? std::tan(0.5 * camera.yfov)
                            : std::max(camera.ymag, camera.xmag / aspect);
    pixel_ = 2 * half / height;
    corner_ = half * camera.up - half * aspect * camera.right;
    across_ = (2 * half * aspect / width) * camera.right;
    down_ = -pixel_ * camera.up;
}

Camera frame_view(const View& view, const Box& box, int width, int height) {
    Camera camera;
    camera.name = "view";
    orient(camera, view);
    // The box as seen: extents across the picture, and how far back it must be seen from.
    const double free = 1 - 2 * view.margin, aspect = static_cast<double>(width) / height;
    const double tan_y = std::tan(0.5 * view.yfov.value_or(kPi / 2)), tan_x = tan_y * aspect;
    double half_x = 0, half_y = 0, radius = 0, back = 0;
    for (int i = 0; i < 8; ++i) {
        const Vec3 p = box.corner(i) - box.center();
        const double x = std::abs(dot(p, camera.right)), y = std::abs(dot(p, camera.up));
        half_x = std::max(half_x, x), half_y = std::max(half_y, y);
        radius = std::max(radius, length(p));
        back = std::max(back, std::max(x / tan_x, y / tan_y) / free - dot(p, camera.forward));
    }
    const double least = std::max(1e-9, 1e-9 * radius);
    camera.xmag = std::max(half_x / free, least);
    camera.ymag = std::max(half_y / free, least);
    if (view.yfov) {
        camera.projection = Projection::kPerspective;
        camera.yfov = *view.yfov;
        camera.position = box.center() - std::max(back, least) * camera.forward;
    } else {
        camera.position = box.center() - (1.01 * radius + least) * camera.forward;
    }
    return camera;
}

}  // namespace malus
