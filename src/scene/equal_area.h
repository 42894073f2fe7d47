// equal_area.h — the dome of the sky on a square, so that equal areas are equal solid angles.
//
//   disc    radius r, r² = 1 − cos z: the horizon at 1 (Lambert's azimuthal map)
//   square  r = max(|x|, |y|); along the sides of each such square the azimuth goes evenly
//           (Shirley & Chiu, J. Graphics Tools 2(3), 45 (1997)); brought from [−1,1]² to [0,1]²
//
// The zenith lies in the middle, the horizon on the edges, azimuth 0 in the middle of the top edge;
// solid angle 2π on the whole.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "malus/core/vec.h"

namespace malus {

struct SquarePoint {
    double x, y;  ///< [0,1]
};

/// A direction above the horizon by what its solid angle is even in.
struct DomePoint {
    double t;        ///< 1 − cos z, [0,1]
    double azimuth;  ///< rad, [0, 2π)
};

inline SquarePoint to_square(const DomePoint& p) {
    const double r = std::sqrt(p.t), eighths = p.azimuth * (4 / kPi);
    const int side = static_cast<int>((eighths + 1) / 2) % 4;  // 0 top, 1 right, …
    const double turned = eighths - 2 * side;
    const double along = r * (turned > 1 ? turned - 8 : turned);
    switch (side) {
        case 0:
            return {0.5 * (1 + along), 0.5 * (1 - r)};
        case 1:
            return {0.5 * (1 + r), 0.5 * (1 + along)};
        case 2:
            return {0.5 * (1 - along), 0.5 * (1 + r)};
        default:
            return {0.5 * (1 - r), 0.5 * (1 - along)};
    }
}

inline DomePoint from_square(const SquarePoint& p) {
    const double x = 2 * p.x - 1, y = 2 * p.y - 1, r = std::max(std::abs(x), std::abs(y));
    if (r == 0) return {0, 0};
    double eighths = 0;
    if (-y == r)
        eighths = x / r;
    else if (x == r)
        eighths = 2 + y / r;
    else if (y == r)
        eighths = 4 - x / r;
    else
        eighths = 6 - y / r;
    return {r * r, kPi / 4 * (eighths < 0 ? eighths + 8 : eighths)};
}

}  // namespace malus
