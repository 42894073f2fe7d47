// stats_file.cpp — the numbers of a render as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/stats_file.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "malus/io/file.h"
#include "malus/optics/wavelengths.h"

namespace malus {

ErrorSummary summarize_error(const Film& film, std::size_t wavelength) {
    constexpr std::size_t kBlock = 64;
    std::array<std::array<float, kBlock>, kFilmQuantities> numbers;
    std::array<float*, kFilmQuantities> rows;
    for (std::size_t q = 0; q < kFilmQuantities; ++q) rows[q] = numbers[q].data();
    std::vector<double> s0, dolp;
    for (std::size_t at = 0; at < film.pixel_count(); at += kBlock) {
        const std::size_t end = std::min(at + kBlock, film.pixel_count());
        derive(film, wavelength, at, end, rows.data());
        for (std::size_t i = at; i < end; ++i) {
            if (!(film.coverage[i] > 0)) continue;
            dolp.push_back(rows[kErrorDolp][i - at]);
            const double light = film.at(i, wavelength).mean.s0;
            if (light > 0) s0.push_back(rows[kErrorS0][i - at] / light);
        }
    }
    const auto rms = [](const std::vector<double>& errors) {
        double squares = 0;
        for (double e : errors) squares += sqr(e);
        return errors.empty() ? 0 : std::sqrt(squares / static_cast<double>(errors.size()));
    };
    return {rms(s0), quantile(s0, 0.95), rms(dolp), quantile(dolp, 0.95)};
}

SampleCounts count_samples(const Film& film) {
    const auto [least, most] = std::minmax_element(film.samples.begin(), film.samples.end());
    double sum = 0;
    for (std::uint32_t n : film.samples) sum += n;
    return {*least, *most, sum / static_cast<double>(film.pixel_count())};
}

std::string to_text(StoppedBy why) {
    switch (why) {
        case StoppedBy::kSamples:
            return "spp";
        case StoppedBy::kTargetError:
            return "target-error";
        case StoppedBy::kTimeLimit:
            return "time-limit";
        case StoppedBy::kRequest:
            return "signal";
    }
    return {};
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
    json["replicates"] = result.exposure.replicates;
    const SampleCounts samples = count_samples(film);
    json["samples"] = {{"least", samples.least}, {"mean", samples.mean}, {"most", samples.most}};
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
            {"p95_S0_relative", error.p95_s0_relative},
            {"rms_DoLP", error.rms_dolp},
            {"p95_DoLP", error.p95_dolp}};
    }
    json["p95_error"] = error_of_most(film);
    if (stats.target_error > 0) json["target_error"] = stats.target_error;
    if (stats.time_limit_s > 0) json["time_limit_s"] = stats.time_limit_s;
    json["stopped_by"] = to_text(result.stopped_by);
    // Names from files may hold bytes that are not UTF-8; they are replaced, not refused.
    write_text(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace malus
