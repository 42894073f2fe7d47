// sky_monte_carlo.h — the light of the sky by random walks, which the solver is judged against.
//
//   S_j = E Σ W_j(F(Θ) · natural light) ϖ/(4π) e^{−(τ−t)/μ0}   over the scatterings of a walk
//       + E Σ W_j(natural light) (A/π) μ0 e^{−τ/μ0}              over its visits to the ground
//
// A walk starts at the observer and goes against the light, with three analyzers before the eye that
// read I, Q and U. At each scattering, t of the depth τ above the ground, it adds what the sun sends
// straight into it, then turns at an angle drawn from F11; W is what the analyzers have become. What
// absorbs ends the walk with the chance of that; the first step always ends in the air.
// It shares no code with the solver but Vec3, and is built another way on purpose: no quadrature, no
// expansion, no turns of Stokes vectors, but fields along two axes and what analyzers read of them.
//
// Frame   +z up, the sun over +x; azimuths from the sun's, clockwise seen from above. Light from w goes
//         along k = −w; x ⟂ k toward the zenith (of the azimuth asked for, at the zenith itself),
//         y = k × x: Q = I(x) − I(y), U = I(45° from x toward y) − I(−45°).
// Units   rad, sr⁻¹; light per unit of the sun's irradiance on a plane that faces it above the air.
// Left    circular polarization, as in the solver.
// Source  Hansen & Travis, Space Sci. Rev. 16, 527 (1974), eq. 2.14-2.16; Henyey & Greenstein,
//         ApJ 93, 70 (1941); walks against the light: Marchuk et al., The Monte Carlo Methods in
//         Atmospheric Optics (1980).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <variant>
#include <vector>

namespace malus::sky_monte_carlo {

/// I, Q, U.
using Stokes = std::array<double, 3>;

struct Molecules {
    double depolarization;  ///< of natural light scattered by 90°
};
struct HenyeyGreenstein {
    double asymmetry;     ///< not 0
    double polarization;  ///< times that of molecules
};

/// One kind of particle in a layer.
struct Particles {
    double optical_depth;  ///< of the layer, by this kind, vertical
    double albedo;         ///< of one scattering
    std::variant<Molecules, HenyeyGreenstein> kind;
};

/// Layers from above, evenly mixed, each scatters; Lambertian ground that depolarizes.
struct Air {
    std::vector<std::vector<Particles>> layers;
    double ground_albedo;
};

/// Means over all walks, and one standard error of each mean.
struct Estimate {
    Stokes mean, error;
};

/// The light that comes to the ground from (zenith, azimuth); both zenith angles below π/2. The same
/// seed gives the same walks.
Estimate random_walks(const Air& air, double sun_zenith, double zenith, double azimuth, int walks,
                      unsigned seed);

}  // namespace malus::sky_monte_carlo
