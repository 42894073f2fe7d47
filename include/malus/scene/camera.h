// camera.h — the detector: which ray belongs to a point of the picture.
//
// Frame   right, up, forward are orthonormal in the world, forward into the scene. A beam that
//         reaches the detector has the Stokes axis x = image right made perpendicular to the beam;
//         y is then image up, and AoLP counts counter-clockwise as displayed (image_frame).
// Units   metres, radians; picture coordinates in pixels, (0,0) the top left corner.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "malus/core/vec.h"

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

}  // namespace malus
