// render_output.cpp — from a result to the image, and to the line a person reads.
// SPDX-License-Identifier: Apache-2.0
#include "cli/render_output.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "cli/commands.h"
#include "cli/provenance.h"
#include "malus/core/error.h"
#include "malus/core/frame.h"
#include "malus/io/exposure_file.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

// Rows [first, first + count) of [pixel][per_pixel].
template <class Vector>
Vector rows_of(const Vector& all, std::size_t first, std::size_t count, std::size_t per_row) {
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first * per_row);
    return {begin, begin + static_cast<std::ptrdiff_t>(count * per_row)};
}

// The rows in the middle of the picture, as a picture of its own.
RenderResult middle_rows(const RenderResult& whole, int rows) {
    const Film& f = whole.film;
    const Exposure& e = whole.exposure;
    const auto first = static_cast<std::size_t>((f.height - rows) / 2);
    const auto count = static_cast<std::size_t>(rows), width = static_cast<std::size_t>(f.width);
    RenderResult part;
    part.film = Film(f.width, rows, f.wavelengths_nm);
    part.film.stokes = rows_of(f.stokes, first, count, width * f.wavelengths_nm.size());
    part.film.coverage = rows_of(f.coverage, first, count, width);
    part.film.distance = rows_of(f.distance, first, count, width);
    part.film.instance = rows_of(f.instance, first, count, width);
    part.film.samples = rows_of(f.samples, first, count, width);
    part.exposure = Exposure(f.width, rows, f.wavelengths_nm, e.replicates);
    part.exposure.stokes = rows_of(e.stokes, first, count, width * e.pixel_stride());
    return part;
}

std::string why_stopped(StoppedBy why) {
    switch (why) {
        case StoppedBy::kSamples:
            return "";
        case StoppedBy::kTargetError:
            return " (target error reached)";
        case StoppedBy::kTimeLimit:
            return " (time limit)";
        case StoppedBy::kRequest:
            return " (stopped by a signal)";
    }
    return {};
}

// For each of the header's nodeNames the place of its parent in that list; 0 is none.
std::vector<std::string> node_parents(const Scene& scene) {
    std::vector<std::string> places{"0"};
    for (const Node& node : scene.nodes) places.push_back(std::to_string(node.parent + 1));
    return places;
}

// Where the sun stands and from where the middle of the picture is seen, degrees.
void add_geometry(Image& header, const Inputs& inputs) {
    const auto set = [&](const char* name, double radians) {
        header.attributes[name] = static_cast<float>(to_degrees(radians));
    };
    if (inputs.declared_sun) {
        set("sunZenith", inputs.declared_sun->zenith);
        set("sunAzimuth", inputs.declared_sun->azimuth);
    }
    const Vec3 to_detector = -inputs.camera.forward;
    set("viewZenith", zenith_of(to_detector));
    set("viewAzimuth", azimuth_of(to_detector));
}

}  // namespace

std::string samples_text(const Film& film) {
    const SampleCounts n = count_samples(film);
    char text[96];
    if (n.least == n.most)
        std::snprintf(text, sizeof text, "%u samples a pixel", n.least);
    else
        std::snprintf(text, sizeof text, "%u to %u samples a pixel (mean %.0f)", n.least, n.most,
                      n.mean);
    return text;
}

std::string errors_text(const Film& film) {
    std::string errors;
    for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w) {
        const ErrorSummary error = summarize_error(film, w);
        char text[96];
        std::snprintf(text, sizeof text, "%s %s nm S0 %.2g %%, DoLP %.2g", w ? ";" : "",
                      to_text(film.wavelengths_nm[w]).c_str(), 100 * error.rms_s0_relative,
                      error.rms_dolp);
        errors += text;
    }
    return errors;
}

