// brdf.cpp — malus brdf: a paint over the hemisphere of detector directions, or in one geometry.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "cli/brdf_plot.h"
#include "cli/commands.h"
#include "cli/gnuplot.h"
#include "cli/image_options.h"
#include "cli/paints.h"
#include "cli/validators.h"
#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMostZenith_deg = 89.999;  // the model diverges as 1/cos
constexpr double kLeastStep_deg = 0.1;

struct BrdfOptions {
    std::string name, csv, exr, png, json;
    std::vector<std::string> materials;
    std::vector<double> wavelengths_nm, at_deg, stokes{1, 0, 0, 0};
    double incidence_zenith_deg = 45, incidence_azimuth_deg = 0, step_deg = 1;
    bool quiet = false;
};

// `--materials a.json green_paint` gives the name to --materials, which takes any number of files.
void find_name(BrdfOptions& options) {
    if (!options.name.empty()) return;
    if (options.materials.size() < 2 || options.materials.back().ends_with(".json"))
        throw CLI::RequiredError("name");
    options.name = options.materials.back();
    options.materials.pop_back();
}

void check_outputs(const BrdfOptions& options) {
    malus::check_outputs({options.materials.begin(), options.materials.end()},
                         {options.csv, options.exr, options.png, options.json});
    if (!options.exr.empty()) check_exr_name(options.exr);
    if (!options.png.empty()) check_gnuplot();
    if (!options.json.empty() && options.at_deg.empty()) throw CLI::RequiresError("--json", "--at");
    if (options.at_deg.empty() && (options.csv + options.exr + options.png).empty())
        throw CLI::RequiredError("One of --at, --csv, --exr, --png");
}

void check_view(const std::vector<double>& at_deg) {
    if (at_deg.empty()) return;
    if (!(at_deg[0] >= 0 && at_deg[0] <= kMostZenith_deg))
        throw CLI::ValidationError("--at", "zenith " + to_text(at_deg[0]) + " is not within 0 to " +
                                               to_text(kMostZenith_deg));
    if (!(std::abs(at_deg[1]) <= 360))
        throw CLI::ValidationError("--at",
                                   "azimuth " + to_text(at_deg[1]) + " is not within -360 to 360");
}

Stokes<double> incident_light(const BrdfOptions& options) {
    const std::vector<double>& s = options.stokes;
    const Stokes<double> S{s[0], s[1], s[2], s[3]};
    if (!(S.s0 > 0) || !std::isfinite(S.s0))
        throw Error("--stokes: S0 is " + to_text(S.s0) + "; light has S0 > 0");
    if (!(dop(S) <= 1 + 1e-9))
        throw Error("--stokes: more than fully polarized (S1, S2, S3 together are " +
                    to_text(std::round(dop(S) * 1e4) / 1e4) + " of S0); make them smaller");
    return S;
}

int steps_of(double step_deg) {
    const double steps = std::round(90 / step_deg);
    if (std::abs(steps * step_deg - 90) > 1e-9)
        throw Error("--step: 90 degrees are no whole number of steps of " + to_text(step_deg) +
                    "; choose another, such as 1 or 5");
    return static_cast<int>(steps);
}

const Material& chosen_material(const MaterialFile& file, const std::string& name) {
    std::vector<std::string> names;
    for (const Material& material : file.materials) {
        if (material.name == name) return material;
        names.push_back(material.name);
    }
    throw Error("unknown material '" + one_line(name) + "'" + suggest(name, names));
}

// At the wavelengths that are asked for, else at the rows.
std::vector<PaintModel> models(const BrdfOptions& options, const Material& material) {
    std::vector<double> wavelengths = sorted_wavelengths(options.wavelengths_nm);
    if (wavelengths.empty())
        for (const MaterialRow& row : material.rows) wavelengths.push_back(row.wavelength_nm);
    std::vector<PaintModel> list;
    for (double nm : wavelengths)
        list.push_back({nm, parameters_at(material, nm), material.slopes, material.attenuation});
    return list;
}

