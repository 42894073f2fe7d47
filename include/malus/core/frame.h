// frame.h — directions in the world by zenith and azimuth, and orthonormal bases around a normal.
//
//   w = (sin z · sin a, cos z, −sin z · cos a),  z = 0: +Y;  a = 0: north (−Z), 90°: east (+X)
//
// Units   radians.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/core/real.h"
#include "malus/core/vec.h"

namespace malus {

inline constexpr Vec3 kUp{0, 1, 0};
inline constexpr Vec3 kNorth{0, 0, -1};

inline Vec3 direction(double zenith, double azimuth) {
    return {std::sin(zenith) * std::sin(azimuth), std::cos(zenith),
            -std::sin(zenith) * std::cos(azimuth)};
}
/// Angle from +Y, [0, π]; exact also near the zenith, where acos is not.
inline double zenith_of(const Vec3& w) {
    return std::atan2(std::hypot(w.x, w.z), w.y);
}
/// Clockwise from north as seen from above, [0, 2π); 0 at the zenith and the nadir.
template <class R>
R azimuth_of(const Vector3<R>& w) {
    const R zero = real<R>(0), whole = real<R>(2 * kPi);
    const R a = angle_of(w.x, zero - w.z);  // 0 where both are
    // A tiny negative angle plus 2π rounds to 2π, which is the same azimuth as 0.
    const R folded = select(a < zero, a + whole, a);
    return select(folded < whole, folded, zero);
}
inline double azimuth_of(const Vec3& w) {
    return azimuth_of<double>(w);
}

/// Some unit vector perpendicular to the unit vector n.
template <class R>
Vector3<R> any_perpendicular(const Vector3<R>& n) {
    using std::abs;
    const R zero = real<R>(0), one = real<R>(1);
    const auto across_x = abs(n.x) < real<R>(0.5);
    const Vector3<R> axis{select(across_x, one, zero), select(across_x, zero, one), zero};
    return normalize(axis - dot(axis, n) * n);
}

template <class Mask, class R>
Vector3<R> select(const Mask& condition, const Vector3<R>& yes, const Vector3<R>& no) {
    return {select(condition, yes.x, no.x), select(condition, yes.y, no.y),
            select(condition, yes.z, no.z)};
}

/// Right-handed orthonormal basis with n as its third axis.
template <class R>
struct BasisOf {
    Vector3<R> s, t, n;

    explicit BasisOf(const Vector3<R>& normal)
        : s(any_perpendicular(normal)), t(cross(normal, s)), n(normal) {}
    /// With s toward `along` as far as it is across the normal: turns with the scene, where the
    /// other form knows the world's axes.
    BasisOf(const Vector3<R>& normal, const Vector3<R>& along) : n(normal) {
        const Vector3<R> across = along - dot(along, n) * n;
        const R norm = length(across);
        const auto none = norm < real<R>(1e-9);
        s = across / select(none, real<R>(1), norm);
        if (any(none)) s = select(none, any_perpendicular(n), s);
        t = cross(n, s);
    }
    Vector3<R> to_local(const Vector3<R>& v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
    Vector3<R> to_world(const Vector3<R>& v) const { return v.x * s + v.y * t + v.z * n; }
};
using Basis = BasisOf<double>;

}  // namespace malus
