// wavelengths.cpp — finding a wavelength and writing numbers.
// SPDX-License-Identifier: Apache-2.0
#include "malus/optics/wavelengths.h"

#include <array>
#include <charconv>
#include <cmath>

namespace malus {

std::optional<std::size_t> find_wavelength(std::span<const double> list_nm, double nm) {
    for (std::size_t i = 0; i < list_nm.size(); ++i)
        if (std::abs(list_nm[i] - nm) < kSameWavelength_nm) return i;
    return std::nullopt;
}

std::string to_text(double x) {
    std::array<char, 32> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
    return {text.data(), end};
}

std::string to_text(std::span<const double> list) {
    std::string text;
    for (double x : list) text += (text.empty() ? "" : ", ") + to_text(x);
    return text;
}

}  // namespace malus
