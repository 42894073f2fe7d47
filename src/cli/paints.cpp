// paints.cpp — reading paints, and notes on them.
// SPDX-License-Identifier: Apache-2.0
#include "cli/paints.h"

#include <algorithm>
#include <cmath>

#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {

MaterialFile read_paints(const std::vector<std::string>& paths) {
    MaterialFile all;
    for (const std::string& path : paths) {
        MaterialFile file = read_materials(path);
        all.warnings.insert(all.warnings.end(), file.warnings.begin(), file.warnings.end());
        for (Material& material : file.materials) {
            for (const Material& other : all.materials)
                if (other.name == material.name)
                    throw Error(material.place + ": a material of this name stands in " +
                                other.place + " too; rename one");
            all.materials.push_back(std::move(material));
        }
    }
    return all;
}

std::string interpolation_note(const Material& material, std::span<const double> wavelengths_nm) {
    std::vector<double> between;
    for (double nm : wavelengths_nm)
        if (material.covers(nm) &&
            std::none_of(material.rows.begin(), material.rows.end(), [&](const MaterialRow& row) {
                return std::abs(row.wavelength_nm - nm) < kSameWavelength_nm;
            }))
            between.push_back(nm);
    if (between.empty()) return {};
    return material.place + ": parameters at " + to_text(between) +
           " nm are interpolated linearly between rows";
}

}  // namespace malus::cli
