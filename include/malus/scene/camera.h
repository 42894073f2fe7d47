// camera.h — the detector: which ray belongs to a point of the picture.
//
// Frame   right, up, forward are orthonormal in the world, forward into the scene. A beam that
//         reaches the detector has the Stokes axis x = image right made perpendicular to the beam;
//         y is then image up, and AoLP counts counter-clockwise as displayed (image_frame).
// Units   metres, radians; picture coordinates in pixels, (0,0) the top left corner.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "malus/core/vec.h"
#include "malus/optics/stokes.h"

namespace malus {

enum class Projection { kPerspective, kOrthographic };

struct Camera {
    std::string name;
    Projection projection = Projection::kOrthographic;
    Vec3 position;  ///< pinhole, or a point of the plane where orthographic rays start
    Vec3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};
    double yfov = to_radians(30.0);  ///< rad, full vertical field of view; perspective only
    double xmag = 1, ymag = 1;       ///< m, half the width and height seen; orthographic only
};

template <class R>
struct RayOf {
    Vector3<R> origin, direction;
};
using Ray = RayOf<double>;

/// A camera's picture of width × height pixels. Pixels are square: a perspective camera keeps its
/// vertical field of view, an orthographic one shows at least xmag × ymag.
class Picture {
  public:
    Picture(const Camera& camera, int width, int height);
    /// The ray into the scene through picture point (px, py).
    template <class R = double>
    RayOf<R> ray(const std::type_identity_t<R>& px, const std::type_identity_t<R>& py) const {
        using V = Vector3<R>;
        const V offset = V(corner_) + px * V(across_) + py * V(down_);
        if (projection_ == Projection::kPerspective)
            return {V(position_), normalize(V(forward_) + offset)};
        return {V(position_) + offset, V(forward_)};
    }
    /// Between the rays of pixels beside each other in the middle, rad; 0: all rays are parallel.
    double pixel_angle() const { return projection_ == Projection::kPerspective ? pixel_ : 0; }

  private:
    Projection projection_;
    Vec3 position_, forward_;
    double pixel_;                 // its height, as corner_
    Vec3 corner_, across_, down_;  // to the top left corner, and a pixel to the right and down
};

/// The image frame of the beam that reaches the detector along k (out of the scene).
template <class R>
BeamFrameOf<R> image_frame(const Camera& camera, const Vector3<R>& k) {
    const Vector3<R> right(camera.right);
    return {k, normalize(right - dot(right, k) * k)};
}

/// A view from a direction: where the detector stands as seen from the target.
struct View {
    double zenith = 0, azimuth = 0;  ///< rad
    std::optional<double> yfov;  ///< rad, perspective with this vertical field; else orthographic
    double margin = 0.05;        ///< free border, as a fraction of the picture
};

/// A camera that sees all of `box` (not empty) in a picture of this shape. Image up is away from
/// the ground; north when looking straight down or up.
Camera frame_view(const View& view, const Box& box, int width, int height);

}  // namespace malus
