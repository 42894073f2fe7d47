// radiative_transfer.h — polarized light below a plane-parallel layer of air, all orders of scattering.
//
//   μ dS/dτ = S − (ϖ/4π) ∫ Z(w,w') S(w') dw' − (ϖ/4π) Z(w,w0) E0 e^{−τ/μ0},   ϖ = 1
//   Z = L(out) F(Θ) L(in): Rayleigh's matrix F between the meridian frames of both beams
//   S(μ,a) = Σ_m (I_m cos ma, Q_m cos ma, U_m sin ma), a = azimuth from the sun; m = 0, 1, 2 are exact
//
// Frame   the meridian frame of sky maps (sky.h); μ = cosine of the zenith angle.
// Method  adding-doubling (van de Hulst 1980; de Haan, Bosma & Hovenier, A&A 183, 371 (1987)) from a
//         layer so thin that it scatters once; Gauss-Legendre nodes in μ, and rows without weight for
//         the directions asked for; Lambertian ground in closed form.
// Range   unpolarized sun, 0 < μ0 ≤ 1; curvature is left out: sun and view within about 82° of the
//         zenith.
// Error   4e-8 of E0/π against Natraj, Li & Yung (2009), τ ≤ 0.25.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "malus/optics/stokes.h"

namespace malus {

/// Air over ground.
struct RayleighLayer {
    double optical_depth;
    double depolarization;  ///< ρ of natural light scattered by 90°; 0 for isotropic molecules
    double ground_albedo;   ///< [0, 1]
};

/// Azimuth modes of the diffuse light from one zenith angle, per unit of the sun's irradiance (on a
/// plane facing it, above the air), sr⁻¹.
struct SkyModes {
    static constexpr int kCount = 3;
    std::array<double, kCount> I{}, Q{}, U{};

    /// In the meridian frame; `azimuth` from the sun's, rad, clockwise from above.
    Stokes<double> at(double azimuth) const;
};

/// The light that comes down to the ground, at each of `mu` (in (0, 1]).
std::vector<SkyModes> light_at_ground(const RayleighLayer& air, double mu0,
                                      std::span<const double> mu);

}  // namespace malus
