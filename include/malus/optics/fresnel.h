// fresnel.h — reflection of a plane facet with complex index N = n + ik.
//
//   rs = (cos β − N cos t)/(cos β + N cos t)      N cos t = √(N² − sin²β), principal branch
//   rp = (N cos β − cos t)/(N cos β + cos t)
//   (S0+S1) → |rs|²(S0+S1)    (S0−S1) → |rp|²(S0−S1)    (S2+iS3) → rs rp* (S2+iS3)
//
// Frame   x = s = unit(k_in × k_out) on both beams; stokes.h defines a frame and all signs.
// Range   |S| ≤ S0 is kept; β in [0, π/2), n > 0, k ≥ 0, |N| ≥ 0.05 (below, floats cancel).
// Error   a few roundings of T: N² − sin²β is formed as (n−1)(n+1) − k² + cos²β + 2ink, which does
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
    using std::abs, std::max, std::min, std::sqrt;
    const T zero = real<T>(0);
    const T big = max(abs(re), im), small = min(abs(re), im);
    const auto is_zero = big == zero;
    const T ratio = small / select(is_zero, real<T>(1), big);
    const T modulus = big * sqrt(real<T>(1) + ratio * ratio);
    const T larger = sqrt(real<T>(0.5) * (modulus + abs(re)));
    const T smaller = real<T>(0.5) * im / select(is_zero, real<T>(1), larger);
    return {select(re >= zero, larger, smaller), select(re >= zero, smaller, larger)};
}

/// Reflection by a facet of index n + ik under the angle of incidence β.
template <class T>
FacetMueller<T> fresnel(const T& n, const T& k, const T& cos_beta) {
    const T one = real<T>(1), two = real<T>(2);
    const T cos2 = cos_beta * cos_beta;
    const Complex<T> g = sqrt_upper((n - one) * (n + one) - k * k + cos2, two * n * k);  // N cos t

    // Numerators over denominators: rs = (c − g)/(c + g), rp = (N²c − g)/(N²c + g).
    const Complex<T> Nc{(n * n - k * k) * cos_beta, two * n * k * cos_beta};
    const T s_re = cos_beta - g.re, s_im = -g.im;
    const T p_re = Nc.re - g.re, p_im = Nc.im - g.im;
    const T sd_re = cos_beta + g.re, sd_im = g.im;
    const T pd_re = Nc.re + g.re, pd_im = Nc.im + g.im;
    const T s_norm = one / (sd_re * sd_re + sd_im * sd_im);
    const T p_norm = one / (pd_re * pd_re + pd_im * pd_im);
    const T Rs = (s_re * s_re + s_im * s_im) * s_norm;
    const T Rp = (p_re * p_re + p_im * p_im) * p_norm;

    // rs and rp as complex numbers, for the product rs rp*.
    const T rs_re = (s_re * sd_re + s_im * sd_im) * s_norm;
    const T rs_im = (s_im * sd_re - s_re * sd_im) * s_norm;
    const T rp_re = (p_re * pd_re + p_im * pd_im) * p_norm;
    const T rp_im = (p_im * pd_re - p_re * pd_im) * p_norm;
    return {Rs, Rp, rs_re * rp_re + rs_im * rp_im, rs_im * rp_re - rs_re * rp_im};
}

}  // namespace malus
