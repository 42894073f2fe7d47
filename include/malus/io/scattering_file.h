// scattering_file.h — scattering matrices of particles as CSV.
//
// Header angle_deg,F11,F12,F22,F33, if the matrix changes with wavelength wavelength_nm before it,
// and F34,F44 behind it where a file has them (not used); lines that start with '#' are comments.
// Angles ascend from 0 to 180 degrees, once for each wavelength. F11 > 0 in any unit (it is brought
// to ½ ∫ F11 dcosΘ = 1), the others in that of F11; |F12|, |F22|, |F33| ≤ F11.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "malus/scene/clear_sky.h"

namespace malus {

/// Throws Error naming file, line, what is wrong and what to do.
ScatteringTable read_scattering(const std::filesystem::path& path);

}  // namespace malus
