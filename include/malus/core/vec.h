// vec.h — vectors in space and affine maps between coordinate systems.
//
// World  glTF's: right-handed, +Y up, metres. North = −Z, east = +X (frame.h).
// Double for placement and geometry, float for what is stored by the million, vector registers of
// doubles for paths that are traced side by side.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace malus {

inline constexpr double kPi = 3.14159265358979323846;

constexpr double to_radians(double degrees) {
    return degrees * (kPi / 180.0);
}
constexpr double to_degrees(double radians) {
    return radians * (180.0 / kPi);
}
template <class T>
constexpr T sqr(const T& x) {
    return x * x;
}

template <class T>
struct Vector3 {
    T x{}, y{}, z{};

    constexpr Vector3() = default;
    constexpr Vector3(T x_, T y_, T z_) : x(x_), y(y_), z(z_) {}
    template <class U>
    explicit constexpr Vector3(const Vector3<U>& v)
        : x(static_cast<T>(v.x)), y(static_cast<T>(v.y)), z(static_cast<T>(v.z)) {}

    constexpr Vector3 operator-() const { return {-x, -y, -z}; }
    constexpr Vector3& operator+=(const Vector3& b) { return *this = *this + b; }

    friend constexpr Vector3 operator+(const Vector3& a, const Vector3& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend constexpr Vector3 operator-(const Vector3& a, const Vector3& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend constexpr Vector3 operator*(T s, const Vector3& a) {
        return {s * a.x, s * a.y, s * a.z};
    }
    friend constexpr Vector3 operator*(const Vector3& a, T s) { return s * a; }
    friend constexpr Vector3 operator/(const Vector3& a, T s) {
        return {a.x / s, a.y / s, a.z / s};
    }
    friend constexpr bool operator==(const Vector3&, const Vector3&) = default;
};

using Vec3 = Vector3<double>;
using Vec3f = Vector3<float>;

template <class T>
constexpr T dot(const Vector3<T>& a, const Vector3<T>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T length(const Vector3<T>& a) {
    using std::sqrt;
    return sqrt(dot(a, a));
}
/// a/|a|; a must not be zero.
template <class T>
Vector3<T> normalize(const Vector3<T>& a) {
    return a / length(a);
}
template <class T>
bool is_finite(const Vector3<T>& a) {
    return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
template <class T>
Vector3<T> min(const Vector3<T>& a, const Vector3<T>& b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
template <class T>
Vector3<T> max(const Vector3<T>& a, const Vector3<T>& b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

/// p ↦ x·p.x + y·p.y + z·p.z + t: the columns of a 3×3 matrix and a translation, in double.
struct Affine {
    Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, t{0, 0, 0};

    Vec3 vector(const Vec3& v) const { return v.x * x + v.y * y + v.z * z; }
    Vec3 point(const Vec3& p) const { return vector(p) + t; }
    /// A normal's image up to length: the cofactor matrix, which needs no inverse. It maps
    /// (b−a)×(c−a) to the same product of the mapped points, under mirroring too.
    Vec3 normal(const Vec3& n) const {
        return n.x * cross(y, z) + n.y * cross(z, x) + n.z * cross(x, y);
    }
    double determinant() const { return dot(x, cross(y, z)); }

    /// (a*b).point(p) = a.point(b.point(p)).
    friend Affine operator*(const Affine& a, const Affine& b) {
        return {a.vector(b.x), a.vector(b.y), a.vector(b.z), a.point(b.t)};
    }
};

/// An axis-aligned box; empty until the first point is added.
struct Box {
    Vec3 lower{HUGE_VAL, HUGE_VAL, HUGE_VAL}, upper{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

    void add(const Vec3& p) {
        lower = min(lower, p);
        upper = max(upper, p);
    }
    bool empty() const { return !(lower.x <= upper.x); }
    Vec3 center() const { return 0.5 * lower + 0.5 * upper; }
    Vec3 corner(int i) const {
        return {i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z};
    }
};

}  // namespace malus
