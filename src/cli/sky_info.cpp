// sky_info.cpp — malus sky info: what a sky map shows, and whether it stands right to its sun.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "cli/commands.h"
#include "cli/validators.h"
#include "malus/io/sky_file.h"
#include "malus/optics/wavelengths.h"
#include "malus/scene/sky_description.h"

namespace malus::cli {
namespace {

struct InfoOptions {
    std::string sky;
    std::optional<double> sun_zenith_deg, sun_azimuth_deg;
};

// "zenith 30.5, azimuth 120.5 degrees"
std::string text_of(const SkyPlace& place) {
    const auto degrees = [](double x) { return to_text(std::round(to_degrees(x) * 100) / 100); };
    return "zenith " + degrees(place.zenith) + ", azimuth " + degrees(place.azimuth) + " degrees";
}

void print_point(const char* name, const std::optional<double>& angle, const char* from) {
    if (angle)
        std::printf("    %-12s %.1f degrees %s\n", name, to_degrees(*angle), from);
    else
        std::printf("    %-12s none found %s\n", name, from);
}

void print_light(const SkyAtWavelength& light, const Sky& sky) {
    std::printf("  %s nm\n", to_text(light.wavelength_nm).c_str());
    std::printf("    %-12s %.4g to %.4g W m^-2 sr^-1 nm^-1, brightest at %s\n", "S0",
                light.least_s0, light.most_s0, text_of(light.brightest).c_str());
    std::printf("    %-12s of the sky on level ground %.4g W m^-2 nm^-1", "irradiance",
                light.sky_irradiance);
    if (light.sun_irradiance) std::printf(", of the sun's beam %.4g", *light.sun_irradiance);
    std::printf("\n    %-12s up to %.3f at %s", "DoLP", light.largest_dolp,
                text_of(light.most_polarized).c_str());
    if (light.most_polarized_from_sun)
        std::printf(", %.1f from the sun", to_degrees(*light.most_polarized_from_sun));
    if (light.dolp_at_right_angle)
        std::printf("; %.3f at 90 from the sun in its vertical", *light.dolp_at_right_angle);
    std::printf("\n");
    if (!sky.sun) return;
    print_point("Babinet", light.babinet, "above the sun");
    print_point("Brewster", light.brewster, "below the sun");
    print_point("Arago", light.arago, "above the antisun");
    std::printf("    %-12s about the sun's vertical: S0 %.3f, S1 and S2 %.3f\n", "asymmetry",
                light.orientation->brightness_asymmetry, light.orientation->polarization_asymmetry);
    if (light.orientation->deviation)
        std::printf(
            "    %-12s %.1f degrees (median) from the perpendicular of the plane sun-view\n",
            "AoLP", to_degrees(*light.orientation->deviation));
}

void describe(const InfoOptions& options) {
    Sky sky = read_sky(options.sky);
    if (options.sun_zenith_deg) {
        if (!sky.sun) sky.sun = Sun{};
        sky.sun->zenith = to_radians(*options.sun_zenith_deg);
        sky.sun->azimuth = to_radians(*options.sun_azimuth_deg);
    }
    const SkyDescription description = describe_sky(sky);
    std::printf("%s: sky map, %zu azimuths x %zu zenith angles (%.4g to %.4g degrees) at %s nm\n",
                options.sky.c_str(), sky.azimuths.size(), sky.zeniths.size(),
                to_degrees(sky.zeniths.front()), to_degrees(sky.zeniths.back()),
                to_text(sky.wavelengths_nm).c_str());
    if (sky.sun)
        std::printf("  sun at %s%s\n", text_of({sky.sun->zenith, sky.sun->azimuth}).c_str(),
                    sky.sun->irradiance.empty() ? "" : ", with its disc");
    for (const SkyAtWavelength& light : description.light) print_light(light, sky);
    for (const std::string& doubt : description.doubts) std::printf("  doubt %s\n", doubt.c_str());
    for (const std::string& warning : sky.warnings) std::printf("  note  %s\n", warning.c_str());
    for (const std::string& line : description.missing) std::printf("  note  %s\n", line.c_str());
}

}  // namespace

void add_sky_info(CLI::App& sky) {
    CLI::App* sub = sky.add_subcommand(
        "info",
        "Describe a sky map: range of S0, irradiance, DoLP, neutral points, what it leaves out, "
        "and "
        "whether its light stands to the sun as that of a sky does. A line 'doubt' says what "
        "cannot "
        "be right, such as an azimuth counted the other way or a sign of S1 or S2. All directions "
        "are where one looks, in degrees, azimuths clockwise from north.");
    const auto options = std::make_shared<InfoOptions>();
    sub->add_option("sky", options->sky, "Sky map, .exr or .csv")->required();
    auto* zenith =
        sub->add_option("--sun-zenith", options->sun_zenith_deg,
                        "Zenith angle of the sun, degrees; as the file has it if left out")
            ->check(within(0.0, 180.0));
    auto* azimuth =
        sub->add_option("--sun-azimuth", options->sun_azimuth_deg,
                        "Azimuth of the sun, degrees clockwise from north; as the file has it if "
                        "left out")
            ->check(within(-360.0, 360.0));
    zenith->needs(azimuth);
    azimuth->needs(zenith);
    sub->callback([options] { describe(*options); });
}

}  // namespace malus::cli
