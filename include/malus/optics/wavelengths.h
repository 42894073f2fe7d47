// wavelengths.h — lists of wavelengths and how one is found in them.
//
// Units   nm. Two wavelengths are the same within 1e-3 nm, far below any instrument's knowledge.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace malus {

inline constexpr double kSameWavelength_nm = 1e-3;

/// Index of `nm` in the list, if it is there.
std::optional<std::size_t> find_wavelength(std::span<const double> list_nm, double nm);

/// A number as short as it can be read back: "440", "550.5". Independent of the locale.
std::string to_text(double x);

/// "440, 550, 600".
std::string to_text(std::span<const double> list);

}  // namespace malus
