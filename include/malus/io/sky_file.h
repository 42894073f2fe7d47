// sky_file.h — sky maps as spectral EXR or CSV.
//
// EXR   width = azimuth 0→360° clockwise from north, height = zenith 0→90° (top row: zenith),
//       samples at pixel centres; channels and attributes as spectral_image.h, frame "meridian".
// CSV   header wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3; a full grid in any order; lines
//       that start with '#' are comments. The grid's own angles are the nodes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "malus/scene/sky.h"

namespace malus {

/// Is the file a table, by its ending .csv, in capitals too?
bool is_csv(const std::filesystem::path& path);

/// From a table if is_csv(), else an EXR. Throws Error for S0 < 0, |S| > S0, a gap in the grid, a
/// number that is not finite, naming row or pixel.
Sky read_sky(const std::filesystem::path& path);

/// Writes the EXR form; the map's nodes must stand at pixel centres. `attributes` go into the
/// header besides what the form asks for.
void write_sky(const std::filesystem::path& path, const Sky& sky,
               const std::map<std::string, std::string>& attributes);

}  // namespace malus