// What is to be known of this paint, on stderr.
void print_notes(const MaterialFile& file, const Material& material,
                 const std::vector<PaintModel>& paints) {
    for (const std::string& warning : file.warnings)
        if (warning.starts_with(material.place + ":"))
            std::cerr << "malus: note: " << warning << '\n';
    std::vector<double> wavelengths;
    for (const PaintModel& paint : paints) wavelengths.push_back(paint.wavelength_nm);
    const std::string note = interpolation_note(material, wavelengths);
    if (!note.empty()) std::cerr << "malus: note: " << note << '\n';
}

SurfaceDirection light_direction(const BrdfOptions& options) {
    return {to_radians(options.incidence_zenith_deg), to_radians(options.incidence_azimuth_deg)};
}

std::string light_text(const BrdfOptions& options) {
    return "light from zenith " + to_text(options.incidence_zenith_deg) + ", azimuth " +
           to_text(options.incidence_azimuth_deg) + " degrees";
}

// ---- One geometry -------------------------------------------------------------------------------

void print_matrix(const char* title, const MuellerMatrix& m) {
    std::printf("  %s\n", title);
    for (const auto& row : m)
        std::printf("    %13.6g %13.6g %13.6g %13.6g\n", row[0], row[1], row[2], row[3]);
}

void print_value(const PaintModel& paint, const BrdfValue& value, const Stokes<double>& incident) {
    const Stokes<double> S = reflected(value, incident);
    std::printf("%s nm\n", to_text(paint.wavelength_nm).c_str());
    std::printf("  facets   tilt %.6g degrees, incidence %.6g degrees\n", to_degrees(value.theta),
                to_degrees(value.beta));
    std::printf("  P        %.6g sr^-1 (facet distribution)\n", value.facet_distribution);
    std::printf("  SO       %.6g (shadowing)\n", value.shadowing);
    if (paint.attenuation != Attenuation::kNone)
        std::printf("  G        %.6g (Torrance-Sparrow attenuation)\n", value.attenuation);
    std::printf("  f00      %.6g sr^-1\n", value.f00());
    std::printf("  S0 to S3 %.6g %.6g %.6g %.6g sr^-1\n", S.s0, S.s1, S.s2, S.s3);
    std::printf("  DoLP     %.6g\n", std::min(1.0, dolp(S)));
    std::printf("  AoLP     %.6g degrees\n", to_degrees(aolp(S)));
    print_matrix("Mueller matrix, sr^-1, meridian frames", meridian_mueller(value));
    print_matrix("Mueller matrix, sr^-1, facet frames", facet_mueller(value));
}

Json json_of(const PaintModel& paint, const BrdfValue& value, const Stokes<double>& incident) {
    const Stokes<double> S = reflected(value, incident);
    return {{"wavelength_nm", paint.wavelength_nm},
            {"facet_tilt_deg", to_degrees(value.theta)},
            {"facet_incidence_deg", to_degrees(value.beta)},
            {"facet_distribution_per_sr", value.facet_distribution},
            {"shadowing", value.shadowing},
            {"attenuation", value.attenuation},
            {"f00_per_sr", value.f00()},
            {"stokes_per_sr", {S.s0, S.s1, S.s2, S.s3}},
            {"DoLP", std::min(1.0, dolp(S))},
            {"AoLP_deg", to_degrees(aolp(S))},
            {"mueller_meridian_per_sr", meridian_mueller(value)},
            {"mueller_facet_per_sr", facet_mueller(value)}};
}

