// compare.cpp — malus compare: do two images, or two folders of images, differ?
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/compare.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "cli/commands.h"
#include "cli/image_options.h"
#include "cli/progress.h"
#include "cli/validators.h"
#include "malus/core/error.h"

namespace malus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct CompareOptions {
    std::string first, second, baseline;
    CompareSettings settings;
    bool json = false, quiet = false;
};

constexpr const char* kSame = "same";
constexpr const char* kDifferent = "different";

// NaN and infinity are no JSON.
Json number(double x) {
    return std::isfinite(x) ? Json(x) : Json();
}

Json position(std::size_t pixel, int width) {
    const auto w = static_cast<std::size_t>(width);
    return {{"x", pixel % w}, {"y", pixel / w}};
}

const char* text_of(Errors errors) {
    switch (errors) {
        case Errors::kNone:
            return "none";
        case Errors::kSameNumbers:
            return "same random numbers";
        case Errors::kShared:
            return "shared between pixels";
        case Errors::kIndependent:
            return "independent";
    }
    return "";
}

Json json_of(const QuantityComparison& q, int width) {
    const HistogramDistances& h = q.histograms;
    Json all{{"quantity", q.name},
             {"wavelength_nm", q.wavelength_nm},
             {"differs", !q.problems.empty()},
             {"pixels", q.pixels},
             {"largest", number(q.largest)},
             {"largest_at", position(q.largest_at, width)},
             {"rms", number(q.rms)},
             {"z_rms", number(q.z_rms)},
             {"beyond_3_errors", number(q.beyond_three)}};
    if (q.limit > 0)
        all["pixel_test"] = {
            {"t", number(q.t)}, {"limit", number(q.limit)}, {"at", position(q.t_at, width)}};
    if (q.region)
        all["region_test"] = {{"material", q.region->material},
                              {"x", q.region->x},
                              {"y", q.region->y},
                              {"width", q.region->width},
                              {"height", q.region->height},
                              {"pixels", q.region->pixels},
                              {"relative", number(q.region->relative)},
                              {"t", number(q.region->t)},
                              {"limit", number(q.region->limit)}};
    all["histograms"] = {
        {"correlation", number(h.correlation)},           {"chi_square", number(h.chi_square)},
        {"intersection", number(h.intersection)},         {"hellinger", number(h.hellinger)},
        {"kullback_leibler", number(h.kullback_leibler)}, {"earth_movers", number(h.earth_movers)}};
    all["problems"] = q.problems;
    return all;
}

Json json_of(const Comparison& c, int width) {
    Json all{{"verdict", c.alike() ? kSame : kDifferent},
             {"problem", c.problem()},
             {"errors", text_of(c.errors)},
             {"tests", c.tests},
             {"notes", c.notes}};
    for (const QuantityComparison& q : c.quantities) all["quantities"].push_back(json_of(q, width));
    return all;
}

