// priest_germer.h — polarized reflection of a rough painted surface, per wavelength.
//
//   f = P(θ) · SO(θ,β) · [G] · M(β) / (4 cosθi cosθo)  +  f_vol · E00                     [sr⁻¹]
//   P  = B exp(−tan²θ/(2σ²)) / (2π σ² cos³θ)   Gaussian slopes
//   P  = B / (cosθ (σ² + tan²θ))               Cauchy slopes
//   SO = (1 + (θ/Ω) e^{−2β/τ}) / (1 + θ/Ω)     shadowing and obscuration
//   G  = min(1, 2 cosθ cosθi/cosβ, 2 cosθ cosθo/cosβ)   Torrance-Sparrow, where asked for
//   f_vol = max(0, ρd + 2ρv/(cosθi + cosθo)),  E00 the matrix whose only entry is [0][0] = 1
//
// Angles  wi toward the light, wo toward the sensor, both away from the surface; h = unit(wi + wo)
//         the facet normal; θ its tilt (cosθ = n·h), β the incidence on it (cosβ = wi·h); radians.
// Frame   M is fresnel.h's matrix, s = unit(k_in × k_out) on both beams, k_in = −wi, k_out = wo.
// Range   |S| ≤ S0 is kept, f = 0 when cosθi ≤ 0 or cosθo ≤ 0; reciprocal: M(wo→wi) = D Mᵀ D with
//         D = diag(1,1,−1,1). Diverges at grazing as 1/(cosθi cosθo): the model's own limit.
// Source  Priest & Germer, Polarimetric BRDF in the Microfacet Model, Meeting of the Military
//         Sensing Symposia, Passive Sensors (2000); Priest & Meier, Opt. Eng. 41, 988 (2002);
//         Torrance & Sparrow, JOSA 57, 1105 (1967).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/core/frame.h"
#include "malus/optics/fresnel.h"

namespace malus {

enum class Slopes { kGaussian, kCauchy };
enum class Attenuation { kNone, kTorranceSparrow };

/// The parameters of a surface at one wavelength (T = double) or several (T = lanes).
template <class T>
struct PriestGermer {
    T n, k;            ///< complex index n + ik
    T B, sigma;        ///< lobe strength, RMS slope
    T tau, inv_omega;  ///< rad, rad⁻¹; inv_omega = 0: no shadowing
    T rho_d, rho_v;    ///< sr⁻¹
};

/// The geometry of one reflection, shared by all wavelengths (R: double, or a path a lane).
template <class R>
struct ReflectionOf {
    R cos_i, cos_o;          ///< wi·n, wo·n
    R theta, cos_theta;      ///< tilt of the facet, rad
    R tan2_theta;            ///< tan²θ, exact also for small tilts
    R beta, cos_beta;        ///< incidence on the facet, rad
    BeamFrameOf<R> in, out;  ///< the facet's own frame on the two beams
};
using Reflection = ReflectionOf<double>;

/// Needs unit vectors with wi·n > 0 and wo·n > 0.
template <class R>
ReflectionOf<R> reflection(const Vector3<R>& n, const Vector3<R>& wi, const Vector3<R>& wo) {
    const Vector3<R> sum = wi + wo, difference = wi - wo;
    const R along = dot(n, sum), across = length(cross(n, sum));
    const R sum_length = length(sum);
    // s = unit(k_in × k_out) up to sign. Near retro-reflection |rs|² − |rp|² is of order β²: under
    // 1e-7 any axis gives the same matrix to double precision.
    const Vector3<R> s = cross(wi, wo);
    const R s_length = length(s);
    const auto retro = s_length <= real<R>(1e-7);
    Vector3<R> axis = s / select(retro, real<R>(1), s_length);
    if (any(retro)) axis = select(retro, any_perpendicular(wo), axis);
    return {dot(n, wi),
            dot(n, wo),
            angle_of(across, along),
            along / sum_length,
            sqr(across / along),
            angle_of(length(difference), sum_length),
            real<R>(0.5) * sum_length,
            {-wi, axis},
            {wo, axis}};
}

/// P(θ) of a surface: facets per solid angle around the tilt θ, times B.
template <class T>
struct SlopeDistribution {
    T peak;   ///< Gaussian B/(2πσ²), Cauchy B
    T width;  ///< Gaussian −1/(2σ²), Cauchy σ²

