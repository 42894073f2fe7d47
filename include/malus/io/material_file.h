// material_file.h — reads paints from FILE.json (see materials/README.md for the form).
//
// Units in the file: nm, sr⁻¹; τ and Ω in the unit that stands beside them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "malus/scene/material.h"

namespace malus {

struct MaterialFile {
    std::vector<Material> materials;
    std::vector<std::string> warnings;  ///< e.g. a row whose volume term is clamped
};

/// Throws Error naming file, material, row and key for anything that is unknown, missing, of the
/// wrong type or out of range.
MaterialFile read_materials(const std::filesystem::path& path);

}  // namespace malus
