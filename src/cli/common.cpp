// common.cpp — what the commands share.
// SPDX-License-Identifier: Apache-2.0
#include "cli/commands.h"

#include <algorithm>

#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {

std::vector<double> sorted_wavelengths(std::vector<double> wavelengths_nm) {
    std::sort(wavelengths_nm.begin(), wavelengths_nm.end());
    for (std::size_t w = 1; w < wavelengths_nm.size(); ++w)
        if (wavelengths_nm[w] - wavelengths_nm[w - 1] < kSameWavelength_nm)
            throw Error("--wavelengths: " + to_text(wavelengths_nm[w]) +
                        " nm stands twice; keep one");
    return wavelengths_nm;
}

std::string version() {
    return MALUS_VERSION;
}

std::string command_line(int argc, char** argv) {
    std::string line;
    for (int i = 0; i < argc; ++i) {
        std::string word = argv[i];
        const bool plain = !word.empty() &&
                           word.find_first_of(" \t\n\"'\\$&|;<>*?()[]{}#~`!") == std::string::npos;
        if (!plain) {
            for (std::size_t at = 0; (at = word.find('\'', at)) != std::string::npos; at += 4)
                word.replace(at, 1, "'\\''");
            word = "'" + word + "'";
        }
        line += (i ? " " : "") + word;
    }
    return line;
}

}  // namespace malus::cli
