// sky_description.h — what a sky map shows, in the terms of people who measure skies, and whether
// its polarization stands to the sun as that of scattered light does.
//
//   irradiance     E = ∫ S0 cosθ dω over the dome, exact for the map's bilinear cells
//   neutral point  where the sun's vertical is unpolarized (neutral_points.h)
//   asymmetry      about the sun's vertical, where S0 and S1 should be even and S2 odd:
//                  of brightness ∫ |S0 − S0'| dω / ∫ (S0 + S0') dω, S' the mirrored map;
//                  of polarization the same with the vectors (S1, S2) and their lengths
//   deviation      of AoLP from the perpendicular of the plane through sun and view, as light
//                  scattered once has it; the median over the dome, weighed with S0 DoLP dω
//
// Frame   maps and their meridian frame as sky.h. In the sun's vertical the axis is in the plane,
//         which at the zenith goes over from one meridian to the opposite one; S1 > 0: along the plane.
// Units   angles in rad, W m⁻² sr⁻¹ nm⁻¹, W m⁻² nm⁻¹, nm.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "malus/scene/sky.h"

namespace malus {

/// A direction of the sky.
struct SkyPlace {
    double zenith = 0, azimuth = 0;
};

/// How a map stands to its sun.
struct SkyOrientation {
    double brightness_asymmetry = 0, polarization_asymmetry = 0;  ///< [0, 1]
    std::optional<double> deviation;  ///< [0, π/2]; nothing for a sky without polarization
};

/// One wavelength of a map.
struct SkyAtWavelength {
    double wavelength_nm = 0;
    double least_s0 = 0, most_s0 = 0;
    SkyPlace brightest;
    double largest_dolp = 0;
    SkyPlace most_polarized;
    std::size_t dark_nodes = 0;               ///< S0 = 0
    std::size_t almost_wholly_polarized = 0;  ///< nodes of DoLP > 0.98, which no sky has
    double sky_irradiance = 0;                ///< of the dome on level ground
    std::optional<double> sun_irradiance;     ///< of the sun's beam on level ground, where known

    // Where the sun is known:
    std::optional<double> most_polarized_from_sun;
    std::optional<double>
        dolp_at_right_angle;  ///< 90° from the sun in its vertical, across the zenith
    std::optional<double> babinet, brewster;  ///< angle from the sun, where above the horizon
    std::optional<double> arago;              ///< angle from the antisun, where above the horizon
    std::optional<SkyOrientation> orientation;
};

struct SkyDescription {
    std::vector<SkyAtWavelength> light;  ///< one a wavelength, ascending
    std::vector<std::string> missing;    ///< what the map does not say, one line each
    std::vector<std::string> doubts;     ///< what cannot be right in a sky, one line each
};

/// Describes the map as it is, with the sun it declares.
SkyDescription describe_sky(const Sky& sky);

}  // namespace malus
