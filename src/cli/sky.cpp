// sky.cpp — malus sky make: an analytic sky map.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <iostream>

#include "cli/commands.h"
#include "cli/validators.h"
#include "malus/core/error.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/sky_file.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

struct SkyOptions {
    std::string output;
    std::vector<double> wavelengths_nm{440, 550, 600};
    double sun_zenith_deg = 60, sun_azimuth_deg = 180, max_dolp = 0.8;
    int width = 360, height = 90;
};

void make(const SkyOptions& options, const std::string& command_line) {
    check_exr_name(options.output);
    check_writable(options.output);
    const std::vector<double> wavelengths = sorted_wavelengths(options.wavelengths_nm);
    const RayleighSky model{to_radians(options.sun_zenith_deg), to_radians(options.sun_azimuth_deg),
                            options.max_dolp};
    const Sky sky = make_rayleigh_sky(model, wavelengths, options.height, options.width);
    write_sky(options.output, sky,
              {{"skyModel",
                "single-scattering Rayleigh atmosphere, maximum DoLP " + to_text(options.max_dolp)},
               {"malusVersion", version()},
               {"commandLine", command_line}});
}

}  // namespace

void add_sky(CLI::App& app, const std::string& command_line) {
    CLI::App* sky = app.add_subcommand("sky", "Make sky maps");
    sky->require_subcommand(1);
    CLI::App* sub = sky->add_subcommand(
        "make",
        "Make a clear sky: sunlight scattered once by air (Rayleigh), its polarization scaled to a "
        "stated maximum. The sun's disc itself is not part of it.");
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
    sub->add_option("--max-dolp", options->max_dolp,
                    "Degree of linear polarization 90 degrees from the sun, 0 to 1")
        ->check(within(0.0, 1.0))
        ->capture_default_str();
    sub->add_option("--width", options->width, "Columns: azimuth 0 to 360 degrees")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    sub->add_option("--height", options->height, "Rows: zenith angle 0 to 90 degrees")
        ->check(CLI::Range(1, 16384))
        ->capture_default_str();
    sub->callback([options, command_line] { make(*options, command_line); });
}

}  // namespace malus::cli
