// fresnel.h — reflection of a plane facet with complex index N = n + ik.
//
//   rs = (cos β − g)/(cos β + g)      g = N cos t = √(N² − sin²β), principal branch
//   rp = (N cos β − cos t)/(N cos β + cos t) = rs (sin²β − g cos β)/(sin²β + g cos β)
//   (S0+S1) → |rs|²(S0+S1)    (S0−S1) → |rp|²(S0−S1)    (S2+iS3) → rs rp* (S2+iS3)
//
// Frame   x = s = unit(k_in × k_out) on both beams; stokes.h defines a frame and all signs.
// Range   |S| ≤ S0 is kept; β in [0, π/2), n > 0, k ≥ 0, |N| ≥ 0.05 (below, floats cancel).
// Error   a few roundings of T: N² − sin²β is formed as (n−1)(n+1) − k² + 2ink + cos²β, which does
//         not cancel near n = 1, and √ by the larger of its two parts.
// Source  Born & Wolf, Principles of Optics, 7th ed., §1.5 and §14.2; sign of rp as Verdet.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/optics/stokes.h"

namespace malus {

/// Mueller matrix of a facet in its own frame: [[a, b, 0, 0], [b, a, 0, 0], [0, 0, re, −im],
/// [0, 0, im, re]] with a = ½(Rs + Rp), b = ½(Rs − Rp). Kept as Rs and Rp, so that light wholly
/// polarized along p leaves a facet at Brewster's angle as 0 and not as a rounded difference.
template <class T>
struct FacetMueller {
    T Rs, Rp;  ///< |rs|², |rp|²
    T re, im;  ///< of rs rp*

    T a() const { return real<T>(0.5) * (Rs + Rp); }
    T b() const { return real<T>(0.5) * (Rs - Rp); }

    friend FacetMueller operator*(const T& w, const FacetMueller& m) {
        return {w * m.Rs, w * m.Rp, w * m.re, w * m.im};
    }
    friend Stokes<T> operator*(const FacetMueller& m, const Stokes<T>& S) {
        const T s = real<T>(0.5) * m.Rs * (S.s0 + S.s1), p = real<T>(0.5) * m.Rp * (S.s0 - S.s1);
        return {s + p, s - p, m.re * S.s2 - m.im * S.s3, m.im * S.s2 + m.re * S.s3};
    }
};

template <class T>
struct Complex {
    T re, im;
};

/// √(re + i im) in the first quadrant, for im ≥ 0.
template <class T>
Complex<T> sqrt_upper(const T& re, const T& im) {
    using std::abs, std::max, std::sqrt;
    // The squares may be below T's numbers; what they leave is not.
    const T modulus = max(sqrt(re * re + im * im), max(abs(re), im));
    const T square = real<T>(0.5) * (modulus + abs(re));
    const T inverse = inverse_sqrt(max(square, real<T>(1e-37)));
    const T larger = square * inverse, smaller = real<T>(0.5) * im * inverse;
    const auto right = re >= real<T>(0);
    return {select(right, larger, smaller), select(right, smaller, larger)};
}

/// N² − 1, N = n + ik.
template <class T>
Complex<T> contrast(const T& n, const T& k) {
    return {(n - real<T>(1)) * (n + real<T>(1)) - k * k, real<T>(2) * n * k};
}

/// Reflection by a facet of contrast N² − 1 under the angle of incidence β.
template <class T>
FacetMueller<T> fresnel(const Complex<T>& contrast, const T& cos_beta) {
    const T& c = cos_beta;
    const T c2 = c * c, s2 = real<T>(1) - c2;
    const Complex<T> g = sqrt_upper(contrast.re + c2, contrast.im);
    const T g2 = g.im * g.im, re_c = g.re * c, im_c = g.im * c, im_c2 = im_c * im_c;

    // rs = (c − g)/(c + g), q = rp/rs = (s² − gc)/(s² + gc); rs rp* = |rs|² q*.
    const T rs_above = sqr(c - g.re) + g2, rs_below = sqr(c + g.re) + g2;
    const T q_above = sqr(s2 - re_c) + im_c2, q_below = sqr(s2 + re_c) + im_c2;
    const T common = rs_above * inverse(rs_below * q_below);
    return {common * q_below, common * q_above, common * ((s2 - re_c) * (s2 + re_c) - im_c2),
            common * (s2 + s2) * im_c};
}
template <class T>
FacetMueller<T> fresnel(const T& n, const T& k, const T& cos_beta) {
    return fresnel(contrast(n, k), cos_beta);
}

}  // namespace malus