// Names of files and paints need not be UTF-8.
void print_json(const Json& json) {
    std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

// "-" for what is not known.
std::string cell(const char* form, double x) {
    std::array<char, 64> text;
    std::snprintf(text.data(), text.size(), form, x);
    return std::isnan(x) ? "-" : text.data();
}

std::string ratio_text(double t, double limit) {
    std::array<char, 64> text;
    std::snprintf(text.data(), text.size(), "%6.3g (%.3g)", t, limit);
    return text.data();
}

void print_table(const Comparison& c, int width) {
    const auto w = static_cast<std::size_t>(width);
    std::printf("%-5s %8s %8s %10s %11s %10s %7s %6s  %-15s %-15s\n", "", "nm", "pixels", "largest",
                "at", "RMS", "> 3 SE", "z RMS", "pixel t (limit)", "region t (limit)");
    for (const QuantityComparison& q : c.quantities) {
        const std::string at =
            std::to_string(q.largest_at % w) + "," + std::to_string(q.largest_at / w);
        std::printf("%-5s %8s %8zu %10.3g %11s %10.3g", q.name.c_str(),
                    to_text(q.wavelength_nm).c_str(), q.pixels, q.largest,
                    q.largest > 0 ? at.c_str() : "-", q.rms);
        if (q.limit > 0)
            std::printf(" %7s %6s  %-15s", cell("%.2f %%", 100 * q.beyond_three).c_str(),
                        cell("%.2f", q.z_rms).c_str(), ratio_text(q.t, q.limit).c_str());
        if (q.region) std::printf(" %s", ratio_text(q.region->t, q.region->limit).c_str());
        std::printf("%s\n", q.problems.empty() ? "" : "  DIFFERS");
    }
}

void print_histograms(const Comparison& c) {
    std::printf("\n%-5s %8s %11s %10s %12s %9s %9s %12s\n", "", "nm", "correlation", "chi-square",
                "intersection", "Hellinger", "KL", "earth mover");
    for (const QuantityComparison& q : c.quantities) {
        const HistogramDistances& h = q.histograms;
        std::printf("%-5s %8s %11.4f %10.4g %12.4f %9.4f %9.4g %12.4g\n", q.name.c_str(),
                    to_text(q.wavelength_nm).c_str(), h.correlation, h.chi_square, h.intersection,
                    h.hellinger, h.kullback_leibler, h.earth_movers);
    }
}

// One line: the verdict and its first reason.
std::string verdict(const Comparison& c, double rate) {
    if (!c.alike()) return std::string(kDifferent) + ": " + c.problem();
    if (c.tests > 0)
        return std::string(kSame) + ": nothing beyond the error bars (" + std::to_string(c.tests) +
               " tests, false-alarm rate of all together " + to_text(rate) + ")";
    if (c.errors == Errors::kSameNumbers)
        return std::string(kSame) + ": nothing beyond rounding, as the same seed should give";
    return std::string(kSame) + ": nothing beyond the limits";
}

Comparison compare_files(const std::string& a, const std::string& b,
                         const CompareSettings& settings, int& width) {
    const Image first = read_exr(a), second = read_exr(b);
    width = first.width;
    try {
        return compare(first, second, settings);
    } catch (const Error& problem) {
        throw Error(b + " (second image): cannot be compared with " + a +
                    " (first image): " + problem.what());
    }
}

int compare_two(const CompareOptions& options) {
    int width = 0;
    const Comparison c = compare_files(options.first, options.second, options.settings, width);
    const int code = c.alike() ? 0 : kDifference;
    if (options.quiet && !options.json) return code;
    if (options.json) {
        print_json(json_of(c, width));
        return code;
    }
    print_table(c, width);
    print_histograms(c);
    std::printf("\n");
    for (const std::string& note : c.notes) std::printf("note: %s\n", note.c_str());
    std::printf("%s\n", verdict(c, options.settings.false_alarm_rate).c_str());
    return code;
}

std::set<std::string> images_in(const std::string& folder) {
    std::error_code failure;
    std::set<std::string> names;
    for (fs::directory_iterator at(folder, failure), end; !failure && at != end;
         at.increment(failure))
        if (at->path().extension() == ".exr" && at->is_regular_file())
            names.insert(at->path().filename().string());
    if (failure)
        throw Error(folder + ": cannot be read as a folder (" + failure.message() +
                    "); name a folder of images, EXR");
    return names;
}

// A row of the table of a folder.
struct FileVerdict {
    std::string name, verdict;
    bool alike = false;
    Json details;
};

FileVerdict compare_named(const CompareOptions& options, const CompareSettings& settings,
                          const std::string& name, bool rendered, bool reference) {
    if (!rendered) return {name, "missing among the renders", false, {}};
    if (!reference) return {name, "no reference of this name", false, {}};
    try {
        int width = 0;
        const Comparison c =
            compare_files((fs::path(options.first) / name).string(),
                          (fs::path(options.baseline) / name).string(), settings, width);
        return {name, verdict(c, settings.false_alarm_rate), c.alike(), json_of(c, width)};
    } catch (const Error& problem) {
        return {name, problem.what(), false, {}};
    }
}

std::vector<FileVerdict> compare_folders(const CompareOptions& options) {
    const std::set<std::string> renders = images_in(options.first),
                                references = images_in(options.baseline);
    std::set<std::string> names = renders;
    names.insert(references.begin(), references.end());
    if (references.empty())
        throw Error(options.baseline + ": holds no image (*.exr); name the folder of references");
    CompareSettings settings = options.settings;
    settings.false_alarm_rate /= static_cast<double>(names.size());
    Progress progress("comparing", options.quiet || options.json);
    std::vector<FileVerdict> verdicts;
    for (const std::string& name : names) {
        verdicts.push_back(compare_named(options, settings, name, renders.count(name) > 0,
                                         references.count(name) > 0));
        progress.update(static_cast<double>(verdicts.size()) / static_cast<double>(names.size()));
    }
    return verdicts;
}

int compare_with_baseline(const CompareOptions& options) {
    const std::vector<FileVerdict> verdicts = compare_folders(options);
    const auto differing = static_cast<std::size_t>(std::count_if(
        verdicts.begin(), verdicts.end(), [](const FileVerdict& v) { return !v.alike; }));
    const int code = differing == 0 ? 0 : kDifference;
    if (options.json) {
        Json all{{"verdict", differing == 0 ? kSame : kDifferent},
                 {"differing", differing},
                 {"files", Json::array()}};
        for (const FileVerdict& v : verdicts)
            all["files"].push_back({{"file", v.name},
                                    {"verdict", v.alike ? kSame : kDifferent},
                                    {"why", v.verdict},
                                    {"comparison", v.details}});
        print_json(all);
        return code;
    }
    if (options.quiet) return code;
    std::size_t widest = 0;
    for (const FileVerdict& v : verdicts) widest = std::max(widest, v.name.size());
    for (const FileVerdict& v : verdicts)
        std::printf("%-*s  %s\n", static_cast<int>(widest), v.name.c_str(), v.verdict.c_str());
    std::printf("%s: %zu of %zu images differ from %s\n", differing == 0 ? kSame : kDifferent,
                differing, verdicts.size(), options.baseline.c_str());
    return code;
}

int compare_what(const CompareOptions& options) {
    const CompareSettings& s = options.settings;
    if (!(s.false_alarm_rate > 0) && !s.most_relative && !s.most_dolp && !s.most_aolp_deg &&
        !s.most_hellinger)
        throw CLI::ValidationError("--false-alarm-rate",
                                   "0 leaves nothing to judge by; give a limit, e.g. --max-dolp");
    if (!options.baseline.empty()) {
        if (!options.second.empty())
            throw CLI::ValidationError("--baseline", "takes one folder of renders, not two images");
        return compare_with_baseline(options);
    }
    if (fs::is_directory(options.first) || fs::is_directory(options.second))
        throw CLI::ValidationError("first", "compare folders with --baseline FOLDER");
    if (options.second.empty())
        throw CLI::ValidationError("second", "name two images, or one folder and --baseline");
    return compare_two(options);
}

void add_limits(CLI::App& sub, CompareSettings& settings) {
    sub.add_option(
           "--false-alarm-rate", settings.false_alarm_rate,
           "How often two honest renders may be called different, as a share of 1; over all "
           "tests of a comparison, or of a whole folder, together. 0: judge by the limits "
           "below alone")
        ->check(within(0, 0.5))
        ->capture_default_str();
    const char* group = "Limits (of each pixel, unless it says otherwise; besides the error bars)";
    sub.add_option(
           "--max-relative", settings.most_relative,
           "Most that S0 to S3 may differ by, as a share of the larger S0, 1 (where that is "
           "below a thousandth of the picture's mean, of this thousandth) [none; 1e-5 "
           "where images have no error bars]")
        ->check(within(0, 1e9))
        ->group(group);
    sub.add_option("--max-dolp", settings.most_dolp,
                   "Most that DoLP may differ by, 0 to 1 [none; 1e-5 where images have no error "
                   "bars]")
        ->check(within(0, 1))
        ->group(group);
    sub.add_option(
           "--max-aolp", settings.most_aolp_deg,
           "Most that AoLP may differ by, degrees, the shorter way round [none; what 1e-5 of "
           "S0 turns it by where images have no error bars]")
        ->check(within(0, 90))
        ->group(group);
    sub.add_option(
           "--max-hellinger", settings.most_hellinger,
           "Most that the histograms of any quantity may lie apart by Hellinger's distance, "
           "0 to 1 [none]")
        ->check(within(0, 1))
        ->group(group);
}

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand(
        "compare",
        "Say whether two images differ by more than their error bars: differences, z-scores and "
        "distances of histograms for S0 to S3, DoLP and AoLP at each wavelength, and a verdict. "
        "Exit 0: same; 3: different");
    const auto options = std::make_shared<CompareOptions>();
    sub->add_option("first", options->first, "Image, EXR; with --baseline a folder of images")
        ->required();
    sub->add_option("second", options->second, "Image to compare it with, EXR");
    sub->add_option(
        "--baseline", options->baseline,
        "Folder of references: compare each image (*.exr) of the folder before with the "
        "one of the same name here. What only one of both has is a difference");
    add_wavelengths(*sub, options->settings.wavelengths_nm,
                    "Wavelengths, nm, e.g. 440,600 [all; both images must have the same]");
    add_limits(*sub, options->settings);
    sub->add_flag("--json", options->json, "Print JSON instead of tables");
    sub->add_flag("--quiet", options->quiet, "Print nothing but JSON; the exit code says it all");
    sub->callback([options, &exit_code] { exit_code = compare_what(*options); });
}

}  // namespace malus::cli
