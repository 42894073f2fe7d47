// reference.h — the deterministic answer that renders are judged against.
//
//   f   = P(θ) SO(θ,β) G M(β) / (4 cosθi cosθo) + f_vol E00        Priest-Germer
//   L_o = ∫ f L_i cosθi dωi                                         adaptive cubature, no sampling
//
// It shares no code with the renderer but Vec3, and is built another way on purpose: complex
// Fresnel, full 4×4 rotations, double throughout, and integrals over convex regions of the sphere.
//
// Frames  A beam along k has a reference axis x ⟂ k and y = k × x. S1 = I(x) − I(y),
//         S2 = I(+45°) − I(−45°) from x toward y, S3 = right − left, index n + ik.
//         Sky directions w carry the beam k = −w with the meridian axis, toward the zenith.
// Units   Radians, sr⁻¹; world right-handed with +Y up, north = −Z, east = +X.
// Errors  The caller's are not caught: unit vectors, axes ⟂ beams and non-zero rectangles are
//         expected. An integral that ran out of cells says so by its own error estimate.
// Source  Priest & Germer, Proc. MSS 2000; Torrance & Sparrow, JOSA 57, 1105 (1967); Born & Wolf,
//         7th ed., §1.5, §14.2; quadrature rule of QUADPACK's QK15 (public domain).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <complex>
#include <functional>
#include <optional>

#include "malus/core/vec.h"

namespace malus::reference {

using Stokes = std::array<double, 4>;
using Mueller = std::array<std::array<double, 4>, 4>;

enum class Slopes { gaussian, cauchy };

/// SO = (1 + (θ/Ω) e^{−2β/τ}) / (1 + θ/Ω); both in radians.
struct Shadowing {
    double tau{1};
    double omega{1};
};

/// One paint at one wavelength. rho_d and rho_v are in sr⁻¹; f_vol is clamped at ≥ 0.
struct Paint {
    double n{1.5}, k{0};
    double B{0};
    double sigma{0.3};  // RMS slope, not its square
    Slopes slopes{Slopes::gaussian};
    std::optional<Shadowing> shadowing{};
    bool torrance_sparrow{false};
    double rho_d{0}, rho_v{0};
};

/// What reaches the observer from direction w of the sky, in the meridian frame.
using SkyFunction = std::function<Stokes(Vec3 w)>;

/// error: an estimate of |value − exact| per component, meant to err on the large side.
struct Integral {
    Stokes value{};
    Stokes error{};
};

/// A parallelogram that reflects on the side of `normal` (unit) and only blocks on the other.
struct Rectangle {
    Vec3 corner, edge_u, edge_v, normal;
    Paint paint{};
};

// Stokes vectors and matrices.
Stokes multiply(const Mueller& m, const Stokes& s);
Mueller product(const Mueller& a, const Mueller& b);

/// Restates a Stokes vector when its axis turns from x_from to x_to about the beam k.
Mueller rotation(Vec3 k, Vec3 x_from, Vec3 x_to);

/// The axis of the sky's beam k = −w: unit(up − (up·w)w). At the zenith the limit from the north.
Vec3 meridian_axis(Vec3 w);

// The reflection model.
struct FresnelAmplitudes {
    std::complex<double> rs, rp;
};
FresnelAmplitudes fresnel(std::complex<double> index, double cos_beta);

/// M(β) with x = unit(k_in × k_out) on both beams.
Mueller facet(const Paint& paint, double cos_beta);

/// P(θ), the density of facet normals per steradian; its integral is B for Gaussian slopes.
double facet_density(const Paint& paint, double cos_theta);

/// Mueller BRDF in sr⁻¹ from the axis x_in of the beam −wi to the axis x_out of the beam wo.
/// Zero where cosθi ≤ 0 or cosθo ≤ 0.
Mueller brdf(const Paint& paint, Vec3 n, Vec3 wi, Vec3 wo, Vec3 x_in, Vec3 x_out);

// Skies; dark below the horizon.
SkyFunction uniform_sky(double radiance);

/// A smooth sky in the manner of Rayleigh, Θ from the sun (a unit vector):
///   S0 = ¾ radiance (1 + cos²Θ),   DoLP = max_dolp sin²Θ/(1 + cos²Θ) ⟂ to the scattering plane,
///   S3 = docp cosΘ S0, which no real sky has: it lets circular light into the test.
/// DoP ≤ 1 for max_dolp, |docp| ≤ 1.
SkyFunction rayleigh_sky(Vec3 sun_direction, double radiance, double max_dolp, double docp = 0);

// Integrals. The tolerance is relative to S0 of the result and holds for each component.

/// Radiance that a free panel of normal n sends toward wo, on the axis x_out. Only the part of
/// its hemisphere above the horizon sees the sky.
Integral panel(const Paint& paint, Vec3 n, Vec3 wo, Vec3 x_out, const SkyFunction& sky,
               double relative_tolerance);

/// Sky → a → sensor, seen at the point p of a along wo, where b hides part of the sky.
Integral corner_first_bounce(const Rectangle& a, const Rectangle& b, Vec3 p, Vec3 wo, Vec3 x_out,
                             const SkyFunction& sky, double relative_tolerance);

/// Sky → b → a → sensor: exactly two reflections; a hides part of the sky of b.
Integral corner_second_bounce(const Rectangle& a, const Rectangle& b, Vec3 p, Vec3 wo, Vec3 x_out,
                              const SkyFunction& sky, double relative_tolerance);

}  // namespace malus::reference
