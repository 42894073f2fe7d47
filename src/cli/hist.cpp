// hist.cpp — malus hist: histograms of an image's quantities, and how much of their width is noise.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "cli/commands.h"
#include "cli/gnuplot.h"
#include "cli/hist_output.h"
#include "cli/image_options.h"
#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/optics/wavelengths.h"

namespace malus::cli {
namespace {

struct HistOptions {
    std::vector<std::string> images, quantities{"S0", "DoLP", "AoLP"}, nodes, materials;
    std::vector<double> wavelengths_nm, range;
    std::size_t bins = 100;
    std::string csv, json, png;
    bool density = false, debias = false, noise = false, quiet = false;
};

struct Region {
    std::string name;
    Mask mask;
};

std::vector<Region> regions_of(const Image& image, const HistOptions& options) {
    std::vector<Region> regions;
    for (const std::string& name : options.nodes)
        regions.push_back({"node " + name, node_mask(image, name)});
    for (const std::string& name : options.materials)
        regions.push_back({"material " + name, material_mask(image, name)});
    if (regions.empty())
        regions.push_back(
            {image.channels.count("A") ? "surfaces" : "all pixels", surface_mask(image)});
    return regions;
}

// What --quantity may name.
std::vector<std::string> known_quantities(const Image& image) {
    std::vector<std::string> known{"S0",   "S1",    "S2",    "S3",   "DoLP",
                                   "AoLP", "S1/S0", "S2/S0", "S3/S0"};
    for (const auto& [channel, values] : image.channels) {
        const auto spectral = parse_spectral_channel(channel);
        known.push_back(spectral ? spectral->quantity : channel);
    }
    return known;
}

bool is_plain(const Image& image, const std::string& name) {
    return image.channels.count(name) && !parse_spectral_channel(name);
}

// A channel of no wavelength.
Quantity plain_channel(const Image& image, const std::string& name) {
    return {name, 0, image.channels.at(name), {}, 0};
}

// All that is asked for of one image, in the order of the panels.
std::vector<Quantity> quantities_of(const Image& image, const HistOptions& options) {
    std::optional<Film> film;
    if (options.debias) film = film_for_debias(image);
    const std::vector<double> wavelengths_nm = wavelengths_of(image, options.wavelengths_nm);
    const std::vector<std::string> known = known_quantities(image);
    std::vector<Quantity> all;
    for (const std::string& name : options.quantities) {
        if (std::find(known.begin(), known.end(), name) == known.end())
            throw Error("no quantity '" + one_line(name) + "'" + suggest(name, known));
        if (is_plain(image, name)) {
            all.push_back(plain_channel(image, name));
            continue;
        }
        for (double nm : wavelengths_nm) {
            all.push_back(read_quantity(image, name, nm));
            if (film && name == "DoLP") debias(all.back(), *film);
        }
    }
    return all;
}

Series series_of(const Quantity& q, const Region& region, const std::string& path,
                 const HistOptions& options) {
    Series s;
    s.image = path;
    s.region = region.name;
    for (std::size_t i = 0; i < q.value.size(); ++i)
        if (region.mask[i]) s.values.push_back(q.value[i]);
    s.spread = spread(q.value, region.mask, q.period);
    if (!options.noise) return s;
    if (!q.error.empty())
        s.noise = noise_share(q.value, q.error, region.mask, q.period, unknown_error(q));
    return s;
}

// Adds the series of one image to the panels, which the first image makes.
void add_image(std::vector<HistPanel>& panels, const std::string& path, HistOptions& options) {
    const Image image = read_exr(path);
    const std::vector<Region> regions = regions_of(image, options);
    for (const Region& region : regions)
        if (count(region.mask) == 0)
            throw Error("no pixel shows " + one_line(region.name) + "; name another");
    const std::vector<Quantity> quantities = quantities_of(image, options);
    if (panels.empty()) {
        for (const Quantity& q : quantities) panels.push_back({q.name, q.wavelength_nm, q.period});
        // What the first image has is asked of the others.
        options.wavelengths_nm = wavelengths_of(image, options.wavelengths_nm);
    }
    for (std::size_t p = 0; p < panels.size(); ++p)
        for (const Region& region : regions)
            panels[p].series.push_back(series_of(quantities[p], region, path, options));
}

std::vector<HistPanel> read_panels(HistOptions options) {
    std::vector<HistPanel> panels;
    for (const std::string& path : options.images) try {
            add_image(panels, path, options);
        } catch (const Error& problem) {
            const std::string what = problem.what();
            throw Error(what.starts_with(path) ? what : path + ": " + what);
        }
    return panels;
}

// From the 0.1th to the 99.9th percentile of all series together, so that a stray value does not
// put all others into one bin.
Bins percentile_bins(const HistPanel& panel, std::size_t count) {
    std::vector<float> all;
    for (const Series& s : panel.series)
        for (float x : s.values)
            if (std::isfinite(x)) all.push_back(x);
    if (all.empty()) throw Error(panel.title() + ": no number to count; choose another --quantity");
    const auto at = [&](double share) {
        const auto nth = all.begin() + std::lround(share * static_cast<double>(all.size() - 1));
        std::nth_element(all.begin(), nth, all.end());
        return double{*nth};
    };
    const double low = at(0.001), high = at(0.999);
    if (high > low) return {low, high, count};
    const double room = low == 0 ? 0.5 : std::abs(low) / 2;  // all alike
    return {low - room, high + room, count};
}

void choose_bins(HistPanel& panel, const HistOptions& options) {
    panel.range_from = options.range.empty() ? "fixed" : "asked";
    if (!options.range.empty()) {
        panel.bins = {options.range[0], options.range[1], options.bins};
    } else if (panel.period > 0) {
        panel.bins = {0, panel.period, options.bins};
    } else if (panel.quantity == "DoLP" || panel.quantity == "A") {
        panel.bins = {0, 1, options.bins};
    } else {
        panel.bins = percentile_bins(panel, options.bins);
        panel.range_from = "percentiles 0.1 and 99.9";
    }
}

void check_usage(const HistOptions& options) {
    if (options.range.empty()) return;
    if (!(options.range[0] < options.range[1] && std::isfinite(options.range[0]) &&
          std::isfinite(options.range[1])))
        throw CLI::ValidationError("--range", "LOW must be below HIGH, both finite");
    if (options.quantities.size() > 1)
        throw CLI::ValidationError("--range", "it is of one quantity; name one with --quantity");
}

void check_outputs(const HistOptions& options) {
    malus::check_outputs({options.images.begin(), options.images.end()},
                         {options.csv, options.json, options.png});
    if (!options.png.empty()) check_gnuplot();
}

void check_errors_known(const std::vector<HistPanel>& panels) {
    for (const HistPanel& panel : panels)
        for (const Series& s : panel.series)
            if (!s.noise)
                throw Error(s.image + ": --noise: no error of " + panel.title() +
                            " is known; leave --noise out, or ask for S0 to S3, DoLP, AoLP, S1/S0 "
                            "or S2/S0 of an image that malus rendered");
}

void hist(const HistOptions& options) {
    check_usage(options);
    check_outputs(options);
    std::vector<HistPanel> panels = read_panels(options);
    if (options.noise) check_errors_known(panels);
    for (HistPanel& panel : panels) {
        choose_bins(panel, options);
        for (Series& s : panel.series)
            s.histogram = histogram(s.values, Mask(s.values.size(), 1), panel.bins, panel.period);
    }
    if (!options.csv.empty()) write_text(options.csv, hist_csv(panels));
    if (!options.json.empty()) write_text(options.json, hist_json(panels, options.debias));
    if (!options.png.empty())
        plot_hist(options.png, panels, options.density ? Height::kDensity : Height::kShare);
    if (!options.quiet) std::fputs(hist_text(panels).c_str(), stdout);
}

}  // namespace

void add_hist(CLI::App& app) {
    CLI::App* sub = app.add_subcommand(
        "hist",
        "Histograms of quantities of one or more images, of all that shows a surface or by node "
        "and "
        "material, with middle, width and, on demand, the share of the width that is noise; "
        "between "
        "two and more their distances. Prints a table; bins go to --csv, --json and --png");
    const auto options = std::make_shared<HistOptions>();
    sub->add_option("images", options->images,
                    "Images or sky maps, EXR; several are overlaid and need not be of one size")
        ->required();
    sub->add_option(
           "--quantity", options->quantities,
           "S0 to S3 (W m^-2 sr^-1 nm^-1), DoLP (0 to 1), AoLP (degrees), S1/S0, S2/S0, "
           "S3/S0 or a channel such as StdErr_DoLP, Z (m), A, N.samples; several with commas "
           "[default: S0,DoLP,AoLP]")
        ->delimiter(',')
        ->allow_extra_args(false);
    add_wavelengths(*sub, options->wavelengths_nm,
                    "Wavelengths, nm, e.g. 440,600 [default: all of the first image]");
    sub->add_option("--node", options->nodes,
                    "A series of the pixels that show this glTF node, or one below it; repeatable "
                    "[default: all pixels that show a surface]")
        ->allow_extra_args(false);
    sub->add_option("--material", options->materials,
                    "A series of the pixels that show this paint; repeatable")
        ->allow_extra_args(false);
    sub->add_option("--bins", options->bins, "Number of equal bins, 1 to 100000")
        ->check(CLI::Range(std::size_t{1}, std::size_t{100000}))
        ->capture_default_str();
    sub->add_option("--range", options->range,
                    "LOW,HIGH: the ends of the bins, in the quantity's unit; what lies outside is "
                    "counted [default: 0,1 for DoLP and A; 0,180 for AoLP; else the 0.1th and the "
                    "99.9th percentile of all series together]")
        ->delimiter(',')
        ->expected(2)
        ->allow_extra_args(false);
    sub->add_option("--csv", options->csv,
                    "Write a row a bin: quantity, wavelength_nm, image, region, low, high, count, "
                    "share, density");
    sub->add_option("--json", options->json, "Write counts, moments and distances");
    sub->add_option("--png", options->png,
                    "Draw a panel a quantity and wavelength, series overlaid (needs gnuplot)");
    sub->add_flag("--density", options->density,
                  "Draw shares per unit of the quantity instead of per bin");
    sub->add_flag("--debias", options->debias,
                  "Take from each pixel's DoLP what noise adds to it on average (MAS estimate, "
                  "Plaszczynski et al. 2014)");
    sub->add_flag(
        "--noise", options->noise,
        "Say how much of each width is noise: observed variance = variance of the truth + "
        "mean of the squared standard errors (of AoLP by circular statistics)");
    sub->add_flag("--quiet", options->quiet, "No table");
    sub->callback([options] { hist(*options); });
}

}  // namespace malus::cli
