// image_options.cpp — options that the commands on images share.
// SPDX-License-Identifier: Apache-2.0
#include "cli/image_options.h"

#include <CLI/CLI.hpp>

#include "malus/core/error.h"

namespace malus::cli {

void add_wavelengths(CLI::App& sub, std::vector<double>& wavelengths_nm, const std::string& help) {
    sub.add_option("--wavelengths", wavelengths_nm, help)
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::PositiveNumber);
}

Film film_for_debias(const Image& image) {
    try {
        Labels labels;
        return film_of(image, labels);
    } catch (const Error& problem) {
        throw Error(std::string("--debias: ") + problem.what() +
                    "; leave it out, or name an image that malus rendered");
    }
}

}  // namespace malus::cli
