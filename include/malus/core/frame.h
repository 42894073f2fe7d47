// frame.h — directions in the world by zenith and azimuth, and orthonormal bases around a normal.
//
//   w = (sin z · sin a, cos z, −sin z · cos a),  z = 0: +Y;  a = 0: north (−Z), 90°: east (+X)
//
// Units   radians.
// SPDX-License-Identifier: Apache-2.0
#pragma once

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
inline double azimuth_of(const Vec3& w) {
    if (w.x == 0 && w.z == 0) return 0;
    const double a = std::atan2(w.x, -w.z);
    // A tiny negative angle plus 2π rounds to 2π, which is the same azimuth as 0.
    const double folded = a < 0 ? a + 2 * kPi : a;
    return folded < 2 * kPi ? folded : 0;
}

/// Some unit vector perpendicular to the unit vector n.
inline Vec3 any_perpendicular(const Vec3& n) {
    const Vec3 axis = std::abs(n.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    return normalize(axis - dot(axis, n) * n);
}

/// Right-handed orthonormal basis with n as its third axis.
struct Basis {
    Vec3 s, t, n;

    explicit Basis(const Vec3& normal)
        : s(any_perpendicular(normal)), t(cross(normal, s)), n(normal) {}
    /// With s toward `along` as far as it is across the normal: turns with the scene, where the
    /// other form knows the world's axes.
    Basis(const Vec3& normal, const Vec3& along) : n(normal) {
        const Vec3 across = along - dot(along, n) * n;
        const double norm = length(across);
        s = norm < 1e-9 ? any_perpendicular(n) : across / norm;
        t = cross(n, s);
    }
    Vec3 to_local(const Vec3& v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
    Vec3 to_world(const Vec3& v) const { return v.x * s + v.y * t + v.z * n; }
};

}  // namespace malus
