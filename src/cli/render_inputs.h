// render_inputs.h — the options of malus render, and all that is read before the first ray.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/io/spectral_image.h"
#include "malus/render/render.h"

namespace CLI {
class Option;
}

namespace malus::cli {

struct RenderOptions {
    std::string scene, sky, output, resume, stats, camera, look_at;
    std::vector<std::string> materials, assign;
    std::vector<double> wavelengths_nm;
    double view_zenith_deg = 30, view_azimuth_deg = 0, fov_deg = 0, margin = 0.05;
    bool orthographic = false, no_sun = false, debias = false, final = false, quiet = false;
    bool compress = false;
    double time_limit_s = 0;  ///< of the whole command; 0: none
    CLI::Option* spp_option = nullptr;
    CLI::Option* camera_option = nullptr;
    std::vector<CLI::Option*> view_options;
    RenderSettings settings;
};

// All that is read before the first ray.
struct Inputs {
    std::vector<Material> materials;
    Sky sky;
    std::optional<Sun> declared_sun;  ///< of the sky map, even if its disc is left out
    Scene scene;
    std::vector<int> paints;
    std::vector<double> wavelengths_nm;
    Camera camera;
    Labels labels;
};

/// Throws Error when a file cannot be read or they do not fit together; notes go to stderr.
Inputs read_inputs(const RenderOptions& options);

/// "zenith 30, azimuth 0 degrees, orthographic": what the options say of the view.
std::string view_text(const RenderOptions& options);

/// A note on stderr, unless the run is quiet.
void warn(const RenderOptions& options, const std::string& text);

}  // namespace malus::cli