void one_geometry(const BrdfOptions& options, const Material& material,
                  const std::vector<PaintModel>& paints, const Stokes<double>& incident) {
    const SurfaceDirection view{to_radians(options.at_deg[0]), to_radians(options.at_deg[1])};
    if (!options.quiet)
        std::printf("%s: %s, seen from zenith %s, azimuth %s degrees\n", material.place.c_str(),
                    light_text(options).c_str(), to_text(options.at_deg[0]).c_str(),
                    to_text(options.at_deg[1]).c_str());
    Json list = Json::array();
    for (const PaintModel& paint : paints) {
        const BrdfValue value = brdf_at(paint, light_direction(options), view);
        if (!options.quiet) print_value(paint, value, incident);
        list.push_back(json_of(paint, value, incident));
    }
    if (!options.quiet)
        std::printf(
            "meridian frame: x in the plane of normal and beam, toward the normal; facet frame: x "
            "= "
            "s, across the plane of both beams; y = k x x, k along the beam\n");
    if (options.json.empty()) return;
    const Json whole{{"material", material.name},
                     {"incidence_zenith_deg", options.incidence_zenith_deg},
                     {"incidence_azimuth_deg", options.incidence_azimuth_deg},
                     {"view_zenith_deg", options.at_deg[0]},
                     {"view_azimuth_deg", options.at_deg[1]},
                     {"incident_stokes", options.stokes},
                     {"meridian_frame", "x = unit(n - (n.w) w), w from the surface along the beam"},
                     {"facet_frame", "x = unit(k_in x k_out)"},
                     {"values", list}};
    write_text(options.json, whole.dump(2) + "\n");
}

// ---- The hemisphere -----------------------------------------------------------------------------

// The node where a quantity is largest, the horizon left out.
std::string largest_text(const BrdfTable& table, double (*of)(const BrdfNode&)) {
    int zenith = 0, azimuth = 0;
    for (int i = 0; i < table.steps; ++i)
        for (int j = 0; j < table.azimuths(); ++j)
            // Beyond rounding, so that of two mirror images the first is named.
            if (of(table.at(i, j)) > of(table.at(zenith, azimuth)) * (1 + 1e-12))
                zenith = i, azimuth = j;
    std::array<char, 120> text{};
    std::snprintf(text.data(), text.size(), "%.4g at zenith %s, azimuth %s",
                  of(table.at(zenith, azimuth)), to_text(table.degrees(zenith)).c_str(),
                  to_text(table.degrees(azimuth)).c_str());
    return text.data();
}

void print_summary(const BrdfTable& table) {
    std::printf("  %s nm: P up to %s; S0 up to %s; DoLP up to %s; reflectance %.4g\n",
                to_text(table.paint.wavelength_nm).c_str(),
                largest_text(table, [](const BrdfNode& n) { return n.facet_distribution; }).c_str(),
                largest_text(table, [](const BrdfNode& n) { return n.out.s0; }).c_str(),
                largest_text(table, [](const BrdfNode& n) { return dolp(n.out); }).c_str(),
                reflectance(table));
}

void hemisphere(const BrdfOptions& options, const Material& material,
                const std::vector<PaintModel>& paints, const Stokes<double>& incident, int steps,
                const std::string& command_line) {
    std::vector<BrdfTable> tables;
    for (const PaintModel& paint : paints)
        tables.push_back(tabulate(paint, light_direction(options), incident, steps));
    if (!options.csv.empty()) write_text(options.csv, brdf_csv(tables));
    if (!options.exr.empty()) {
        Image image = brdf_image(tables);
        image.attributes["material"] = material.name;
        image.attributes["malusVersion"] = version();
        image.attributes["commandLine"] = command_line;
        write_exr(options.exr, image);
    }
    const bool natural = dop(incident) == 0;
    if (!options.png.empty())
        plot_brdf(options.png,
                  one_line(material.name) + ", " + light_text(options) +
                      (natural ? ", unpolarized" : ", Stokes " + to_text(options.stokes)),
                  tables);
    if (options.quiet) return;
    std::printf("%s: %s, %d x %d directions; specular azimuth %s\n", material.place.c_str(),
                light_text(options).c_str(), tables[0].azimuths(), tables[0].zeniths(),
                to_text(std::fmod(options.incidence_azimuth_deg + 540, 360)).c_str());
    for (const BrdfTable& table : tables) print_summary(table);
}

