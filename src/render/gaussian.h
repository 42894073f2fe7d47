// gaussian.h — the normal distribution's functions, for doubles and for registers of them.
//
// Error   gauss_tail: erfc to 4e-11 of itself for |x| ≤ 10. gaussian_slope: the share of slopes
//         below y to 1e-6 of itself or of the rest, but for the outermost millionths.
// Source  erfcx(x) = e^{x²} erfc(x) is a polynomial in (x − 2.5)/(x + 2.5), fitted at Chebyshev points
//         (the map is Schonfelder's, Math. Comp. 32, 1232 (1978)); erf⁻¹ by Giles, Approximating the
//         erfinv function, GPU Computing Gems 2 (2010), table 5.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/core/real.h"

namespace malus {

inline constexpr double kInvSqrtPi = 0.56418958354775628695;

template <class R>
struct GaussTail {
    R gauss;  ///< e^{−x²}/√π
    R erfc;   ///< erfc(x)
};
template <class R>
GaussTail<R> gauss_tail(const R& x) {
    using std::abs, std::exp;
    constexpr std::array<double, 13> kErfcx{
        0.21080636405938838,     -0.37173673385911632,   0.25171319329680902,
        -0.12503305727940478,    0.039922540263977478,   -0.0039936259608116193,
        -0.0026423892435250922,  0.00087540646605642502, 0.00022844168622829567,
        -0.00012711305527925927, -3.390310333595123e-05, 1.5490169179885307e-05,
        6.1195550200803789e-06};
    const R size = abs(x), e = exp(-x * x);
    const R t = (size - real<R>(2.5)) / (size + real<R>(2.5));
    const R tail = e * polynomial(kErfcx, t);
    return {real<R>(kInvSqrtPi) * e, select(x < real<R>(0), real<R>(2) - tail, tail)};
}

/// y with ½ erfc(−y) = u, 0 < u < 1: a slope of density e^{−y²}/√π.
template <class R>
R gaussian_slope(const R& u) {
    using std::log, std::sqrt, std::max;
    constexpr std::array<double, 9> kMiddle{1.50140941,     0.246640727,   -0.00417768164,
                                            -0.00125372503, 0.00021858087, -4.39150654e-6,
                                            -3.5233877e-6,  3.43273939e-7, 2.81022636e-8};
    constexpr std::array<double, 9> kTails{2.83297682,    1.00167406,     0.00943887047,
                                           -0.0076224613, 0.00573950773,  -0.00367342844,
                                           0.00134934322, 0.000100950558, -0.000200214257};
    const R w = -log(real<R>(4) * u * (real<R>(1) - u));
    const auto in_tails = w >= real<R>(5);
    R inverse = polynomial(kMiddle, w - real<R>(2.5));
    if (any(in_tails))
        inverse =
            select(in_tails, polynomial(kTails, sqrt(max(w, real<R>(0))) - real<R>(3)), inverse);
    return inverse * (u + u - real<R>(1));
}

}  // namespace malus
