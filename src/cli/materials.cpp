// materials.cpp — malus materials check: what is unphysical about paints, row by row.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>

#include "cli/commands.h"
#include "malus/io/material_file.h"
#include "malus/optics/wavelengths.h"
#include "malus/scene/material_check.h"

namespace malus::cli {
namespace {

void print_row(const Material& material, const RowCheck& check) {
    std::printf("  %s nm\n    reflectance", to_text(check.wavelength_nm).c_str());
    for (const Reflectance& r : check.reflectance)
        std::printf("  %.0f\u00b0 %.3g", r.zenith_deg, r.value);
    std::printf("\n");
    for (const std::string& words : verdicts(material, check))
        std::printf("    %s\n", words.c_str());
}

void check_files(const std::vector<std::string>& paths) {
    for (const std::string& path : paths)
        for (const Material& material : read_materials(path).materials) {
            std::printf("%s: rows from %s to %s nm; other wavelengths are refused\n",
                        material.place.c_str(),
                        to_text(material.rows.front().wavelength_nm).c_str(),
                        to_text(material.rows.back().wavelength_nm).c_str());
            for (const MaterialRow& row : material.rows)
                print_row(material, check_row(material, row));
        }
}

}  // namespace

void add_materials(CLI::App& app) {
    CLI::App* materials = app.add_subcommand("materials", "Look at paints");
    materials->require_subcommand(1);
    CLI::App* sub = materials->add_subcommand(
        "check",
        "Say what is unphysical about paints: per row the directional-hemispherical reflectance at "
        "angles of incidence in degrees, negative f00, too much polarization, broken reciprocity");
    const auto paths = std::make_shared<std::vector<std::string>>();
    sub->add_option("files", *paths, "Paints: one or more .json files")->required();
    sub->callback([paths] { check_files(*paths); });
}

}  // namespace malus::cli
