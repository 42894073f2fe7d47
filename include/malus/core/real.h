// real.h — what lets one text of an equation serve a double and a vector register.
//
// Templates over a number type T: double for tests and tables; in the renderer registers of double
// lanes for geometry (a path a lane) and of float lanes for light (a path and a wavelength a lane).
// Arithmetic, sqrt, exp, min, max, select and any are found by argument-dependent lookup; these are
// double's versions of what std lacks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

namespace malus {

inline double select(bool condition, double yes, double no) {
    return condition ? yes : no;
}

inline bool any(bool condition) {
    return condition;
}

/// How a G is made a T where both are registers of their own form.
template <class T, class G>
struct Conversion;

/// A number of the geometry, as a T.
template <class T, class G>
T real(const G& x) {
    if constexpr (std::is_same_v<T, G>)
        return x;
    else if constexpr (std::is_same_v<T, double>)
        return static_cast<double>(x);
    else if constexpr (std::is_arithmetic_v<G>)
        return T(static_cast<typename T::value_type>(x));
    else
        return Conversion<T, G>::of(x);
}

/// The numbers side by side in a T.
template <class T>
inline constexpr std::size_t kLaneCount = T::size;
template <>
inline constexpr std::size_t kLaneCount<double> = 1;

/// The number of one lane.
template <class T>
auto lane(const T& x, std::size_t i) {
    if constexpr (std::is_same_v<T, double>)
        return x;
    else
        return x.get(i);
}

template <class T>
struct CosSin {
    T cos, sin;
};
template <class T>
CosSin<T> cos_sin(const T& angle) {
    if constexpr (kLaneCount<T> == 1) {
        return {std::cos(angle), std::sin(angle)};
    } else {
        const auto both = sincos(angle);
        return {both.second, both.first};
    }
}

template <class T, std::size_t N>
T polynomial(const std::array<double, N>& coefficients, const T& x) {  // from the constant term up
    T sum = real<T>(coefficients[N - 1]);
    for (std::size_t i = N - 1; i-- > 0;) sum = sum * x + real<T>(coefficients[i]);
    return sum;
}

/// atan2(y, x), to 3e-13 of itself in registers: atan(t)/t is a polynomial in t², fitted at Chebyshev
/// points. 0 for y = x = 0.
template <class T>
T angle_of(const T& y, const T& x) {
    if constexpr (kLaneCount<T> == 1) {
        return std::atan2(y, x);
    } else {
        constexpr std::array<double, 15> kAtan{
            0.99999999999975009,   -0.33333333321788944,   0.19999999110999975,
            -0.14285687112699266,  0.11110673004470552,    -0.090866147145280726,
            0.076644773263741237,  -0.06540749198838075,   0.054692039389718831,
            -0.04251210859252539,  0.028635730316822063,   -0.015418219106909775,
            0.0060366331568645418, -0.0014985518678821157, 0.00017498916188775419};
        const T zero = real<T>(0), a = abs(y), b = abs(x);
        const T t = min(a, b) / max(max(a, b), real<T>(1e-300));
        T angle = t * polynomial(kAtan, t * t);
        angle = select(a > b, real<T>(1.57079632679489661923) - angle, angle);
        angle = select(x < zero, real<T>(3.14159265358979323846) - angle, angle);
        return select(y < zero, -angle, angle);
    }
}

/// e^x for x ≤ 0 of any size, −∞ included; 0 where T has no more normal numbers. The vector exp
/// alone would pass its argument through an integer, an invalid operation out of range.
template <class T>
T decay(const T& x) {
    using std::exp, std::max;
    constexpr bool kDouble = std::is_same_v<decltype(lane(x, 0)), double>;
    const T least = real<T>(kDouble ? -708.0 : -87.0);
    return select(x > least, exp(max(x, least)), real<T>(0));
}

}  // namespace malus
