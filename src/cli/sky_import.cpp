// sky_import.cpp — malus sky import: maps of other codes, in their conventions.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <iostream>
#include <optional>

#include "cli/commands.h"
#include "cli/validators.h"
#include "io/csv.h"
#include "malus/core/error.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/sky_file.h"
#include "malus/io/sky_import.h"
#include "malus/optics/wavelengths.h"
#include "malus/scene/sky_description.h"

namespace fs = std::filesystem;

namespace malus::cli {
namespace {

struct ImportOptions {
    std::string input, output;
    SkyImport import;
    double azimuth_zero_deg = 0;
    double s1 = 1, s2_s3 = 1, s3 = 1;
    bool mirror = false;
    std::vector<double> zenith_span_deg;
    std::vector<std::string> scale, sun_irradiance;
    std::optional<double> sun_zenith_deg, sun_azimuth_deg;
};

// "440:1.5", or "1.5" for every wavelength.
std::pair<double, double> entry_of(const std::string& text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos) return {0, number_in(text, "'" + text + "'")};
    return {number_in(text.substr(0, colon), "'" + text + "'"),
            number_in(text.substr(colon + 1), "'" + text + "'")};
}

// Says what is wrong with an entry whose number must be finite and not less than `least`, or above
// it if `least` is not allowed itself.
CLI::Validator entries(double least, bool allowed) {
    return CLI::Validator(
        [=](std::string& text) -> std::string {
            try {
                const auto [nm, value] = entry_of(text);
                if (text.find(':') != std::string::npos && !(nm > 0 && std::isfinite(nm)))
                    return "'" + text + "': the wavelength must be > 0 nm";
                if (!std::isfinite(value) || value < least || (value == least && !allowed))
                    return "'" + text + "': the number must be " + (allowed ? ">= " : "> ") +
                           to_text(least);
                return {};
            } catch (const Error& problem) {
                return problem.what();
            }
        },
        "");
}

BySpectrum by_spectrum(const std::vector<std::string>& list, const std::string& option) {
    BySpectrum values;
    for (const std::string& text : list)
        if (!values.insert(entry_of(text)).second)
            throw Error(option + ": '" + text + "' gives a wavelength again; keep one");
    return values;
}

SkyImport library_options(const ImportOptions& options) {
    SkyImport import = options.import;
    import.conventions.azimuth_zero = to_radians(options.azimuth_zero_deg);
    import.conventions.s1 = options.s1;
    import.conventions.s2 = options.s2_s3;
    import.conventions.s3 = options.s2_s3 * options.s3;
    if (options.mirror) import.half_dome = HalfDome::kMirrored;
    if (!options.zenith_span_deg.empty() &&
        options.zenith_span_deg[0] == options.zenith_span_deg[1])
        throw Error("--zenith-span: both edges are the same; give two, e.g. 0,180");
    if (!options.zenith_span_deg.empty())
        import.zenith_span = {to_radians(options.zenith_span_deg[0]),
                              to_radians(options.zenith_span_deg[1])};
    if (options.sun_zenith_deg)
        import.sun =
            Sun{to_radians(*options.sun_zenith_deg), to_radians(*options.sun_azimuth_deg), {}};
    import.scale = by_spectrum(options.scale, "--scale");
    import.sun_irradiance = by_spectrum(options.sun_irradiance, "--sun-irradiance");
    return import;
}

// For the header: what was read, and what of the dome it did not have.
std::string model_of(const ImportOptions& options, const Sky& sky) {
    std::string text = "imported from " + fs::path(options.input).filename().string();
    for (const std::string& warning : sky.warnings) text += "; " + warning;
    return text;
}

void run_import(const ImportOptions& options, const std::string& command_line) {
    check_exr_name(options.output);
    check_writable(options.output);
    check_distinct(options.output, {options.input});
    if (is_csv(options.input) && !options.zenith_span_deg.empty())
        throw Error("--zenith-span: is for pictures; a table has its own zenith angles");
    if (!is_csv(options.input) && options.import.wavelength_nm)
        throw Error(
            "--wavelength: is for tables; a picture has wavelengths in its channels' names");
    const Sky sky = import_sky(options.input, library_options(options));
    write_sky(options.output, sky,
              {{"skyModel", model_of(options, sky)},
               {"malusVersion", version()},
               {"commandLine", command_line}});
    for (const std::string& warning : sky.warnings) std::cerr << "malus: note: " << warning << "\n";
    for (const std::string& doubt : describe_sky(sky).doubts)
        std::cerr << "malus: note: " << options.output << ": " << doubt << "\n";
}

// A switch whose words stand for values.
template <class Value>
void add_switch(CLI::App& sub, const std::string& name, Value& value, const std::string& text,
                const std::map<std::string, Value>& words, const std::string& shown) {
    sub.add_option(name, value, text)
        ->group("Conventions of the file")
        ->transform(CLI::CheckedTransformer(words))
        ->option_text(shown);
}

void add_conventions(CLI::App& sub, ImportOptions& options) {
    const char* const group = "Conventions of the file";
    SkyConventions& conventions = options.import.conventions;
    sub.add_option("--azimuth-zero", options.azimuth_zero_deg,
                   "Where the file's azimuth 0 is, in degrees clockwise from north (east is 90). "
                   "For azimuths counted from the sun: the number given to --sun-azimuth")
        ->group(group)
        ->check(within(-360.0, 360.0))
        ->capture_default_str();
    add_switch<AzimuthSense>(
        sub, "--azimuth-sense", conventions.azimuth_sense,
        "Which way the file's azimuths grow, as seen from above",
        {{"clockwise", AzimuthSense::kClockwise}, {"anticlockwise", AzimuthSense::kAnticlockwise}},
        "clockwise|anticlockwise [clockwise]");
    add_switch<AnglesOf>(sub, "--direction", conventions.angles_of,
                         "Whether the file's angles say where one looks, or where the light goes: "
                         "azimuth + 180, zenith angle 180 - z",
                         {{"view", AnglesOf::kView}, {"propagation", AnglesOf::kPropagation}},
                         "view|propagation [view]");
    const std::map<std::string, double> signs{{"same", 1.0}, {"reversed", -1.0}};
    add_switch<double>(sub, "--s1", options.s1,
                       "Sign of the file's S1 (Q): same, if S1 > 0 is polarized in the vertical "
                       "plane",
                       signs, "same|reversed [same]");
    add_switch<double>(sub, "--s2-s3", options.s2_s3,
                       "Sign of the file's S2 and S3 (U, V): same, if S2 > 0 is polarized at +45 "
                       "degrees, anticlockwise from the vertical for one who looks at the sky, and "
                       "S3 > 0 turns clockwise for the same",
                       signs, "same|reversed [same]");
    add_switch<double>(sub, "--s3", options.s3,
                       "Sign of S3 alone, on top of --s2-s3: an axis that is turned by 90 degrees "
                       "reverses S1 and S2, and leaves S3",
                       signs, "same|reversed [same]");
    sub.add_flag(
           "--mirror", options.mirror,
           "The file has azimuths from 0 to 180 only, the sun's vertical at 0 or 180: the other "
           "half is its mirror image, with S2 and S3 reversed")
        ->group(group);
    sub.add_option("--zenith-span", options.zenith_span_deg,
                   "EXR: the file's zenith angles at the picture's upper and lower edge, degrees, "
                   "e.g. 0,180 for a whole sphere; without: 0,90 (propagation: 180,90)")
        ->group(group)
        ->delimiter(',')
        ->expected(2)
        ->check(within(0.0, 180.0));
}

void add_light(CLI::App& sub, ImportOptions& options) {
    const char* const group = "Light and sun";
    sub.add_option(
           "--scale", options.scale,
           "Number that brings the file's unit to W m^-2 sr^-1 nm^-1, e.g. 1.83, or one for "
           "each wavelength, e.g. 440:1.83,550:1.86: the sun's irradiance, where the file "
           "has I/F0")
        ->group(group)
        ->delimiter(',')
        ->check(entries(0, false))
        ->option_text("[NM:]X,... [1]");
    sub.add_option("--wavelength", options.import.wavelength_nm,
                   "CSV: wavelength of a file that has no column for it, nm")
        ->group(group)
        ->check(within(1.0, 1e6));
    auto* zenith = sub.add_option("--sun-zenith", options.sun_zenith_deg,
                                  "Zenith angle of the sun, degrees; without, what the file says")
                       ->group(group)
                       ->check(within(0.0, 180.0));
    auto* azimuth =
        sub.add_option("--sun-azimuth", options.sun_azimuth_deg,
                       "Azimuth of the sun, degrees clockwise from north, whatever the file's "
                       "conventions; without, what the file says in its own")
            ->group(group)
            ->check(within(-360.0, 360.0));
    zenith->needs(azimuth);
    azimuth->needs(zenith);
    sub.add_option("--sun-irradiance", options.sun_irradiance,
                   "Irradiance of the sun's beam at the ground on a plane that faces it, "
                   "W m^-2 nm^-1, e.g. 440:1.12,550:1.53")
        ->group(group)
        ->delimiter(',')
        ->check(entries(0, true))
        ->option_text("NM:X,...");
}

}  // namespace

