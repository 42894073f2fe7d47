// detect.cpp — malus detect: in which channel a target stands out most from its background.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/detection.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>

#include "cli/commands.h"
#include "cli/detect_output.h"
#include "cli/gnuplot.h"
#include "cli/image_options.h"
#include "cli/validators.h"
#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

struct DetectOptions {
    std::string image, csv, json, png;
    DetectChoice choice;
    std::vector<double> wavelengths_nm;
    bool quiet = false;
};

struct Masks {
    Mask target, background;
};

constexpr const char* kRadiance = "W m^-2 sr^-1 nm^-1";
constexpr std::array<std::pair<const char*, const char*>, 7> kChannels{{{"S0", kRadiance},
                                                                        {"DoLP", "1"},
                                                                        {"AoLP", "degrees"},
                                                                        {"S1", kRadiance},
                                                                        {"S2", kRadiance},
                                                                        {"S1/S0", "1"},
                                                                        {"S2/S0", "1"}}};

void check_usage(const DetectOptions& options) {
    const DetectChoice& choice = options.choice;
    if (choice.target_nodes.empty() && choice.target_materials.empty())
        throw CLI::RequiredError("--target or --target-material");
    if (!choice.ring.empty() && !(choice.ring[0] < choice.ring[1]))
        throw CLI::ValidationError("--ring", "the inner distance is not below the outer one");
    if (!choice.ring.empty() && choice.ring[1] <= choice.border)
        throw CLI::ValidationError(
            "--ring", "ends where --border (" + to_text(choice.border) +
                          " pixels) leaves out what is next to the target; widen it beyond that");
}

void check_outputs(const DetectOptions& options) {
    malus::check_outputs({options.image}, {options.csv, options.json, options.png});
    if (!options.png.empty()) check_gnuplot();
}

void add(Mask& all, const Mask& more) {
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = all[i] || more[i];
}

// Pixels of any of these.
Mask named(const Image& image, const std::vector<std::string>& nodes,
           const std::vector<std::string>& materials) {
    Mask all(image.pixel_count(), 0);
    for (const std::string& name : nodes) add(all, node_mask(image, name));
    for (const std::string& name : materials) add(all, material_mask(image, name));
    return all;
}

Mask covered(const Image& image, double share) {
    const auto coverage = image.channels.find("A");
    Mask mask(image.pixel_count(), 1);
    if (coverage != image.channels.end())
        for (std::size_t i = 0; i < mask.size(); ++i)
            mask[i] = static_cast<double>(coverage->second[i]) >= share;
    return mask;
}

// What is left of a mask's `before` pixels is enough for a mean and a spread.
void check_enough(const char* what, const Mask& mask, std::size_t before,
                  const DetectChoice& choice) {
    if (count(mask) >= 2) return;
    throw Error(std::string("the ") + what + " keeps " + std::to_string(count(mask)) + " of " +
                std::to_string(before) + " pixels (--border " + to_text(choice.border) +
                " and --min-coverage " + to_text(choice.min_coverage) +
                (choice.ring.empty() ? "" : ", --ring") +
                " leave out the others), and needs two; lower them or render more pixels");
}

Masks masks_of(const Image& image, const DetectChoice& choice) {
    const Mask target = named(image, choice.target_nodes, choice.target_materials);
    if (count(target) == 0)
        throw Error(
            "no pixel shows the target (out of view, hidden, or smaller than a pixel); name "
            "another --target, or render it larger");
    const bool named_background =
        !choice.background_nodes.empty() || !choice.background_materials.empty();
    const Mask background = without(
        named_background ? named(image, choice.background_nodes, choice.background_materials)
                         : surface_mask(image),
        target);
    if (count(background) == 0)
        throw Error(named_background
                        ? "no pixel shows the background but those of the target; name another "
                          "--background"
                        : "no pixel is left for the background (the target covers all surfaces "
                          "in view); name a part of it as --target");
    const Mask allowed = covered(image, choice.min_coverage);
    const auto kept = [&](const Mask& mask) {
        return both(allowed, inside(mask, image.width, image.height, choice.border));
    };
    Masks masks{kept(target), kept(background)};
    if (!choice.ring.empty())
        masks.background = both(masks.background, ring_around(target, image.width, image.height,
                                                              choice.ring[0], choice.ring[1]));
    check_enough("target", masks.target, count(target), choice);
    check_enough("background", masks.background, count(background), choice);
    return masks;
}

std::vector<DetectChannel> detect_channels(const Image& image, const Masks& masks,
                                           const std::vector<double>& wavelengths_nm,
                                           bool debiased) {
    std::optional<Film> film;
    if (debiased) film = film_for_debias(image);
    std::vector<DetectChannel> channels;
    for (double nm : wavelengths_nm)
        for (const auto& [name, unit] : kChannels) {
            Quantity quantity = read_quantity(image, name, nm);
            if (film && quantity.name == "DoLP") debias(quantity, *film);
            const Mask known = quantity.name == "AoLP" ? aolp_known(image, nm) : Mask();
            channels.push_back(
                {name, unit, nm, detect(quantity, masks.target, masks.background, known)});
        }
    rank(channels);
    return channels;
}

