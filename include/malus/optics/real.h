// real.h — what lets one text of an equation serve a double and a vector of wavelengths.
//
// The optics headers are templates over the number type T: double for tests and tables, a vector
// of float lanes (one wavelength a lane) in the renderer. Arithmetic, sqrt, exp, min, max and
// select are found by argument-dependent lookup; these are double's versions of what std lacks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace malus {

inline double select(bool condition, double yes, double no) {
    return condition ? yes : no;
}

/// A number that all wavelengths share, as a T.
template <class T>
T real(double x) {
    if constexpr (std::is_same_v<T, double>)
        return x;
    else
        return T(static_cast<typename T::value_type>(x));
}

/// e^x for x ≤ 0 of any size, −∞ included; 0 where T has no more normal numbers. The vector exp
/// alone would pass its argument through an integer, an invalid operation out of range.
template <class T>
T decay(const T& x) {
    using std::exp, std::max;
    const T least = real<T>(std::is_same_v<T, double> ? -708.0 : -87.0);
    return select(x > least, exp(max(x, least)), real<T>(0));
}

}  // namespace malus