void add_sky_import(CLI::App& sky, const std::string& command_line) {
    CLI::App* sub = sky.add_subcommand(
        "import",
        "Write the sky map of another code in our conventions: azimuths clockwise from north of "
        "where one looks, S1 > 0 polarized in the vertical plane. CSV: a line of names, then a "
        "full "
        "grid; columns wavelength (lambda), zenith (theta, vza), azimuth (phi, vaa), S0 (I), S1 "
        "(Q), "
        "S2 (U), S3 (V, may be missing), in any order, degrees and nm. EXR: a spectral EXR with "
        "channels S0 to S3, rows zenith angles, columns azimuths. Nodes that stand at the centres "
        "of the new map's pixels are kept as they are, others are interpolated. With the sun's "
        "place known, what is wrong with azimuths or signs is noted, as malus sky info does.");
    const auto options = std::make_shared<ImportOptions>();
    sub->add_option("input", options->input, "Map to read, .csv or .exr")->required();
    sub->add_option("-o,--output", options->output, "Sky map to write, EXR")->required();
    add_conventions(*sub, *options);
    add_light(*sub, *options);
    sub->add_option(
           "--width", options->import.width,
           "Columns of the new map: azimuth 0 to 360 degrees; without: as many as the file "
           "has where its nodes are evenly spaced, else 360")
        ->check(CLI::Range(1, 65536));
    sub->add_option("--height", options->import.height,
                    "Rows of the new map: zenith angle 0 to 90 degrees; without: as fine as the "
                    "file's nodes where they are evenly spaced, else 90")
        ->check(CLI::Range(1, 16384));
    sub->callback([options, command_line] { run_import(*options, command_line); });
}

}  // namespace malus::cli
