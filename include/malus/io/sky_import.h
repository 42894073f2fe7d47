// sky_import.h — sky maps of other codes: tables and pictures in their conventions, brought into ours.
//
// CSV   a line of names, then a full grid in any order; '#' starts a comment. Columns may stand in any
//       order; capitals, blanks and a unit (_deg, [deg], (deg), nm alike) do not matter:
//         wavelength, lambda · zenith, theta, vza · azimuth, phi, vaa · S0, I · S1, Q · S2, U · S3, V
//       Others are left out. Without S3 light is not circular. Zenith angles are 0 to 180°, azimuths
//       any turn; degrees.
// EXR   as sky_file.h has it, with the angles of its rows and columns in the other code's conventions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>

#include "malus/scene/sky_conventions.h"

namespace malus {

enum class HalfDome { kAsItIs, kMirrored };  ///< what azimuths 0 to 180° stand for

/// A number for each wavelength, nm; one for all under 0.
using BySpectrum = std::map<double, double>;

struct SkyImport {
    SkyConventions conventions;
    HalfDome half_dome = HalfDome::kAsItIs;
    BySpectrum scale;  ///< brings the file's unit to W m⁻² sr⁻¹ nm⁻¹; empty: 1
    std::optional<double> wavelength_nm;  ///< of a table that has no column for it
    /// Zenith angles at the upper and the lower edge of a picture, rad; without, the dome's, from
    /// overhead to the horizon.
    std::optional<std::array<double, 2>> zenith_span;
    std::optional<Sun> sun;     ///< its place, instead of the file's
    BySpectrum sun_irradiance;  ///< W m⁻² nm⁻¹ facing the sun, instead of the file's
    int width = 0, height = 0;  ///< of the map; 0: grid_like() the file
};

/// Nodes at pixel centres, ready for write_sky(); what is to be said of the map is in its warnings.
/// Throws Error as read_sky() does, and for a map wholly below the horizon.
Sky import_sky(const std::filesystem::path& path, const SkyImport& options);

}  // namespace malus
