// render.cpp — malus render: from files to an image with error bars.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <thread>

#include "cli/commands.h"
#include "cli/progress.h"
#include "cli/validators.h"
#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/io/gltf.h"
#include "malus/io/material_file.h"
#include "malus/io/sky_file.h"
#include "malus/io/spectral_image.h"
#include "malus/io/stats_file.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

struct RenderOptions {
    std::string scene, sky, output, stats, camera, look_at;
    std::vector<std::string> materials, assign;
    std::vector<double> wavelengths_nm;
    double view_zenith_deg = 30, view_azimuth_deg = 0, fov_deg = 0, margin = 0.05;
    bool orthographic = false, no_sun = false, debias = false, quiet = false;
    CLI::Option* camera_option = nullptr;
    std::vector<CLI::Option*> view_options;
    RenderSettings settings;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void warn(const RenderOptions& options, const std::string& text) {
    if (!options.quiet) std::cerr << "malus: note: " << text << '\n';
}

std::vector<Material> read_all_materials(const RenderOptions& options) {
    std::vector<Material> all;
    for (const std::string& path : options.materials) {
        MaterialFile file = read_materials(path);
        for (const std::string& warning : file.warnings) warn(options, warning);
        for (Material& material : file.materials) {
            for (const Material& other : all)
                if (other.name == material.name)
                    throw Error(material.place + ": a material of this name stands in " +
                                other.place + " too; rename one");
            all.push_back(std::move(material));
        }
    }
    return all;
}

std::vector<PaintRule> parse_rules(const std::vector<std::string>& texts) {
    std::vector<PaintRule> rules;
    for (const std::string& text : texts) {
        const std::size_t equals = text.rfind('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
            throw Error("--assign " + one_line(text) + ": expected NAME=MATERIAL");
        rules.push_back({text.substr(0, equals), text.substr(equals + 1)});
    }
    return rules;
}

// The requested wavelengths, or all of the sky that every paint in use covers; ascending.
std::vector<double> choose_wavelengths(const RenderOptions& options, const Sky& sky,
                                       const std::vector<Material>& materials,
                                       const std::vector<int>& paints) {
    std::vector<double> chosen = sorted_wavelengths(options.wavelengths_nm);
    for (double nm : chosen)
        if (!find_wavelength(sky.wavelengths_nm, nm))
            throw Error(options.sky + ": no light at " + to_text(nm) + " nm (it has " +
                        to_text(sky.wavelengths_nm) +
                        " nm); choose other --wavelengths or another sky");
    if (!chosen.empty()) return chosen;
    std::vector<double> left_out;
    for (double nm : sky.wavelengths_nm) {
        const bool covered = std::all_of(paints.begin(), paints.end(), [&](int paint) {
            return materials[static_cast<std::size_t>(paint)].covers(nm);
        });
        (covered ? chosen : left_out).push_back(nm);
    }
    if (!left_out.empty() && !chosen.empty())
        warn(options, options.sky + ": " + to_text(left_out) +
                          " nm left out (no data of all materials in use there)");
    if (chosen.empty())
        throw Error(options.sky + ": none of its wavelengths (" + to_text(sky.wavelengths_nm) +
                    " nm) is covered by all materials in use; make a sky that shares some");
    return chosen;
}

// Says once for each paint in use where its parameters are read between rows.
void tell_interpolation(const RenderOptions& options, const std::vector<Material>& materials,
                        const std::vector<int>& paints, const std::vector<double>& wavelengths) {
    for (std::size_t m = 0; m < materials.size(); ++m) {
        if (std::find(paints.begin(), paints.end(), static_cast<int>(m)) == paints.end()) continue;
        std::vector<double> between;
        for (double nm : wavelengths)
            if (materials[m].covers(nm) &&
                std::none_of(materials[m].rows.begin(), materials[m].rows.end(),
                             [&](const MaterialRow& row) {
                                 return std::abs(row.wavelength_nm - nm) < kSameWavelength_nm;
                             }))
                between.push_back(nm);
        if (!between.empty())
            warn(options, materials[m].place + ": parameters at " + to_text(between) +
                              " nm are interpolated linearly between rows");
    }
}

bool asks_for_view(const RenderOptions& options) {
    return std::any_of(options.view_options.begin(), options.view_options.end(),
                       [](const CLI::Option* option) { return !option->empty(); });
}

const Camera& named_camera(const Scene& scene, const RenderOptions& options) {
    std::vector<std::string> names;
    for (const Camera& camera : scene.cameras) {
        if (camera.name == options.camera) return camera;
        names.push_back(camera.name);
    }
    throw Error(options.scene + ": no camera '" + one_line(options.camera) + "'" +
                (names.empty() ? "; it has none, use --view-zenith and --view-azimuth"
                               : suggest(options.camera, names)));
}

int named_node(const Scene& scene, const RenderOptions& options) {
    std::vector<std::string> names;
    for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
        if (scene.nodes[n].name == options.look_at && !bounds(scene, static_cast<int>(n)).empty())
            return static_cast<int>(n);
        if (!scene.nodes[n].name.empty()) names.push_back(scene.nodes[n].name);
    }
    throw Error(options.scene + ": --look-at " + one_line(options.look_at) +
                ": no node of this name holds triangles" + suggest(options.look_at, names));
}

Camera choose_camera(const Scene& scene, const RenderOptions& options) {
    if (!options.camera_option->empty()) return named_camera(scene, options);
    if (!asks_for_view(options) && !scene.cameras.empty()) return scene.cameras.front();
    const Box box = bounds(scene, options.look_at.empty() ? -1 : named_node(scene, options));
    View from{to_radians(options.view_zenith_deg),
              to_radians(options.view_azimuth_deg),
              {},
              options.margin};
    if (options.fov_deg > 0) from.yfov = to_radians(options.fov_deg);
    return frame_view(from, box, options.settings.width, options.settings.height);
}

Labels make_labels(const Scene& scene, const std::vector<Material>& materials,
                   const std::vector<int>& paints) {
    Labels labels;
    labels.material_of_instance = paints;
    for (const Material& material : materials) labels.materials.push_back(material.name);
    for (const Node& node : scene.nodes) labels.nodes.push_back(node.name);
    for (const Instance& instance : scene.instances)
        labels.node_of_instance.push_back(instance.node);
    return labels;
}

// What a person wants to know when it is done, on one line.
void tell_result(const RenderOptions& options, const RenderStats& stats,
                 const RenderResult& result) {
    // Said even in a quiet run: numbers may be missing.
    if (result.refused > 0)
        std::cerr << "malus: warning: " << refusal_warning(result, stats.seed) << '\n';
    if (options.quiet) return;
    std::string errors;
    for (std::size_t w = 0; w < result.film.wavelengths_nm.size(); ++w) {
        const ErrorSummary error = summarize_error(result.film, w);
        char text[96];
        std::snprintf(text, sizeof text, "%s %s nm S0 %.2g %%, DoLP %.2g", w ? ";" : "",
                      to_text(result.film.wavelengths_nm[w]).c_str(), 100 * error.rms_s0_relative,
                      error.rms_dolp);
        errors += text;
    }
    std::printf("%s: %.1f s, %.2g million rays/s, standard error (rms)%s; %llu samples refused\n",
                options.output.c_str(), stats.render_s,
                static_cast<double>(result.rays) / std::max(1e-9, stats.render_s) / 1e6,
                errors.c_str(), static_cast<unsigned long long>(result.refused));
}

std::string view_text(const RenderOptions& options) {
    if (!options.camera_option->empty()) return "camera " + options.camera;
    if (!asks_for_view(options)) return "first camera, or zenith 30, azimuth 0 degrees";
    return "zenith " + to_text(options.view_zenith_deg) + ", azimuth " +
           to_text(options.view_azimuth_deg) + " degrees, " +
           (options.fov_deg > 0 ? "field of view " + to_text(options.fov_deg) + " degrees"
                                : std::string("orthographic")) +
           (options.look_at.empty() ? "" : ", of " + options.look_at);
}

// What the picture was made of and how, whether it came from the command line or a --config file.
void add_provenance(Image& image, const RenderOptions& options, const RenderStats& stats,
                    const std::string& command_line) {
    image.attributes["malusVersion"] = stats.version;
    image.attributes["commandLine"] = command_line;
    image.attributes["seed"] = std::to_string(stats.seed);
    image.attributes["wallTime"] =
        static_cast<float>(stats.load_s + stats.build_s + stats.render_s);
    image.attributes["scene"] = options.scene;
    image.attributes["sky"] = options.sky;
    image.attributes["materials"] = options.materials;
    image.attributes["assign"] = options.assign;
    image.attributes["view"] = view_text(options);
    image.attributes["skyGridCells"] = static_cast<int>(stats.sky.cells);
    image.attributes["samplesPerPixel"] = static_cast<int>(stats.spp);
    image.attributes["maxDepth"] = stats.max_depth;
}

// `--materials a.json scene.glb` gives the scene to --materials, which takes any number of files.
void find_scene(RenderOptions& options) {
    if (!options.scene.empty()) return;
    const std::string last = options.materials.back();
    if (options.materials.size() < 2 || !(last.ends_with(".gltf") || last.ends_with(".glb")))
        throw CLI::RequiredError("scene");
    options.scene = last;
    options.materials.pop_back();
}

// Outputs can be written and replace nothing that is read or written besides.
void check_outputs(const RenderOptions& options) {
    std::vector<std::filesystem::path> others(options.materials.begin(), options.materials.end());
    others.insert(others.end(), {options.scene, options.sky});
    check_exr_name(options.output);
    check_writable(options.output);
    check_distinct(options.output, others);
    if (options.stats.empty()) return;
    others.push_back(options.output);
    check_writable(options.stats);
    check_distinct(options.stats, others);
}

// All that is read before the first ray.
struct Inputs {
    std::vector<Material> materials;
    Sky sky;
    Scene scene;
    std::vector<int> paints;
    std::vector<double> wavelengths_nm;
    Camera camera;
    Labels labels;
};

Inputs read_inputs(const RenderOptions& options) {
    Inputs in;
    in.materials = read_all_materials(options);
    in.sky = read_sky(options.sky);
    in.scene = read_gltf(options.scene);
    for (const std::string& warning : in.sky.warnings) warn(options, warning);
    for (const std::string& warning : in.scene.warnings) warn(options, warning);
    in.paints = assign_paints(in.scene, parse_rules(options.assign), in.materials);
    in.wavelengths_nm = choose_wavelengths(options, in.sky, in.materials, in.paints);
    tell_interpolation(options, in.materials, in.paints, in.wavelengths_nm);
    if (options.no_sun) in.sky.sun.reset();
    in.camera = choose_camera(in.scene, options);
    in.labels = make_labels(in.scene, in.materials, in.paints);
    return in;
}

// The settings as they will be carried out.
RenderSettings final_settings(const RenderOptions& options) {
    RenderSettings settings = options.settings;
    settings.spp = whole_spp(settings.spp, settings.replicates);
    if (settings.spp != options.settings.spp)
        warn(options, "--spp " + std::to_string(options.settings.spp) + " is taken as " +
                          std::to_string(settings.spp) + ", a multiple of the " +
                          std::to_string(kReplicates) + " replicates that give the error bars");
    if (settings.threads == 0)
        settings.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    catch_interrupts();
    settings.stop = &interrupted();
    return settings;
}

RenderResult render_with_progress(const RenderOptions& options, const PreparedScene& scene,
                                  const Camera& camera, RenderSettings settings) {
    Progress progress("rendering", options.quiet);
    settings.progress = [&](double done) { progress.update(done); };
    return render(scene, camera, settings);
}

void render_to_file(RenderOptions& options, const std::string& command_line) {
    RenderStats stats;
    auto start = std::chrono::steady_clock::now();
    find_scene(options);
    check_outputs(options);
    Inputs in = read_inputs(options);
    stats.load_s = seconds_since(start);

    start = std::chrono::steady_clock::now();
    const PreparedScene prepared(std::move(in.scene), in.paints, in.materials, in.sky,
                                 in.wavelengths_nm);
    stats.build_s = seconds_since(start);
    stats.sky = prepared.sky_resampling();

    start = std::chrono::steady_clock::now();
    const RenderSettings settings = final_settings(options);
    const RenderResult result = render_with_progress(options, prepared, in.camera, settings);
    stats.render_s = seconds_since(start);
    if (result.stopped_by == StoppedBy::kRequest)
        throw Error(options.output + ": not written (stopped by a signal before it was finished)");

    stats.version = version();
    stats.scene = options.scene;
    stats.spp = settings.spp;
    stats.max_depth = settings.max_depth;
    stats.threads = settings.threads;
    stats.seed = settings.seed;
    start = std::chrono::steady_clock::now();
    Image image = to_image(result.film, in.labels,
                           options.debias ? DolpEstimator::kDebiased : DolpEstimator::kRaw);
    add_provenance(image, options, stats, command_line);
    write_exr(options.output, image);
    stats.write_s = seconds_since(start);
    if (!options.stats.empty()) write_stats(options.stats, stats, result);
    tell_result(options, stats, result);
}

void add_inputs(CLI::App& sub, RenderOptions& o) {
    sub.add_option("scene", o.scene, "Scene, glTF 2.0: .gltf or .glb (required)");
    sub.add_option("--sky", o.sky, "Sky map: .exr (malus sky make) or .csv")->required();
    sub.add_flag("--no-sun", o.no_sun,
                 "Leave out the sun's disc, which lights the scene where the sky map declares one "
                 "(sunIrradiance)");
    sub.add_option("--materials", o.materials, "Paints: one or more .json files")->required();
    sub.add_option("-o,--output", o.output, "Image to write, EXR")->required();
    sub.add_option("--stats", o.stats, "Write what was done to this JSON file");
    sub.add_option("--wavelengths", o.wavelengths_nm,
                   "Wavelengths, nm, e.g. 440,600 [all of the sky that the materials cover]")
        ->delimiter(',')
        ->allow_extra_args(false);
    sub.add_option("--assign", o.assign,
                   "Give a glTF node, mesh or material (by name; * for the rest) a paint: "
                   "NAME=MATERIAL; repeatable [the paint named like the glTF material]")
        ->take_all()
        ->expected(1)
        ->allow_extra_args(false);
}

void add_view(CLI::App& sub, RenderOptions& o) {
    const std::string group = "View";
    o.camera_option =
        sub.add_option("--camera", o.camera,
                       "A camera of the scene, by name [the first, unless an option below asks for "
                       "another view]")
            ->group(group);
    o.view_options = {
        sub.add_option("--view-zenith", o.view_zenith_deg,
                       "Zenith angle of the detector as seen from the target, degrees")
            ->check(within(0.0, 180.0)),
        sub.add_option("--view-azimuth", o.view_azimuth_deg,
                       "Azimuth of the detector as seen from the target, degrees clockwise from "
                       "north (-Z); image up is away from the ground, north when looking straight "
                       "down")
            ->check(within(-360.0, 360.0)),
        sub.add_option("--look-at", o.look_at, "Frame this node instead of the whole scene"),
        sub.add_option("--fov", o.fov_deg,
                       "Perspective with this vertical field of view, degrees [orthographic]")
            ->check(within(1e-3, 170.0)),
        sub.add_flag("--orthographic", o.orthographic,
                     "Orthographic view (the default of these views)"),
        sub.add_option("--margin", o.margin, "Free border, fraction of the picture")
            ->check(within(0.0, 0.45))};
    for (CLI::Option* option : o.view_options) {
        option->group(group)->excludes(o.camera_option);
        if (option->get_name() != "--look-at" && option->get_name() != "--fov" &&
            option->get_name() != "--orthographic")
            option->capture_default_str();
    }
    o.view_options[4]->excludes(o.view_options[3]);
}

void add_sampling(CLI::App& sub, RenderOptions& o) {
    RenderSettings& s = o.settings;
    sub.add_option("--width", s.width, "Columns, pixels")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    sub.add_option("--height", s.height, "Rows, pixels")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    sub.add_option("--spp", s.spp, "Samples a pixel, rounded up to a multiple of 8")
        ->check(CLI::Range(1u, 1u << 30))
        ->capture_default_str();
    sub.add_option("--max-depth", s.max_depth,
                   "Surface reflections on a path: 1 = sky light only, 2 = target-background too")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    sub.add_option("--seed", s.seed, "Another seed gives an independent image")
        ->check(within(0, 18446744073709549568.0))
        ->capture_default_str();
    sub.add_option("--threads", s.threads,
                   "Threads; 0: all of the machine. The image does not depend on it")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str();
    sub.add_flag("--debias", o.debias,
                 "Take from each pixel's DoLP what noise adds to it on average (MAS estimate, "
                 "Plaszczynski et al. 2014); the Stokes vector stays as it is. Average Stokes "
                 "vectors, never such DoLPs");
    sub.add_flag("--quiet", o.quiet, "No progress, no notes, no closing line");
}

}  // namespace

void add_render(CLI::App& app, const std::string& command_line) {
    CLI::App* sub = app.add_subcommand(
        "render",
        "Render a scene under a sky to a spectral EXR: S0..S3, DoLP, AoLP (degrees from image "
        "right, counter-clockwise) and their standard errors per pixel and wavelength");
    const auto options = std::make_shared<RenderOptions>();
    add_inputs(*sub, *options);
    add_view(*sub, *options);
    add_sampling(*sub, *options);
    sub->callback([options, command_line] { render_to_file(*options, command_line); });
}

}  // namespace malus::cli
