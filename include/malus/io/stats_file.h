// stats_file.h — what a render did, as JSON for programs and as a line for people.
//
// Keys    version, scene, wavelengths_nm, width, height, spp, max_depth, seed, threads,
//         wall_s {load, build, render, write}, paths, rays, rays_per_s, rejected_samples,
//         rejected [{x, y, replicate, sample}], peak_memory_mib,
//         sky_grid {cells, rms_S0_relative, largest_S0_relative, rms_DoLP, largest_DoLP}: what
//         resampling the sky changed (cells 0: the map itself was used),
//         error {"440": {rms_S0_relative, rms_DoLP, p95_DoLP}}, stopped_by.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "malus/render/render.h"

namespace malus {

/// Standard errors over the pixels that show a surface, at one wavelength.
struct ErrorSummary {
    double rms_s0_relative = 0;  ///< RMS of StdErr_S0 / S0 where S0 > 0
    double rms_dolp = 0;         ///< RMS of StdErr_DoLP
    double p95_dolp = 0;         ///< 95th percentile of StdErr_DoLP
};
ErrorSummary summarize_error(const Film& film, std::size_t wavelength);

struct RenderStats {
    std::string version, scene, stopped_by = "spp";
    std::uint32_t spp = 0;
    int max_depth = 0, threads = 0;
    std::uint64_t seed = 0;
    SkyResampling sky;
    double load_s = 0, build_s = 0, render_s = 0, write_s = 0;
};

/// What to tell a user whose render refused samples: how many, and the first with pixel and seed.
std::string refusal_warning(const RenderResult& result, std::uint64_t seed);

/// Largest resident size of this process so far, MiB.
double peak_memory_mib();

void write_stats(const std::filesystem::path& path, const RenderStats& stats,
                 const RenderResult& result);

}  // namespace malus