DetectReport report_of(const DetectOptions& options) {
    const Image image = read_exr(options.image);
    try {
        const std::vector<double> wavelengths_nm = wavelengths_of(image, options.wavelengths_nm);
        const Masks masks = masks_of(image, options.choice);
        return {options.image,
                options.choice,
                count(masks.target),
                count(masks.background),
                wavelengths_nm,
                detect_channels(image, masks, wavelengths_nm, options.choice.debias)};
    } catch (const Error& problem) {
        throw Error(options.image + ": " + problem.what());
    }
}

void drop_repeated(std::vector<std::string>& names) {
    std::vector<std::string> once;
    for (const std::string& name : names)
        if (std::find(once.begin(), once.end(), name) == once.end()) once.push_back(name);
    names = once;
}

void detect_target(DetectOptions& options) {
    DetectChoice& choice = options.choice;
    for (auto* names : {&choice.target_nodes, &choice.target_materials, &choice.background_nodes,
                        &choice.background_materials})
        drop_repeated(*names);
    check_usage(options);
    check_outputs(options);
    const DetectReport report = report_of(options);
    if (!options.csv.empty()) write_text(options.csv, detect_csv(report));
    if (!options.json.empty()) write_text(options.json, detect_json(report));
    if (!options.png.empty()) {
        const DetectPlot plot = detect_plot(report);
        plot_png(options.png, plot.width, plot.height, plot.commands);
    }
    if (!options.quiet) std::fputs(detect_table(report).c_str(), stdout);
}

void add_pixel_options(CLI::App& sub, DetectChoice& choice) {
    sub.add_option("--target", choice.target_nodes,
                   "Node of the scene, with all below it, that is the target; repeatable")
        ->allow_extra_args(false);
    sub.add_option("--target-material", choice.target_materials,
                   "Material whose pixels are the target, besides those of --target; repeatable")
        ->allow_extra_args(false);
    sub.add_option("--background", choice.background_nodes,
                   "Node, with all below it, that is the background; repeatable [default: every "
                   "surface that is not the target]")
        ->allow_extra_args(false);
    sub.add_option("--background-material", choice.background_materials,
                   "Material whose pixels are the background, besides those of --background; "
                   "repeatable")
        ->allow_extra_args(false);
    sub.add_option("--ring", choice.ring,
                   "INNER,OUTER: of the background only pixels farther than INNER from the "
                   "target's nearest pixel and at most OUTER, pixels, e.g. 2,20; OUTER must exceed "
                   "--border [default: all]")
        ->delimiter(',')
        ->expected(2)
        ->check(within(0, 1e6));
    sub.add_option("--border", choice.border,
                   "Pixels left out of target and background along their outlines, since they may "
                   "show a mixture; 0 keeps all")
        ->check(within(0, 1e6))
        ->capture_default_str();
    sub.add_option("--min-coverage", choice.min_coverage,
                   "Pixels are left out that show a surface in less than this share of their area, "
                   "0 to 1; the rest of it is sky")
        ->check(within(0, 1))
        ->capture_default_str();
}

}  // namespace

void add_detect(CLI::App& app) {
    CLI::App* sub = app.add_subcommand(
        "detect",
        "Say in which channel a target stands out most from its background: means, contrast, "
        "signal-to-clutter and Fisher ratio, Bhattacharyya distance and the area under the ROC "
        "curve of S0, DoLP, AoLP, S1, S2, S1/S0 and S2/S0 at each wavelength. An area of 1 or 0 "
        "tells all pixels of the target from all of the background (the target is higher or "
        "lower), 0.5 none. Its standard error takes pixels for independent; in a picture "
        "neighbours are alike, so that the true one is larger. AoLP goes round the circle: its "
        "ROC is of how far a pixel lies from the background's mean direction. Noise is the "
        "share of the variance within target and background that the image's error bars explain: "
        "where it is large, more samples would tell more");
    const auto options = std::make_shared<DetectOptions>();
    sub->add_option("image", options->image, "Image of malus render or malus merge, EXR")
        ->required();
    add_pixel_options(*sub, options->choice);
    add_wavelengths(*sub, options->wavelengths_nm,
                    "Wavelengths to compare, nm, e.g. 440,600 [default: all]");
    sub->add_flag("--debias", options->choice.debias,
                  "Take from each pixel's DoLP what noise adds to it on average (MAS estimate, "
                  "Plaszczynski et al. 2014), whatever the image has");
    sub->add_option("--csv", options->csv, "Write the table to this file, a line a channel");
    sub->add_option("--json", options->json,
                    "Write the same to this file, with the points of the ROC curves");
    sub->add_option("--png", options->png,
                    "Draw the ROC curves to this file, a square a wavelength (needs gnuplot)");
    sub->add_flag("--quiet", options->quiet, "No table on standard output");
    sub->callback([options] { detect_target(*options); });
}

}  // namespace malus::cli