    T operator()(Slopes slopes, const T& sec_theta, const T& tan2_theta) const {
        if (slopes == Slopes::kCauchy) return peak * sec_theta / (width + tan2_theta);
        return peak * decay(width * tan2_theta) * (sec_theta * sec_theta * sec_theta);
    }
};
template <class T>
SlopeDistribution<T> slope_distribution(Slopes slopes, const T& B, const T& sigma) {
    const T s2 = sigma * sigma, half = real<T>(0.5) / s2;
    if (slopes == Slopes::kCauchy) return {B, s2};
    return {B * half * real<T>(1 / kPi), -half};
}

/// SO(θ,β) of a surface; angles in rad.
template <class T>
struct ShadowingOf {
    T fall;       ///< −2/τ, rad⁻¹
    T inv_omega;  ///< rad⁻¹

    T operator()(const T& theta, const T& beta) const {
        const T x = theta * inv_omega, one = real<T>(1);
        return (one + x * decay(fall * beta)) * inverse(one + x);
    }
};
template <class T>
ShadowingOf<T> shadowing(const T& tau, const T& inv_omega) {
    return {real<T>(-2) / tau, inv_omega};
}

/// G of Torrance and Sparrow; keeps the energy of the facets ≤ 1.
template <class R>
R torrance_sparrow(const ReflectionOf<R>& r) {
    using std::min;
    const R c = real<R>(2) * r.cos_theta / r.cos_beta;
    return min(real<R>(1), min(c * r.cos_i, c * r.cos_o));
}

/// f_vol, never negative; `spread` is 2/(cosθi + cosθo).
template <class T>
T volume(const T& rho_d, const T& rho_v, const T& spread) {
    using std::max;
    return max(real<T>(0), rho_d + rho_v * spread);
}
template <class T>
T volume(const T& rho_d, const T& rho_v, const T& cos_i, const T& cos_o) {
    return volume(rho_d, rho_v, real<T>(2) / (cos_i + cos_o));
}

/// The Mueller BRDF in the facet's frame: a facet matrix plus fully depolarized volume light.
template <class T>
struct BrdfMueller {
    FacetMueller<T> facet;
    T volume;

    friend Stokes<T> operator*(const BrdfMueller& f, const Stokes<T>& S) {
        Stokes<T> out = f.facet * S;
        out.s0 = out.s0 + f.volume * S.s0;
        return out;
    }
};

/// What eval() needs of a reflection.
template <class T>
struct FacetGeometry {
    T theta, sec_theta, tan2_theta, beta, cos_beta;
    T spread;  ///< 2/(cosθi + cosθo)
    T weight;  ///< of the light
    T share;   ///< weight · G/(4 cosθi cosθo)
};
template <class T, class R, class Mask>  // Mask: bool, or one a lane
FacetGeometry<T> facet_geometry(const Mask& attenuated, const ReflectionOf<R>& r,
                                const R& weight = real<R>(1)) {
    using std::max;
    const R G = any(attenuated) ? select(attenuated, torrance_sparrow(r), real<R>(1)) : real<R>(1);
    // The floor keeps ∞·0 away where facets have long been 0.
    return {real<T>(r.theta),      real<T>(real<R>(1) / max(r.cos_theta, real<R>(1e-10))),
            real<T>(r.tan2_theta), real<T>(r.beta),
            real<T>(r.cos_beta),   real<T>(real<R>(2) / (r.cos_i + r.cos_o)),
            real<T>(weight),       real<T>(weight * G / (real<R>(4) * r.cos_i * r.cos_o))};
}

/// What eval() needs of a surface: its parameters, worked out as far as it goes without a geometry.
template <class T>
struct PreparedPriestGermer {
    Complex<T> contrast;
    SlopeDistribution<T> P;
    ShadowingOf<T> SO;
    T rho_d, rho_v;
};
template <class T>
PreparedPriestGermer<T> prepared(const PriestGermer<T>& p, Slopes slopes) {
    return {contrast(p.n, p.k), slope_distribution(slopes, p.B, p.sigma),
            shadowing(p.tau, p.inv_omega), p.rho_d, p.rho_v};
}

/// f in sr⁻¹, times the geometry's weight, for light that comes along r.in and leaves along r.out.
template <class T>
BrdfMueller<T> eval(const PreparedPriestGermer<T>& p, Slopes slopes, const FacetGeometry<T>& g) {
    const T facets = p.P(slopes, g.sec_theta, g.tan2_theta) * p.SO(g.theta, g.beta) * g.share;
    return {facets * fresnel(p.contrast, g.cos_beta),
            g.weight * volume(p.rho_d, p.rho_v, g.spread)};
}
template <class T, class R>
BrdfMueller<T> eval(const PriestGermer<T>& p, Slopes slopes, Attenuation attenuation,
                    const ReflectionOf<R>& r) {
    return eval(prepared(p, slopes), slopes,
                facet_geometry<T>(attenuation == Attenuation::kTorranceSparrow, r));
}

}  // namespace malus
