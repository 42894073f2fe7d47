// stats_file.h — what a render did, as JSON for programs and as a line for people.
//
// Keys    version, scene, wavelengths_nm, width, height, spp, replicates, samples {least, mean,
//         most}: a pixel, max_depth, seed, threads, wall_s {load, build, render, write}, paths, rays,
//         rays_per_s, rejected_samples, rejected [{x, y, replicate, sample}], peak_memory_mib,
//         sky_grid {cells, rms_S0_relative, largest_S0_relative, rms_DoLP, largest_DoLP}: what
//         resampling the sky changed (cells 0: the map itself was used),
//         error {"440": {rms_S0_relative, p95_S0_relative, rms_DoLP, p95_DoLP}},
//         p95_error: error_of_most() (film.h), target_error, time_limit_s: where asked for,
//         stopped_by: spp, target-error, time-limit or signal.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "malus/render/render.h"

namespace malus {

/// Standard errors over the pixels that show a surface, at one wavelength.
struct ErrorSummary {
    double rms_s0_relative = 0;  ///< RMS of StdErr_S0 / S0 where S0 > 0
    double p95_s0_relative = 0;  ///< their 95th percentile
    double rms_dolp = 0;         ///< RMS of StdErr_DoLP
    double p95_dolp = 0;         ///< their 95th percentile
};
ErrorSummary summarize_error(const Film& film, std::size_t wavelength);

/// Samples a pixel.
struct SampleCounts {
    std::uint32_t least, most;
    double mean;
};
SampleCounts count_samples(const Film& film);

/// "spp", "target-error", "time-limit" or "signal".
std::string to_text(StoppedBy why);

struct RenderStats {
    std::string version, scene;
    std::uint32_t spp = 0;
    double target_error = 0, time_limit_s = 0;  ///< 0: none
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
