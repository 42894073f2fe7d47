// image_options.h — options that the commands on images share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/io/film_image.h"

namespace CLI {
class App;
}

namespace malus::cli {

/// --wavelengths, nm, positive, with commas between them.
void add_wavelengths(CLI::App& sub, std::vector<double>& wavelengths_nm, const std::string& help);

/// For debias() (quantity.h), of --debias. Throws Error (without a file name).
Film film_for_debias(const Image& image);

}  // namespace malus::cli