void tell(BrdfOptions& options, const std::string& command_line) {
    find_name(options);
    check_view(options.at_deg);
    check_outputs(options);
    const Stokes<double> incident = incident_light(options);
    const int steps = steps_of(options.step_deg);
    const MaterialFile file = read_paints(options.materials);
    const Material& material = chosen_material(file, options.name);
    const std::vector<PaintModel> paints = models(options, material);
    if (!options.quiet) print_notes(file, material, paints);
    if (!options.csv.empty() || !options.exr.empty() || !options.png.empty())
        hemisphere(options, material, paints, incident, steps, command_line);
    if (!options.at_deg.empty()) one_geometry(options, material, paints, incident);
}

void add_inputs(CLI::App& sub, BrdfOptions& o) {
    sub.add_option("name", o.name, "Name of the paint in one of the files (required)");
    sub.add_option("--materials", o.materials, "Paints: one or more .json files")->required();
    add_wavelengths(sub, o.wavelengths_nm,
                    "Wavelengths, nm, e.g. 440,600 [those of the paint's rows]");
    sub.add_option("--incidence-zenith", o.incidence_zenith_deg,
                   "Angle of incidence: of the direction toward the light from the normal, degrees")
        ->check(within(0, kMostZenith_deg))
        ->capture_default_str();
    sub.add_option("--incidence-azimuth", o.incidence_azimuth_deg,
                   "Azimuth of the direction toward the light, degrees clockwise seen from above; "
                   "views have the same zero")
        ->check(within(-360, 360))
        ->capture_default_str();
    sub.add_option("--stokes", o.stokes,
                   "Light that comes in: S0,S1,S2,S3 as irradiance of the surface, in its meridian "
                   "frame (S1 > 0: polarized in the plane of incidence); results are for S0 as "
                   "given [1,0,0,0: unpolarized]")
        ->delimiter(',')
        ->expected(4);
}

void add_outputs(CLI::App& sub, BrdfOptions& o) {
    sub.add_option("--at", o.at_deg,
                   "Print f00, DoLP and the Mueller matrix seen from ZENITH,AZIMUTH, degrees, e.g. "
                   "60,180")
        ->delimiter(',')
        ->expected(2);
    sub.add_option("--json", o.json, "Write what --at prints to this JSON file");
    sub.add_option("--csv", o.csv, "Write the table over the hemisphere of views, CSV");
    sub.add_option("--exr", o.exr,
                   "Write it as image, EXR: columns azimuth from 0, rows zenith from 0 (top) to 90 "
                   "degrees, pixels at these angles themselves");
    sub.add_option("--png", o.png,
                   "Draw polar plots of S0, DoLP, facet distribution and shadowing, PNG (needs "
                   "gnuplot)");
    sub.add_option("--step", o.step_deg, "Step of the table in zenith and azimuth, degrees")
        ->check(within(kLeastStep_deg, 45))
        ->capture_default_str();
    sub.add_flag("--quiet", o.quiet, "Print nothing, no notes");
}

}  // namespace

void add_brdf(CLI::App& app, const std::string& command_line) {
    CLI::App* sub = app.add_subcommand(
        "brdf",
        "Tabulate a paint: facet distribution, shadowing, f00, Stokes vector, DoLP and AoLP over "
        "the "
        "hemisphere of detector directions, or all of these and the Mueller matrix in one "
        "geometry. "
        "Azimuth of the light: back-scattering; 180 degrees from it: specular side. S0 is radiance "
        "per irradiance of the surface, 1/sr: f00 for unpolarized light. At zenith 90 f is 0 by "
        "definition. Meridian frame: S1 > 0 in the plane of normal and beam");
    const auto options = std::make_shared<BrdfOptions>();
    add_inputs(*sub, *options);
    add_outputs(*sub, *options);
    sub->callback([options, command_line] { tell(*options, command_line); });
}

}  // namespace malus::cli
