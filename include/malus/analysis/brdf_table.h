// brdf_table.h — what a paint makes of light from one direction, over all directions it is seen from.
//
//   S_o = T_out f T_in S_i         f: eval() of priest_germer.h, sr⁻¹; T: turns between frames
//   R   = ∫ S0_o cosθo dωo / S0_i  the share that is reflected
//
// Frame   meridian on both beams: x = unit(n − (n·w)w) for light that comes from w (k = −w) as for
//         what leaves toward w (k = w), n the normal. S1 > 0: along the plane of normal and beam. At
//         w = n the limit for the azimuth that is named. The facet's own frame is fresnel.h's,
//         x = unit(k_in × k_out) on both beams.
// Units   radians from the normal and clockwise seen from above it, as frame.h counts them. A paint has
//         no grain: only differences of azimuth matter; 0: back to the light, π: specular side. S_i is
//         irradiance of the surface, so S_o is radiance per unit of it, sr⁻¹: f00 for unpolarized light.
// Range   f = 0 at the horizon (θo = π/2), where the model has no finite value.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "malus/io/exr.h"
#include "malus/optics/priest_germer.h"

namespace malus {

/// A paint at one wavelength.
struct PaintModel {
    double wavelength_nm;
    PriestGermer<double> p;
    Slopes slopes = Slopes::kGaussian;
    Attenuation attenuation = Attenuation::kNone;
};

/// A direction over a surface, rad; zenith is the angle from its normal.
struct SurfaceDirection {
    double zenith, azimuth;
};

/// The meridian frame of the light that comes from there, and of what leaves to there.
BeamFrame meridian_in(const SurfaceDirection& from);
BeamFrame meridian_out(const SurfaceDirection& to);

/// f in one geometry, with its factors.
struct BrdfValue {
    double facet_distribution;  ///< P(θ), sr⁻¹
    double shadowing;           ///< SO(θ,β)
    double attenuation;         ///< G; 1 for a paint without
    double theta, beta;         ///< tilt of the facet, incidence on it, rad
    BrdfMueller<double> f;      ///< in the facet's frame, sr⁻¹
    Turn into, out_of;          ///< from the meridian to the facet's frame, and back on the way out

    double f00() const { return f.facet.a() + f.volume; }
};
/// Light from a zenith angle below π/2, seen from one of at most π/2.
BrdfValue brdf_at(const PaintModel& paint, const SurfaceDirection& light,
                  const SurfaceDirection& view);

/// What leaves, of light S_i; both in meridian frames.
Stokes<double> reflected(const BrdfValue& value, const Stokes<double>& incident);

/// [out][in], sr⁻¹.
using MuellerMatrix = std::array<std::array<double, 4>, 4>;
MuellerMatrix meridian_mueller(const BrdfValue& value);
MuellerMatrix facet_mueller(const BrdfValue& value);

/// One direction of a table.
struct BrdfNode {
    double facet_distribution, shadowing, attenuation, f00;  ///< as in BrdfValue
    Stokes<double> out;                                      ///< sr⁻¹, meridian frame
};

/// Directions at equal steps of angle: zenith i Δ from 0 to π/2, azimuth j Δ from 0 to below 2π; the
/// nodes are these directions themselves, not the middles of cells.
struct BrdfTable {
    PaintModel paint;
    SurfaceDirection light;
    Stokes<double> incident;
    int steps;                    ///< from the normal to the horizon; Δ = π/(2 steps)
    std::vector<BrdfNode> nodes;  ///< [zenith][azimuth]

    int zeniths() const { return steps + 1; }
    int azimuths() const { return 4 * steps; }
    const BrdfNode& at(int zenith, int azimuth) const {
        return nodes[static_cast<std::size_t>(zenith) * static_cast<std::size_t>(azimuths()) +
                     static_cast<std::size_t>(azimuth)];
    }
    double degrees(int i) const { return i * 90.0 / steps; }  ///< of node i along either
};
BrdfTable tabulate(const PaintModel& paint, const SurfaceDirection& light,
                   const Stokes<double>& incident, int steps);

/// R by the sum over nodes, each for the part of the hemisphere next to it, ∫ cosθ dω in closed form:
/// exact for light that is the same in all directions. The last ring stands for the horizon, too.
double reflectance(const BrdfTable& table);

/// A row for each wavelength and direction under one line of names: wavelength_nm, view_zenith_deg,
/// view_azimuth_deg, facet_distribution_per_sr, shadowing, attenuation, f00_per_sr, S0_per_sr …
/// S3_per_sr, DoLP, AoLP_deg.
std::string brdf_csv(std::span<const BrdfTable> tables);

/// The same as channels P, SO, G, F00, S0 … S3, DoLP, AoLP of each wavelength. Columns are azimuths
/// from 0, rows zenith angles from 0; the header says light, step and frame. All tables must have the
/// same steps (a contract).
Image brdf_image(std::span<const BrdfTable> tables);

}  // namespace malus
