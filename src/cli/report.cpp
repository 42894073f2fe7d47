// report.cpp — malus report IMAGES: one page of HTML with all their numbers, to look at anywhere.
//
// The page (src/report/page.html) holds the channels as base64 of little-endian floats; it fetches
// nothing. S0 to S2, DoLP, AoLP and three errors take 43 bytes a pixel and wavelength.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <bit>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/image_options.h"
#include "malus/analysis/quantity.h"
#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/wavelengths.h"
#include "preview/color_maps.h"

namespace malus::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kPage =
#include "report_page.inc"
    ;
constexpr std::size_t kLargestPage = 512u << 20;  // bytes; what browsers still open

struct ReportOptions {
    std::vector<std::string> images;
    std::string output, title, intro, appendix;
    std::vector<double> wavelengths_nm;
    bool quiet = false;
};

std::string base64(const std::vector<float>& numbers) {
    static_assert(std::endian::native == std::endian::little);
    constexpr const char* kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::string_view bytes(reinterpret_cast<const char*>(numbers.data()), 4 * numbers.size());
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t three = 0;
        for (std::size_t k = 0; k < 3; ++k)
            three =
                three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            text += k <= bytes.size() - i ? kDigits[three >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

// What the page calls the directions from which angles are counted.
std::string aolp_zero(const Image& image) {
    const std::string* frame = image.text("stokesReferenceFrame");
    if (!frame) return "the file's own axis";
    return *frame == "image" ? "image right" : "the vertical plane";
}

std::string caption(const std::string& path, const Image& image) {
    std::string text = fs::path(path).filename().string() + ": " + std::to_string(image.width) +
                       " x " + std::to_string(image.height) + " pixels";
    for (const char* name : {"scene", "sky", "view"})
        if (const std::string* value = image.text(name)) text += ", " + one_line(*value);
    const auto spp = image.attributes.find("samplesPerPixel");
    if (spp != image.attributes.end() && std::holds_alternative<int>(spp->second))
        text += ", " + std::to_string(std::get<int>(spp->second)) + " samples a pixel";
    return text;
}

json names(const Image& image, const std::string& attribute) {
    const auto found = image.attributes.find(attribute);
    if (found == image.attributes.end()) return nullptr;
    const auto* list = std::get_if<std::vector<std::string>>(&found->second);
    if (!list) return nullptr;
    json all = json::array();
    for (const std::string& name : *list) all.push_back(one_line(name));
    return all;
}

json channels(const Image& image, const std::vector<double>& wavelengths_nm) {
    json all;
    for (const char* name : {"S0", "S1", "S2", "DoLP", "AoLP"})
        for (double nm : wavelengths_nm) {
            const Quantity quantity = read_quantity(image, name, nm);
            all[name].push_back(base64(quantity.value));
            if (name[0] != 'S' || name[1] == '0')
                if (!quantity.error.empty())
                    all["StdErr_" + std::string(name)].push_back(base64(quantity.error));
        }
    for (const char* name : {"A", "node.id", "material.id"})
        if (const auto found = image.channels.find(name); found != image.channels.end())
            all[name] = base64(found->second);
    return all;
}

json described(const std::string& path, const Image& image, const std::vector<double>& asked_nm) {
    const std::vector<double> wavelengths_nm = wavelengths_of(image, asked_nm);
    json texts = json::array();
    for (double nm : wavelengths_nm) texts.push_back(to_text(nm));
    return {{"name", fs::path(path).stem().string()},
            {"caption", caption(path, image)},
            {"width", image.width},
            {"height", image.height},
            {"wavelengths", texts},
            {"aolpZero", aolp_zero(image)},
            {"nodes", names(image, "nodeNames")},
            {"materials", names(image, "materialNames")},
            {"channels", channels(image, wavelengths_nm)}};
}

template <class ColorAt>
json color_table(ColorAt color_at) {
    json table = json::array();
    for (int i = 0; i < 256; ++i) {
        const preview::Color c = preview::to_color(preview::linear_rgb(color_at(i / 255.0)));
        for (int part : {c.r, c.g, c.b}) table.push_back(part);
    }
    return table;
}

json color_tables() {
    return {{"sequential", color_table([](double t) { return preview::sequential(t); })},
            {"cyclic", color_table([](double t) { return preview::cyclic(180 * t); })},
            {"diverging", color_table([](double t) { return preview::diverging(2 * t - 1); })}};
}

std::string html_text(const std::string& text) {
    std::string escaped;
    for (char c : text) switch (c) {
            case '&':
                escaped += "&amp;";
                break;
            case '<':
                escaped += "&lt;";
                break;
            case '>':
                escaped += "&gt;";
                break;
            default:
                escaped += c;
        }
    return escaped;
}

void replace_all(std::string& text, const std::string& place, const std::string& by) {
    for (std::size_t at = 0; (at = text.find(place, at)) != std::string::npos; at += by.size())
        text.replace(at, place.size(), by);
}

// Of a place that the page has once; what is put there is not searched.
void replace_one(std::string& page, const std::string& place, const std::string& by) {
    page.replace(page.find(place), place.size(), by);
}

std::string text_of(const std::string& file) {
    return file.empty() ? "" : read_text(file);
}

std::string page_of(const ReportOptions& options, const json& data) {
    std::string page = kPage;
    replace_all(page, "TITLE_TEXT", html_text(options.title));
    // No "</script>" inside a string may end the script.
    std::string text = data.dump(-1, ' ', false, json::error_handler_t::replace);
    replace_all(text, "<", "\\u003c");
    replace_one(page, "DATA_JSON", text);
    replace_one(page, "<!--APPENDIX-->", text_of(options.appendix));
    replace_one(page, "<!--INTRO-->", text_of(options.intro));
    return page;
}

void report(ReportOptions options) {
    if (options.output.empty()) {
        const fs::path first = options.images.front();
        options.output = (first.parent_path() / (first.stem().string() + "_report.html")).string();
    }
    if (options.title.empty())
        options.title = "malus: " + fs::path(options.images.front()).filename().string();
    options.title = one_line(options.title);
    check_writable(options.output);
    std::vector<fs::path> inputs(options.images.begin(), options.images.end());
    for (const std::string& file : {options.intro, options.appendix})
        if (!file.empty()) inputs.push_back(file);
    check_distinct(options.output, inputs);
    json data{{"colors", color_tables()}, {"images", json::array()}};
    std::size_t bytes = 0;
    for (const std::string& path : options.images) {
        const Image image = read_exr(path);
        try {
            bytes +=
                43 * image.pixel_count() * wavelengths_of(image, options.wavelengths_nm).size();
            if (bytes > kLargestPage)
                throw Error("the page would take more than " + std::to_string(kLargestPage >> 20) +
                            " MiB, too much for a browser; choose fewer images or --wavelengths");
            data["images"].push_back(described(path, image, options.wavelengths_nm));
        } catch (const Error& problem) {
            throw Error(path + ": " + problem.what());
        }
    }
    const std::string page = page_of(options, data);
    write_text(options.output, page);
    if (!options.quiet)
        std::printf("%s: a page of %.3g MB with %zu image%s; it needs no network\n",
                    options.output.c_str(), 1e-6 * static_cast<double>(page.size()),
                    options.images.size(), options.images.size() == 1 ? "" : "s");
}

}  // namespace

void add_report(CLI::App& app) {
    CLI::App* sub = app.add_subcommand(
        "report",
        "Make one HTML page of images: S0, DoLP, AoLP with values and errors under the pointer, "
        "histograms of regions; opens in any browser, without network");
    const auto options = std::make_shared<ReportOptions>();
    sub->add_option("images", options->images, "Images of malus render or malus merge, EXR")
        ->required();
    sub->add_option("-o,--output", options->output,
                    "Page to write [IMAGE_report.html beside the first image]");
    add_wavelengths(*sub, options->wavelengths_nm,
                    "Wavelengths to show, nm, e.g. 440,600 [all]; each takes 43 bytes a pixel");
    sub->add_option("--title", options->title, "Heading of the page [the first image's name]");
    sub->add_option("--intro", options->intro,
                    "File with HTML to put between heading and images (pictures as data: URIs)");
    sub->add_option("--appendix", options->appendix, "File with HTML to put after the images");
    sub->add_flag("--quiet", options->quiet, "No closing line");
    sub->callback([options] { report(*options); });
}

}  // namespace malus::cli
