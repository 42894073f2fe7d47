// paints.h — paints from the files that an option names, for all commands alike.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "malus/io/material_file.h"

namespace malus::cli {

/// The paints of all files in one list, and what is to be said of them. Throws Error also when a name
/// stands in two files.
MaterialFile read_paints(const std::vector<std::string>& paths);

/// Which of these wavelengths lie between rows of the paint, in words; empty if none does. Those that
/// its rows do not reach are left out.
std::string interpolation_note(const Material& material, std::span<const double> wavelengths_nm);

}  // namespace malus::cli
