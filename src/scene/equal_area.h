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

#include "malus/core/real.h"
#include "malus/core/vec.h"

namespace malus {

template <class R>
struct SquarePointOf {
    R x, y;  ///< [0,1]
};
using SquarePoint = SquarePointOf<double>;

/// A direction above the horizon by what its solid angle is even in.
template <class R>
struct DomePointOf {
    R t;        ///< 1 − cos z, [0,1]
    R azimuth;  ///< rad, [0, 2π)
};
using DomePoint = DomePointOf<double>;

template <class R>
SquarePointOf<R> to_square(const DomePointOf<R>& p) {
    using std::floor, std::sqrt;
    const R half = real<R>(0.5), zero = real<R>(0);
    const R r = sqrt(p.t), eighths = p.azimuth * real<R>(4 / kPi);
    const R side = floor(half * (eighths + real<R>(1)));  // 0 top, 1 right, 2 bottom, 3 left, 4 top
    const R along = r * (eighths - (side + side));
    const R half_side = half * side;
    const auto across = floor(half_side) < half_side;  // 1 and 3
    // 1 at top and right, −1 at bottom and left.
    const auto far = (side > real<R>(1.5)) && (side < real<R>(3.5));
    const R sign = select(far, real<R>(-1), real<R>(1));
    const R a = sign * along, b = select(across, sign * r, zero - sign * r);
    return {half + half * select(across, b, a), half + half * select(across, a, b)};
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
