// info.cpp — malus info FILE: what a file holds, for people.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <iostream>

#include "cli/commands.h"
#include "malus/core/error.h"
#include "malus/io/gltf.h"
#include "malus/io/material_file.h"
#include "malus/io/sky_file.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

void describe_scene(const std::string& path) {
    const Scene scene = read_gltf(path);
    const Box box = bounds(scene);
    std::printf("%s: glTF scene, %zu triangles in %zu meshes, %zu placed\n", path.c_str(),
                triangle_count(scene), scene.meshes.size(), scene.instances.size());
    std::printf("  box    %g %g %g to %g %g %g m\n", box.lower.x, box.lower.y, box.lower.z,
                box.upper.x, box.upper.y, box.upper.z);
    for (std::size_t n = 0; n < scene.nodes.size(); ++n)
        if (scene.nodes[n].parent < 0)
            std::printf("  node   %s\n", one_line(scene.nodes[n].name).c_str());
    for (const std::string& name : scene.surfaces)
        std::printf("  paint  %s (glTF material)\n", one_line(name).c_str());
    for (const Camera& camera : scene.cameras)
        std::printf("  camera %s, %s\n", one_line(camera.name).c_str(),
                    camera.projection == Projection::kPerspective ? "perspective" : "orthographic");
    for (const std::string& warning : scene.warnings) std::printf("  note   %s\n", warning.c_str());
}

void describe_materials(const std::string& path) {
    const MaterialFile file = read_materials(path);
    for (const Material& m : file.materials) {
        std::printf("%s: %s slopes%s\n", m.place.c_str(),
                    m.slopes == Slopes::kGaussian ? "Gaussian" : "Cauchy",
                    m.attenuation == Attenuation::kNone ? "" : ", Torrance-Sparrow attenuation");
        for (const MaterialRow& row : m.rows)
            std::printf("  %s nm: n %g, k %g, B %g, sigma %g, rho_d %g, rho_v %g /sr\n",
                        to_text(row.wavelength_nm).c_str(), row.p.n, row.p.k, row.p.B, row.p.sigma,
                        row.p.rho_d, row.p.rho_v);
    }
    for (const std::string& warning : file.warnings) std::printf("  note %s\n", warning.c_str());
}

void describe_sky(const std::string& path) {
    const Sky sky = read_sky(path);
    std::printf("%s: sky map, %zu azimuths x %zu zenith angles (%.4g to %.4g degrees) at %s nm\n",
                path.c_str(), sky.azimuths.size(), sky.zeniths.size(),
                to_degrees(sky.zeniths.front()), to_degrees(sky.zeniths.back()),
                to_text(sky.wavelengths_nm).c_str());
    for (const std::string& warning : sky.warnings) std::printf("  note %s\n", warning.c_str());
    if (sky.sun)
        std::printf("  sun at zenith %g, azimuth %g degrees%s\n", to_degrees(sky.sun->zenith),
                    to_degrees(sky.sun->azimuth),
                    sky.sun->irradiance.empty() ? " (no disc)" : ", with its disc");
    const std::size_t nodes = sky.zeniths.size() * sky.azimuths.size();
    for (std::size_t w = 0; w < sky.wavelengths_nm.size(); ++w) {
        double brightest = 0, most = 0;
        for (std::size_t i = 0; i < nodes; ++i) {
            brightest = std::max(brightest, sky.nodes[w * nodes + i].s0);
            most = std::max(most, dolp(sky.nodes[w * nodes + i]));
        }
        std::printf("  %s nm: S0 up to %.4g W m^-2 sr^-1 nm^-1, DoLP up to %.4g\n",
                    to_text(sky.wavelengths_nm[w]).c_str(), brightest, most);
    }
}

void describe_attributes(const Image& image) {
    for (const auto& [name, value] : image.attributes) {
        if (const auto* text = std::get_if<std::string>(&value))
            std::printf("  %s: %s\n", name.c_str(), one_line(*text, 400).c_str());
        else if (const auto* number = std::get_if<float>(&value))
            std::printf("  %s: %g\n", name.c_str(), static_cast<double>(*number));
        else if (const auto* integer = std::get_if<int>(&value))
            std::printf("  %s: %d\n", name.c_str(), *integer);
        else
            for (std::size_t i = 0; i < std::get<3>(value).size(); ++i)
                std::printf("  %s %zu: %s\n", name.c_str(), i,
                            one_line(std::get<3>(value)[i]).c_str());
    }
}

// Mean over the pixels that show a surface, if the image says which.
double surface_mean(const Image& image, const std::string& quantity, double nm) {
    const std::vector<float>& data = spectral_data(image, quantity, nm);
    const auto coverage = image.channels.find("A");
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < data.size(); ++i) {
        if (coverage != image.channels.end() && !(coverage->second[i] > 0)) continue;
        sum += static_cast<double>(data[i]);
        count += 1;
    }
    return count > 0 ? sum / count : 0;
}

void describe_image(const std::string& path, const Image& image) {
    std::printf("%s: %d x %d pixels, %zu channels\n", path.c_str(), image.width, image.height,
                image.channels.size());
    for (double nm : stokes_wavelengths(image)) {
        const double s0 = surface_mean(image, "S0", nm);
        std::printf("  %s nm: mean S0 %.4g", to_text(nm).c_str(), s0);
        // Of the mean Stokes vector: noise would add to a mean of DoLPs.
        if (s0 > 0 && image.channels.count(spectral_channel("StdErr_DoLP", nm)))
            std::printf(
                ", its DoLP %.4g, a pixel's standard errors %.2g and %.2g on average",
                std::hypot(surface_mean(image, "S1", nm), surface_mean(image, "S2", nm)) / s0,
                surface_mean(image, "StdErr_S0", nm), surface_mean(image, "StdErr_DoLP", nm));
        std::printf("\n");
    }
    describe_attributes(image);
}

void describe(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (ending == ".gltf" || ending == ".glb") return describe_scene(path);
    if (ending == ".json") return describe_materials(path);
    if (ending == ".csv") return describe_sky(path);
    if (ending != ".exr")
        throw Error(path +
                    ": no kind of file that malus knows; name a scene (.gltf, .glb), paints "
                    "(.json), a sky (.exr, .csv) or a rendered image (.exr)");
    const Image image = read_exr(path);
    const std::string* frame = image.text("stokesReferenceFrame");
    if (frame && *frame == "meridian") return describe_sky(path);
    describe_image(path, image);
}

}  // namespace

void add_info(CLI::App& app) {
    CLI::App* sub = app.add_subcommand(
        "info",
        "Say what a file holds: scene (.gltf, .glb), paints (.json), sky (.exr, .csv) or "
        "rendered image (.exr)");
    const auto path = std::make_shared<std::string>();
    sub->add_option("file", *path, "File to describe")->required();
    sub->callback([path] { describe(*path); });
}

}  // namespace malus::cli
