// validators.h — checks of option values that CLI11 lets through.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>

#include "malus/optics/wavelengths.h"

namespace malus::cli {

/// A finite number from least to most; CLI::Range takes NaN for one.
inline CLI::Validator within(double least, double most) {
    const std::string range = to_text(least) + " to " + to_text(most);
    return CLI::Validator(
        [=](std::string& text) {
            double x = NAN;
            if (!CLI::detail::lexical_cast(text, x)) return text + " is not a number";
            return x >= least && x <= most ? std::string() : text + " is not within " + range;
        },
        range);
}

}  // namespace malus::cli
