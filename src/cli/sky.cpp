// sky.cpp — malus sky make: a sky map by radiative transfer; and the group of commands about skies.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <iostream>
#include <optional>

#include "cli/commands.h"
#include "cli/progress.h"
#include "cli/validators.h"
#include "malus/core/error.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/scattering_file.h"
#include "malus/io/sky_file.h"
#include "malus/optics/wavelengths.h"
#include "malus/scene/clear_sky.h"

namespace fs = std::filesystem;

namespace malus::cli {
namespace {

// Beyond, the curvature of the Earth changes the light by more than some per cent.
constexpr double kFlatEarth_deg = 82;

struct SkyOptions {
    std::string output;
    std::vector<double> wavelengths_nm{440, 550, 600};
    double sun_zenith_deg = 60, sun_azimuth_deg = 180;
    double ground_albedo = 0.2, pressure_hpa = 1013.25;
    std::optional<double> optical_depth, depolarization, solar_irradiance;
    Aerosol aerosol;
    std::string aerosol_matrix;
    std::optional<double> max_dolp;
    bool quiet = false;
    int width = 360, height = 90;
};

std::string description(const SkyOptions& options) {
    std::string text = "Rayleigh atmosphere, all orders of scattering, ground albedo " +
                       to_text(options.ground_albedo) + ", " +
                       (options.optical_depth ? "optical depth " + to_text(*options.optical_depth)
                                              : to_text(options.pressure_hpa) + " hPa");
    if (options.depolarization) text += ", depolarization " + to_text(*options.depolarization);
    if (options.solar_irradiance)
        text += ", sun of " + to_text(*options.solar_irradiance) + " W m^-2 nm^-1";
    const Aerosol& aerosol = options.aerosol;
    if (aerosol.optical_depth_550 > 0) {
        text += std::string(", aerosol ") +
                (aerosol.place == AerosolPlace::kMixed ? "mixed with" : "below") +
                " the air: optical depth " + to_text(aerosol.optical_depth_550) +
                " at 550 nm, Angstrom exponent " + to_text(aerosol.angstrom_exponent) +
                ", single-scattering albedo " + to_text(aerosol.single_scattering_albedo);
        if (aerosol.table.empty())
            text += ", Henyey-Greenstein with g " + to_text(aerosol.asymmetry) + ", polarization " +
                    to_text(aerosol.polarization);
        else
            text += ", matrix " + fs::path(options.aerosol_matrix).filename().string();
    }
    text += "; flat atmosphere: holds for sun and view within about " + to_text(kFlatEarth_deg) +
            " degrees of the zenith";
    if (options.max_dolp) text += ", polarization scaled to DoLP " + to_text(*options.max_dolp);
    return text;
}

void make(SkyOptions options, const std::string& command_line) {
    check_exr_name(options.output);
    check_writable(options.output);
    const std::vector<double> wavelengths = sorted_wavelengths(options.wavelengths_nm);
    if (!options.aerosol_matrix.empty())
        options.aerosol.table = read_scattering(options.aerosol_matrix);
    const ClearSky model{to_radians(options.sun_zenith_deg),
                         to_radians(options.sun_azimuth_deg),
                         options.ground_albedo,
                         options.pressure_hpa,
                         options.optical_depth,
                         options.depolarization,
                         options.solar_irradiance,
                         options.aerosol,
                         options.max_dolp};
    if (options.sun_zenith_deg > kFlatEarth_deg && !options.quiet)
        std::cerr
            << "malus: note: the sun stands " << to_text(options.sun_zenith_deg)
            << " degrees from the zenith; the atmosphere is computed flat, which holds to about "
            << to_text(kFlatEarth_deg) << "\n";
    const Sky sky = [&] {
        Progress progress("making the sky", options.quiet);
        return make_clear_sky(model, wavelengths, options.height, options.width,
                              [&](double done) { progress.update(done); });
    }();
    write_sky(options.output, sky,
              {{"skyModel", description(options)},
               {"malusVersion", version()},
               {"commandLine", command_line}});
}

void add_aerosol(CLI::App& sub, SkyOptions& options) {
    const char* const group = "Aerosol";
    Aerosol& aerosol = options.aerosol;
    CLI::Option* const depth =
        sub.add_option(
               "--aerosol-depth", aerosol.optical_depth_550,
               "Vertical optical depth of the aerosol at 550 nm; 0.05 clear, 0.2 usual, 0.5 hazy")
            ->group(group)
            ->check(within(0.0, 5.0))
            ->capture_default_str();
    sub.add_option("--angstrom", aerosol.angstrom_exponent,
                   "Angstrom exponent a: the optical depth goes with wavelength to the power -a")
        ->group(group)
        ->needs(depth)
        ->check(within(-1.0, 4.0))
        ->capture_default_str();
    sub.add_option("--aerosol-albedo", aerosol.single_scattering_albedo,
                   "Single-scattering albedo: share of what meets a particle that is scattered")
        ->group(group)
        ->needs(depth)
        ->check(within(0.0, 1.0))
        ->capture_default_str();
    sub.add_option(
           "--asymmetry", aerosol.asymmetry,
           "Asymmetry g of the Henyey-Greenstein function: mean cosine of scattering angles")
        ->group(group)
        ->needs(depth)
        ->check(within(-0.9, 0.9))
        ->capture_default_str();
    sub.add_option("--aerosol-polarization", aerosol.polarization,
                   "Degree of polarization of light scattered once by 90 degrees by the aerosol")
        ->group(group)
        ->needs(depth)
        ->check(within(0.0, 1.0))
        ->capture_default_str();
    sub.add_option("--aerosol-matrix", options.aerosol_matrix,
                   "Scattering matrix instead of Henyey-Greenstein's: CSV file with header "
                   "angle_deg,F11,F12,F22,F33 (wavelength_nm before it if it changes with it)")
        ->group(group)
        ->needs(depth);
    sub.add_option("--aerosol-place", aerosol.place,
                   "Where the aerosol is: mixed evenly with the air, or in a layer below it")
        ->group(group)
        ->needs(depth)
        ->transform(CLI::CheckedTransformer(std::map<std::string, AerosolPlace>{
            {"mixed", AerosolPlace::kMixed}, {"below", AerosolPlace::kBelow}}))
        ->default_str("mixed")
        ->option_text("mixed|below [mixed]");
}

}  // namespace

void add_sky(CLI::App& app, const std::string& command_line) {
    CLI::App* sky = app.add_subcommand("sky", "Make, describe and import sky maps");
    sky->require_subcommand(1);
    CLI::App* sub =
        sky->add_subcommand("make",
                            "Make a clear or hazy sky: sunlight scattered any number of times by "
                            "air (Rayleigh) and aerosol "
                            "over even ground, in a flat atmosphere (it holds for sun and view "
                            "within about 82 degrees of "
                            "the zenith). The sun's disc goes into the file as sunIrradiance.");
    const auto options = std::make_shared<SkyOptions>();
    sub->add_option("-o,--output", options->output, "Sky map to write, EXR")->required();
    sub->add_option("--wavelengths", options->wavelengths_nm,
                    "Wavelengths, nm, 280 to 4000, e.g. 440,600")
        ->delimiter(',')
        ->check(within(280.0, 4000.0))
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
    const char* const tables = "Instead of the air's own and the sun's, to compare with tables";
    sub->add_option(
           "--optical-depth", options->optical_depth,
           "Vertical optical depth of the air, at all wavelengths; without, Bodhaine's for "
           "--pressure")
        ->group(tables)
        ->check(within(1e-6, 10.0));
    sub->add_option("--depolarization", options->depolarization,
                    "Depolarization of natural light that the air scatters by 90 degrees; without, "
                    "Bates's, about 0.03")
        ->group(tables)
        ->check(within(0.0, 0.857));
    sub->add_option("--solar-irradiance", options->solar_irradiance,
                    "Irradiance of the sun above the air on a plane that faces it, W m^-2 nm^-1; "
                    "without, ASTM G173-03's")
        ->group(tables)
        ->check(within(1e-12, 1e12));
    add_aerosol(*sub, *options);
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
    sub->add_flag("--quiet", options->quiet, "No progress, no notes");
    sub->callback([options, command_line] { make(*options, command_line); });
    add_sky_info(*sky);
    add_sky_import(*sky, command_line);
}

}  // namespace malus::cli
