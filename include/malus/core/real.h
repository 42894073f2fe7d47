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

/// 1/x, and 1/√x for x > 0. Inverses<T> says how where there is something quicker than dividing, to 2
/// roundings of T.
template <class T>
struct Inverses {
    static T of(const T& x) { return real<T>(1) / x; }
    static T of_sqrt(const T& x) {
        using std::sqrt;
        return real<T>(1) / sqrt(x);
    }
};
template <class T>
T inverse(const T& x) {
    return Inverses<T>::of(x);
}
template <class T>
T inverse_sqrt(const T& x) {
    return Inverses<T>::of_sqrt(x);
}

/// e^x for x ≤ 0 of any size, −∞ included, to 2 roundings; 0 where T has no more normal numbers. In
/// registers 2^n e^r with x = n ln 2 + r, e^r a polynomial fitted at Chebyshev points.
template <class T>
T decay(const T& x) {
    if constexpr (kLaneCount<T> == 1) {
        return x > -708 ? std::exp(x) : 0;
    } else {
        constexpr bool kDouble = std::is_same_v<typename T::value_type, double>;
        const T least = real<T>(kDouble ? -708.0 : -87.0), within = max(x, least);
        const T n = nearbyint(within * real<T>(1.4426950408889634074));
        // ln 2 in two parts, the first so short that its product with n is exact.
        const T r = (within - n * real<T>(kDouble ? 0x1.62e42fefap-1 : 0x1.63p-1)) -
                    n * real<T>(kDouble ? 1.6465949582897082e-12 : -2.1219444005469057e-4);
        if constexpr (kDouble) {
            constexpr std::array<double, 12> kExp{1.0,
                                                  1.0,
                                                  0.5000000000000019,
                                                  0.1666666666666668,
                                                  0.0416666666664881,
                                                  0.008333333333319601,
                                                  0.0013888888952314775,
                                                  0.00019841269890047113,
                                                  2.4801485482328494e-05,
                                                  2.755724091857897e-06,
                                                  2.763263963904103e-07,
                                                  2.5110037605963777e-08};
            return select(x > least, ldexp(polynomial(kExp, r), to_int(n)), real<T>(0));
        } else {
            constexpr std::array<double, 7> kExp{1.0,
                                                 1.000000037716214,
                                                 0.5000000047117757,
                                                 0.16666415514653277,
                                                 0.04166635289677516,
                                                 0.008375126398153335,
                                                 0.0013941108433972674};
            return select(x > least, ldexp(polynomial(kExp, r), to_int(n)), real<T>(0));
        }
    }
}

}  // namespace malus
