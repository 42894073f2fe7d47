// render_inputs.cpp — from names of files and views to scene, paints, sky and camera.
// SPDX-License-Identifier: Apache-2.0
#include "cli/render_inputs.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "cli/commands.h"
#include "cli/paints.h"
#include "malus/core/error.h"
#include "malus/io/gltf.h"
#include "malus/io/sky_file.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

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
        const std::string note = interpolation_note(materials[m], wavelengths);
        if (!note.empty()) warn(options, note);
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

}  // namespace

void warn(const RenderOptions& options, const std::string& text) {
    if (!options.quiet) std::cerr << "malus: note: " << text << '\n';
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

Inputs read_inputs(const RenderOptions& options) {
    Inputs in;
    MaterialFile paints = read_paints(options.materials);
    for (const std::string& warning : paints.warnings) warn(options, warning);
    in.materials = std::move(paints.materials);
    in.sky = read_sky(options.sky);
    in.scene = read_gltf(options.scene);
    for (const std::string& warning : in.sky.warnings) warn(options, warning);
    for (const std::string& warning : in.scene.warnings) warn(options, warning);
    in.paints = assign_paints(in.scene, parse_rules(options.assign), in.materials);
    in.wavelengths_nm = choose_wavelengths(options, in.sky, in.materials, in.paints);
    tell_interpolation(options, in.materials, in.paints, in.wavelengths_nm);
    in.declared_sun = in.sky.sun;
    if (options.no_sun) in.sky.sun.reset();
    in.camera = choose_camera(in.scene, options);
    in.labels = make_labels(in.scene, in.materials, in.paints);
    return in;
}

}  // namespace malus::cli
