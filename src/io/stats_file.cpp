// stats_file.cpp — the numbers of a render as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/stats_file.h"

#include <sys/resource.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "malus/io/file.h"
#include "malus/optics/wavelengths.h"

namespace malus {

ErrorSummary summarize_error(const Film& film, std::size_t wavelength) {
    double s0 = 0, p2 = 0, lit = 0;
    std::vector<double> dolp_errors;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        if (!(film.coverage[i] > 0)) continue;
        const PixelStokes& pixel = film.at(i, wavelength);
        dolp_errors.push_back(stderr_dolp(pixel));
        p2 += sqr(dolp_errors.back());
        if (!(pixel.mean.s0 > 0)) continue;
        s0 += static_cast<double>(pixel.covariance[0]) / sqr(pixel.mean.s0);
        lit += 1;
    }
    if (dolp_errors.empty()) return {};
    const auto p95 = dolp_errors.begin() + static_cast<std::ptrdiff_t>(
                                               0.95 * static_cast<double>(dolp_errors.size() - 1));
    std::nth_element(dolp_errors.begin(), p95, dolp_errors.end());
    return {lit > 0 ? std::sqrt(s0 / lit) : 0,
            std::sqrt(p2 / static_cast<double>(dolp_errors.size())), *p95};
}

double peak_memory_mib() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

std::string refusal_warning(const RenderResult& result, std::uint64_t seed) {
    const RefusedSample& r = result.first_refused.front();
    return std::to_string(result.refused) + " of " + std::to_string(result.paths) +
           " samples were not finite or negative and were left out; first at pixel (" +
           std::to_string(r.x) + ',' + std::to_string(r.y) + "), replicate " +
           std::to_string(r.replicate) + ", sample " + std::to_string(r.sample) + ", seed " +
           std::to_string(seed) + "; please report it with the scene";
}

void write_stats(const std::filesystem::path& path, const RenderStats& stats,
                 const RenderResult& result) {
    using Json = nlohmann::ordered_json;
    const Film& film = result.film;
    Json json;
    json["version"] = stats.version;
    json["scene"] = stats.scene;
    json["wavelengths_nm"] = film.wavelengths_nm;
    json["width"] = film.width;
    json["height"] = film.height;
    json["spp"] = stats.spp;
    json["max_depth"] = stats.max_depth;
    json["seed"] = stats.seed;
    json["threads"] = stats.threads;
    json["wall_s"] = {{"load", stats.load_s},
                      {"build", stats.build_s},
                      {"render", stats.render_s},
                      {"write", stats.write_s}};
    json["paths"] = result.paths;
    json["rays"] = result.rays;
    json["rays_per_s"] =
        stats.render_s > 0 ? static_cast<double>(result.rays) / stats.render_s : 0.0;
    json["rejected_samples"] = result.refused;
    json["rejected"] = Json::array();
    for (const RefusedSample& r : result.first_refused)
        json["rejected"].push_back(
            {{"x", r.x}, {"y", r.y}, {"replicate", r.replicate}, {"sample", r.sample}});
    json["sky_grid"] = {{"cells", stats.sky.cells},
                        {"rms_S0_relative", stats.sky.rms_s0},
                        {"largest_S0_relative", stats.sky.largest_s0},
                        {"rms_DoLP", stats.sky.rms_dolp},
                        {"largest_DoLP", stats.sky.largest_dolp}};
    json["peak_memory_mib"] = peak_memory_mib();
    for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w) {
        const ErrorSummary error = summarize_error(film, w);
        json["error"][to_text(film.wavelengths_nm[w])] = {
            {"rms_S0_relative", error.rms_s0_relative},
            {"rms_DoLP", error.rms_dolp},
            {"p95_DoLP", error.p95_dolp}};
    }
    json["stopped_by"] = stats.stopped_by;
    // Names from files may hold bytes that are not UTF-8; they are replaced, not refused.
    write_text(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace malus
