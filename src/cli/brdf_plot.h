// brdf_plot.h — polar plots of what a paint reflects.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "malus/analysis/brdf_table.h"

namespace malus::cli {

/// One row a wavelength: S0 (logarithmic), DoLP, facet distribution, shadowing. Azimuth goes round,
/// clockwise from the top as seen from above; zenith angle is the distance from the middle.
void plot_brdf(const std::filesystem::path& path, const std::string& title,
               std::span<const BrdfTable> tables);

}  // namespace malus::cli
