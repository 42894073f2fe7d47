// sky_grid.h — from the rows of a table to the full grid of a sky map, checked.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "malus/core/error.h"
#include "malus/scene/sky.h"

namespace malus {

/// One node of a map as a line of a table gives it.
struct SkyRow {
    double wavelength_nm, zenith_deg, azimuth_deg;
    Stokes<double> S;
    int line;
};

/// Beyond this floats would overflow on the way to a picture, W m⁻² sr⁻¹ nm⁻¹. (The sun has 3e4.)
inline constexpr double kBrightest = 1e20;
/// The same for the irradiance of the sun, W m⁻² nm⁻¹, whose disc is 7e-5 sr.
inline constexpr double kMostIrradiance = 1e15;

/// What keeps S from being light, e.g. "S0 = -1 is negative; mend the map"; empty when nothing does:
/// finite, 0 ≤ S0 ≤ 1e20, |S| ≤ S0 but for the rounding of 32-bit floats.
std::string fault_of(const Stokes<double>& S);

/// S, brought back onto |S| = S0 where rounding made it longer. Throws Error for what is no light;
/// place() says where, and is called for a message only.
template <class Place>
Stokes<double> checked_light(const Stokes<double>& S, Place place) {
    if (const std::string fault = fault_of(S); !fault.empty()) throw Error(place() + ": " + fault);
    const double P = std::hypot(S.s1, S.s2, S.s3);
    const double shrink = P > S.s0 ? S.s0 / P : 1;
    return {S.s0, S.s1 * shrink, S.s2 * shrink, S.s3 * shrink};
}

/// The map whose nodes are these rows, in any order. Azimuths may start anywhere; where a file gives
/// one direction twice, 360° apart, the row of the larger azimuth is left out. Throws Error for a node that
/// stands twice, a gap in the grid, azimuths of more than a turn, or no rows.
Sky sky_from_rows(std::vector<SkyRow> rows, const std::string& file);

/// What the map leaves out of the dome, one line each.
std::vector<std::string> gaps_in(const Sky& sky, const std::string& file);

}  // namespace malus