Image make_header(const RenderOptions& options, const Inputs& inputs,
                  const RenderSettings& settings, const std::string& command_line) {
    Image header;
    header.width = settings.width;
    header.height = settings.height;
    header.attributes["malusVersion"] = version();
    header.attributes["commandLine"] = command_line;
    header.attributes["seed"] = std::to_string(settings.seed);
    header.attributes["scene"] = options.scene;
    header.attributes["sky"] = options.sky;
    header.attributes["materials"] = options.materials;
    header.attributes["assign"] = options.assign;
    header.attributes["view"] = view_text(options);
    header.attributes["wavelengths"] = to_text(inputs.wavelengths_nm) + " nm";
    header.attributes["samplesPerPixel"] = static_cast<int>(settings.spp);
    header.attributes["maxDepth"] = settings.max_depth;
    header.attributes["skyTable"] = settings.sky_table ? 1 : 0;
    header.attributes["nodeParents"] = node_parents(inputs.scene);
    add_geometry(header, inputs);
    add_fingerprints(header, inputs);
    return header;
}

void write_image(const std::string& path, const RenderResult& result, const Labels& labels,
                 const RenderOptions& options, const Image& header) {
    Image image = described(result.film, labels,
                            options.debias ? DolpEstimator::kDebiased : DolpEstimator::kRaw);
    image.attributes.insert(header.attributes.begin(), header.attributes.end());
    image.attributes["stoppedBy"] = to_text(result.stopped_by);
    const Compression as = options.compress ? Compression::kZip : Compression::kNone;
    if (options.final) return write_exr(path, image, as);
    // The sums are the larger file, so they are tried first, and take their place last: what is on
    // the disk belongs together whatever fails.
    const std::filesystem::path fresh = sums_path(path).string() + ".new";
    try {
        write_exposure(fresh, result.exposure);
        image.attributes["sumsHash"] = fingerprint(result.exposure);
        write_exr(path, image, as);
        std::filesystem::rename(fresh, sums_path(path));
    } catch (const Error& problem) {
        std::error_code ignored;
        std::filesystem::remove(fresh, ignored);
        image.attributes.erase("sumsHash");
        write_exr(path, image, as);
        throw Error(std::string(problem.what()) + "; " + path +
                    " is whole, but --resume cannot go on");
    }
}

double seconds_to_write(const RenderResult& result, const Labels& labels,
                        const RenderOptions& options, const Image& header) {
    // Four blocks of 16 rows, which OpenEXR's threads share; the faster of two trials, since the
    // first also starts these threads.
    const int rows = std::min(64, result.film.height);
    const RenderResult part = middle_rows(result, rows);
    const std::string trial = options.output + ".trial.exr";
    double seconds = HUGE_VAL;
    for (int i = 0; i < 2; ++i) {
        const auto start = std::chrono::steady_clock::now();
        try {
            write_image(trial, part, labels, options, header);
        } catch (const Error&) {
            seconds = 0;  // then writing will say what is wrong
        }
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
        seconds = std::min(seconds, took.count());
    }
    std::error_code ignored;
    std::filesystem::remove(trial, ignored);
    std::filesystem::remove(sums_path(trial), ignored);
    return seconds * result.film.height / rows;
}

void tell_result(const RenderOptions& options, const RenderStats& stats,
                 const RenderResult& result) {
    // Said even in a quiet run: numbers may be missing.
    if (result.refused > 0)
        std::cerr << "malus: warning: " << refusal_warning(result, stats.seed) << '\n';
    if (result.stopped_by == StoppedBy::kRequest)
        std::cerr << "malus: note: stopped by a signal; " << options.output
                  << " is whole, with the error bars of the samples it has"
                  << (options.final ? "" : " (--resume goes on)") << '\n';
    if (options.quiet) return;
    std::printf(
        "%s: %.1f s%s, %s, %.2g million rays/s, standard error (rms)%s; %llu samples "
        "refused\n",
        options.output.c_str(), stats.render_s, why_stopped(result.stopped_by).c_str(),
        samples_text(result.film).c_str(),
        static_cast<double>(result.rays) / std::max(1e-9, stats.render_s) / 1e6,
        errors_text(result.film).c_str(), static_cast<unsigned long long>(result.refused));
}

}  // namespace malus::cli
