// sky.cpp — malus sky make: an analytic sky map.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <iostream>
#include <optional>

#include "cli/commands.h"
#include "cli/validators.h"
#include "malus/core/error.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/sky_file.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

// Beyond, the curvature of the Earth changes the light by more than some per cent.
constexpr double kFlatEarth_deg = 82;

struct SkyOptions {
    std::string output;
    std::vector<double> wavelengths_nm{440, 550, 600};
    double sun_zenith_deg = 60, sun_azimuth_deg = 180;
    double ground_albedo = 0.2, pressure_hpa = 1013.25;
    std::optional<double> max_dolp;
    int width = 360, height = 90;
};

std::string description(const SkyOptions& options) {
    std::string text = "Rayleigh atmosphere, all orders of scattering, ground albedo " +
                       to_text(options.ground_albedo) + ", " + to_text(options.pressure_hpa) +
                       " hPa";
    if (options.max_dolp) text += ", polarization scaled to DoLP " + to_text(*options.max_dolp);
    return text;
}

void make(const SkyOptions& options, const std::string& command_line) {
    check_exr_name(options.output);
    check_writable(options.output);
    const std::vector<double> wavelengths = sorted_wavelengths(options.wavelengths_nm);
    const ClearSky model{to_radians(options.sun_zenith_deg), to_radians(options.sun_azimuth_deg),
                         options.ground_albedo, options.pressure_hpa, options.max_dolp};
    if (options.sun_zenith_deg > kFlatEarth_deg)
        std::cerr
            << "malus: note: the sun stands " << to_text(options.sun_zenith_deg)
            << " degrees from the zenith; the atmosphere is computed flat, which holds to about "
            << to_text(kFlatEarth_deg) << "\n";
    const Sky sky = make_clear_sky(model, wavelengths, options.height, options.width);
    write_sky(options.output, sky,
              {{"skyModel", description(options)},
               {"malusVersion", version()},
               {"commandLine", command_line}});
}

}  // namespace

void add_sky(CLI::App& app, const std::string& command_line) {
    CLI::App* sky = app.add_subcommand("sky", "Make sky maps");
    sky->require_subcommand(1);
    CLI::App* sub = sky->add_subcommand("make",
                                        "Make a clear sky: sunlight scattered by air (Rayleigh), "
                                        "all orders, over even ground, in a "
                                        "flat atmosphere (sun and view within about 82 degrees of "
                                        "the zenith). No aerosol; the sun's "
                                        "disc itself is not part of it.");
    const auto options = std::make_shared<SkyOptions>();
    sub->add_option("-o,--output", options->output, "Sky map to write, EXR")->required();
    sub->add_option("--wavelengths", options->wavelengths_nm, "Wavelengths, nm, e.g. 440,600")
        ->delimiter(',')
        ->check(within(200.0, 4000.0))
        ->capture_default_str();
    sub->add_option("--sun-zenith", options->sun_zenith_deg, "Zenith angle of the sun, degrees")
        ->check(within(0.0, 89.0))
        ->capture_default_str();
    sub->add_option("--sun-azimuth", options->sun_azimuth_deg,
                    "Azimuth of the sun, degrees clockwise from north (-Z); east (+X) is 90")
        ->check(within(-360.0, 360.0))
        ->capture_default_str();
    sub->add_option("--ground-albedo", options->ground_albedo,
                    "Share of light that the ground reflects, evenly and unpolarized, 0 to 1")
        ->check(within(0.0, 1.0))
        ->capture_default_str();
    sub->add_option("--pressure", options->pressure_hpa, "Air pressure at the ground, hPa")
        ->check(within(1.0, 1100.0))
        ->capture_default_str();
    sub->add_option(
           "--max-dolp", options->max_dolp,
           "Scale the polarization so that the map's largest degree of linear polarization "
           "is this, 0 to 1, as in hazier air; without, as the air has it")
        ->check(within(0.0, 1.0));
    sub->add_option("--width", options->width, "Columns: azimuth 0 to 360 degrees")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    sub->add_option("--height", options->height, "Rows: zenith angle 0 to 90 degrees")
        ->check(CLI::Range(1, 16384))
        ->capture_default_str();
    sub->callback([options, command_line] { make(*options, command_line); });
}

}  // namespace malus::cli
