// merge.cpp — malus merge: renders of different seeds to one image.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/merge.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <limits>

#include "cli/commands.h"
#include "cli/progress.h"
#include "cli/provenance.h"
#include "cli/render_output.h"
#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/io/film_image.h"

namespace malus::cli {
namespace {

struct MergeOptions {
    std::vector<std::string> images;
    std::string output;
    bool debias = false, compress = false, quiet = false;
};

using Attributes = std::map<std::string, Attribute>;

int spp_of(const Image& header) {
    const auto found = header.attributes.find("samplesPerPixel");
    const int* spp = found == header.attributes.end() ? nullptr : std::get_if<int>(&found->second);
    if (!spp) throw Error("the header has no samplesPerPixel");
    return *spp;
}

// What is known before the first pixel is read: that all belong together, and what becomes of their
// headers.
class Headers {
  public:
    void add(const std::string& path, const Image& header) {
        std::vector<std::string> seeds;
        try {
            seeds = seeds_of(header);
            spp_ += spp_of(header);
        } catch (const Error& problem) {
            throw Error(path + ": cannot be merged: " + problem.what() +
                        " (not written by malus render, or by an earlier version); name an image "
                        "that this version rendered");
        }
        if (path_of_seed_.empty())
            first_path_ = path, first_ = header, shared_ = header.attributes;
        else if (const std::string what = first_difference(header, first_); !what.empty())
            throw Error(path + ": it is of " + what + " than " + first_path_ +
                        "; merge renders of the same scene and options");
        for (const std::string& seed : seeds) {
            const auto [known, is_new] = path_of_seed_.emplace(seed, path);
            if (!is_new)
                throw Error(path + ": it has seed " + seed + " as " + known->second +
                            " has (the same random numbers); render it with another --seed");
            seeds_ += (seeds_.empty() ? "" : ", ") + seed;
        }
        if (const float* seconds = header.number("wallTime")) wall_time_s_ += *seconds;
        std::erase_if(shared_, [&](const auto& entry) {
            const auto other = header.attributes.find(entry.first);
            return other == header.attributes.end() || other->second != entry.second;
        });
    }

    // What all share, and what adds up.
    Attributes merged() const {
        Attributes all = shared_;
        all["seed"] = seeds_;
        all["samplesPerPixel"] =
            static_cast<int>(std::min<std::int64_t>(spp_, std::numeric_limits<int>::max()));
        all["wallTime"] = wall_time_s_;
        return all;
    }
    const std::string& seeds() const { return seeds_; }

  private:
    std::string first_path_, seeds_;
    Image first_;
    Attributes shared_;
    std::map<std::string, std::string> path_of_seed_;
    std::int64_t spp_ = 0;
    float wall_time_s_ = 0;
};

void check_output(const MergeOptions& options) {
    check_exr_name(options.output);
    check_writable(options.output);
    check_distinct(options.output, {options.images.begin(), options.images.end()});
}

Headers read_headers(const MergeOptions& options) {
    Headers headers;
    for (const std::string& path : options.images) headers.add(path, read_exr_header(path));
    return headers;
}

Film read_film(const std::string& path, Labels& labels) {
    const Image image = read_exr(path);
    try {
        return film_of(image, labels);
    } catch (const Error& problem) {
        throw Error(path + ": cannot be merged: " + problem.what() + "; render it anew");
    }
}

// The picture in a file is added to `film`; the first is taken as it is.
void add_picture(Film& film, Labels& labels, const std::string& path) {
    Film other = read_film(path, labels);
    if (film.width == 0) {
        film = std::move(other);
        return;
    }
    try {
        merge_into(film, other);
    } catch (const Error& problem) {
        throw Error(path + ": cannot be merged with the others: " + problem.what());
    }
}

void merge(const MergeOptions& options, const std::string& command_line) {
    check_output(options);
    const Headers headers = read_headers(options);
    Film film;
    Labels labels;
    {
        Progress progress("merging", options.quiet);
        double done = 0;
        for (const std::string& path : options.images) {
            add_picture(film, labels, path);
            progress.update(++done / static_cast<double>(options.images.size()));
        }
    }
    Image image =
        described(film, labels, options.debias ? DolpEstimator::kDebiased : DolpEstimator::kRaw);
    image.attributes.merge(headers.merged());
    image.attributes["commandLine"] = command_line;
    image.attributes["mergedFrom"] = options.images;
    write_exr(options.output, image, options.compress ? Compression::kZip : Compression::kNone);
    if (options.quiet) return;
    std::printf("%s: %zu images, seeds %s; %s, standard error (rms)%s\n", options.output.c_str(),
                options.images.size(), headers.seeds().c_str(), samples_text(film).c_str(),
                errors_text(film).c_str());
}

}  // namespace

void add_merge(CLI::App& app, const std::string& command_line) {
    CLI::App* sub = app.add_subcommand(
        "merge",
        "Combine renders of the same scene and options with different --seed into one image: means "
        "weighted by samples, pixel by pixel, and the standard errors of these means. The "
        "number of samples may differ");
    const auto options = std::make_shared<MergeOptions>();
    sub->add_option("images", options->images,
                    "Images of malus render or malus merge, EXR, two or more; none of their seeds "
                    "may stand twice")
        ->required()
        ->expected(-2);
    sub->add_option("-o,--output", options->output,
                    "Image to write, EXR: channels and units as of malus render, but nothing that "
                    "--resume could go on from")
        ->required();
    sub->add_flag("--debias", options->debias,
                  "Take from each pixel's DoLP what noise adds to it on average (MAS estimate, "
                  "Plaszczynski et al. 2014), whatever the images had; the Stokes vector stays as "
                  "it is");
    sub->add_flag("--compress", options->compress, kCompressHelp);
    sub->add_flag("--quiet", options->quiet, "No progress, no closing line");
    sub->callback([options, command_line] { merge(*options, command_line); });
}

}  // namespace malus::cli
