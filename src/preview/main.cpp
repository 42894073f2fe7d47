// main.cpp — malus-preview: PNG pictures of an image or of the sky, and a sheet of all.
//
// Called as `malus preview FILE …`: an image EXR, or a sky map as EXR (in the frame "meridian") or
// CSV, which is drawn as a dome (dome.h).
// Exit    0 done; 1 an input or the run failed; 2 wrong usage.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <span>

#include "malus/analysis/quantity.h"
#include "malus/core/error.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/sky_file.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/wavelengths.h"
#include "preview/dome.h"
#include "preview/dome_marks.h"
#include "preview/panels.h"
#include "preview/png.h"
#include "preview/sheet.h"

namespace fs = std::filesystem;

namespace malus::preview {
namespace {

constexpr int kFailed = 1, kUsage = 2;

struct Options {
    std::string input, output;
    std::vector<double> wavelengths_nm;
    std::optional<double> upper_dolp;
    std::vector<std::string> panels;  ///< none: all
    bool log = false, errors = false;
};

/// Where pictures go: all of them into a folder, or the sheet alone into a file.
struct Destination {
    fs::path folder, sheet;
    bool sheet_only = false;
};

Destination place_for(const Options& options) {
    const fs::path input = options.input, output = options.output;
    const std::string sheet_name = input.stem().string() + "_sheet.png";
    if (output.empty()) return {input.parent_path(), input.parent_path() / sheet_name};
    if (fs::is_directory(output)) return {output, output / sheet_name};
    const std::string ending = output.extension().string();
    if (ending == ".png" || ending == ".PNG") return {{}, output, true};
    if (!ending.empty())
        throw Error(options.output +
                    ": neither a folder nor a PNG file; name a folder, or end the name in .png");
    std::error_code error;
    if (!fs::create_directories(output, error) && error)
        throw Error(options.output + ": cannot be made a folder (" + error.message() +
                    "); choose another");
    return {output, output / sheet_name};
}

// The same, sure that pictures can be written.
Destination destination(const Options& options) {
    const Destination to = place_for(options);
    if (to.sheet_only) check_writable(to.sheet);
    return to;
}

void save(const fs::path& path, const Picture& picture, const std::string& description) {
    write_png(path, picture);
    std::cout << path.string() << ": " << description << std::endl;
}

std::string size_text(int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
}

std::string size_note(const Image& image, const Picture& shown) {
    const std::string size = size_text(image.width, image.height) + " pixels";
    if (shown.width > image.width)
        return size + ", enlarged " + std::to_string(shown.width / image.width) + " times";
    if (shown.width < image.width || shown.height < image.height)
        return size + ", means over squares: " + size_text(shown.width, shown.height);
    return size;
}

// Where the sun stood and from where the target is seen, as far as the header knows.
std::string geometry_note(const Image& image) {
    const auto place = [&](const std::string& what, const std::string& of) {
        const float *zenith = image.number(of + "Zenith"), *azimuth = image.number(of + "Azimuth");
        if (!zenith || !azimuth) return std::string();
        return "; " + what + " zenith angle " + to_text(std::round(10.0 * *zenith) / 10) +
               "^o, azimuth " + to_text(std::round(10.0 * *azimuth) / 10) + "^o";
    };
    return place("sun at", "sun") + place("seen from", "view");
}

/// A wavelength's panels.
struct PanelSet {
    std::vector<Panel> panels, errors;
};

PanelSet make_panels(const Layers& layers, const Scales& scales, const Options& options) {
    PanelSet all{
        {s0_panel(layers, scales), dolp_panel(layers, scales), aolp_panel(layers),
         s1_panel(layers, scales), s2_panel(layers, scales), combined_panel(layers, scales)},
        {}};
    const std::vector<std::string>& asked = options.panels;
    if (!asked.empty())
        std::erase_if(all.panels, [&](const Panel& panel) {
            return std::find(asked.begin(), asked.end(), panel.quantity) == asked.end();
        });
    if (asked.empty() || options.errors) all.errors = error_panels(layers, scales);
    return all;
}

Scales scales_for(const Layers& layers, const Options& options) {
    Scales scales =
        scales_of(layers, options.log ? GreyScale::kLog : GreyScale::kLinear, options.upper_dolp);
    scales.sequential = color_table("inferno");
    return scales;
}

void save_panels(const std::vector<Panel>& panels, double wavelength_nm, const Options& options,
                 const Destination& to) {
    if (to.sheet_only) return;
    const std::string stem = fs::path(options.input).stem().string();
    for (const Panel& panel : panels)
        save(to.folder / (stem + "_" + panel.quantity + "_" + to_text(wavelength_nm) + "nm.png"),
             panel.picture, panel.description);
}

// The rows of a sheet that show them.
void add_rows(std::vector<std::vector<Panel>>& rows, PanelSet set, const Options& options) {
    rows.push_back(std::move(set.panels));
    if (options.errors && !set.errors.empty()) rows.push_back(std::move(set.errors));
}

Font font_or_note() {
    const Font font = find_font();
    if (font.name.empty())
        std::cerr << "malus: note: no font found, the sheet has no labels; install DejaVu Sans or "
                     "name its folder in OPENIMAGEIO_FONTS\n";
    return font;
}

void save_sheet(const std::string& subheading, const std::vector<std::vector<Panel>>& rows,
                std::span<const double> wavelengths_nm, const Options& options,
                const Destination& to, const Font& font) {
    const std::string heading = one_line(fs::path(options.input).filename().string(), 70);
    save(to.sheet, make_sheet(heading, subheading, rows, font),
         "side by side at " + to_text(wavelengths_nm) + " nm, with scales and units");
}

void preview_image(const Image& image, const Options& options) {
    std::vector<double> wavelengths_nm;
    std::vector<Layers> layers;
    try {
        wavelengths_nm = wavelengths_of(image, options.wavelengths_nm);
        for (double nm : wavelengths_nm) layers.push_back(read_layers(image, nm));
    } catch (const Error& error) {
        throw Error(options.input + ": " + error.what());
    }
    const Destination to = destination(options);
    std::vector<std::vector<Panel>> rows;
    const int times = reduction_for_sheet(image.width, image.height);
    for (const Layers& at : layers) {
        const Scales scales = scales_for(at, options);
        PanelSet set = make_panels(at, scales, options);
        save_panels(set.panels, at.wavelength_nm, options, to);
        save_panels(set.errors, at.wavelength_nm, options, to);
        if (times > 1) set = make_panels(reduced(at, times), scales, options);
        add_rows(rows, std::move(set), options);
    }
    for (std::vector<Panel>& row : rows)
        for (Panel& panel : row) panel.picture = fit_to_sheet(panel.picture);
    save_sheet(size_note(image, rows.front().front().picture) + geometry_note(image), rows,
               wavelengths_nm, options, to, font_or_note());
}

void preview_sky(const Sky& sky, const Options& options) {
    for (const std::string& warning : sky.warnings) std::cerr << "malus: note: " << warning << '\n';
    std::vector<double> wavelengths_nm;
    try {
        wavelengths_nm = wavelengths_of(sky.wavelengths_nm, options.wavelengths_nm);
    } catch (const Error& error) {
        throw Error(options.input + ": " + error.what());
    }
    const Destination to = destination(options);
    const Font font = font_or_note();
    const SkyDome dome(sky, wavelengths_nm);
    std::vector<std::vector<Panel>> rows;
    for (std::size_t w = 0; w < wavelengths_nm.size(); ++w) {
        const DomeView view;
        const Layers layers = dome_layers(dome, w, wavelengths_nm[w], view);
        PanelSet set = make_panels(layers, scales_for(layers, options), options);
        mark_dome(set.panels, view, sky.sun, dome, w, font);
        save_panels(set.panels, wavelengths_nm[w], options, to);
        add_rows(rows, std::move(set), options);
    }
    save_sheet(dome_note(sky), rows, wavelengths_nm, options, to, font);
}

bool is_sky(const Image& image) {
    const std::string* frame = image.text("stokesReferenceFrame");
    return frame && *frame == "meridian";
}

void run(const Options& options) {
    if (is_csv(options.input)) return preview_sky(read_sky(options.input), options);
    const Image image = read_exr(options.input);
    if (is_sky(image)) return preview_sky(read_sky(options.input), options);
    preview_image(image, options);
}

int parse_and_run(int argc, char** argv) {
    CLI::App app{
        "Make PNG pictures (8-bit sRGB) of an image or sky map, some for each wavelength, and a "
        "sheet of all with scales, units, sun and view.\n\n"
        "S0      grey, white at the 99.5th percentile of the pixels that show a surface or sky,\n"
        "        W m^-2 sr^-1 nm^-1\n"
        "DoLP    degree of linear polarization, dark (0) to bright (map inferno)\n"
        "AoLP    angle of linear polarization, hue for 0 to 180 degrees counter-clockwise from "
        "image\n"
        "        right; grey where its standard error nears 30 degrees or DoLP is below 3 "
        "standard\n"
        "        errors; dark where S0 is 0\n"
        "S1_S0   S1/S0, -R (blue) over 0 (white) to R (red): along image right less along image "
        "up\n"
        "S2_S0   S2/S0, the same: along 45 less along 135 degrees\n"
        "combined  hue AoLP, strength of the colour DoLP (full at R), brightness S0, which counts\n"
        "        the less the stronger the polarization, so that shadows hide none\n"
        "StdErr_S0, StdErr_DoLP, StdErr_AoLP  standard errors, S0's divided by S0, dark (small) "
        "to\n"
        "        bright (nothing known), logarithmic; if the image has them\n\n"
        "R is the 99.5th percentile of sqrt(S1^2 + S2^2)/S0, rounded up, or --range; each "
        "picture's\n"
        "line and legend state it. Sheets of more than 640 x 800 pixels a picture show means of "
        "the\n"
        "Stokes vectors over squares of pixels, and the errors of these means.\n\n"
        "A sky map is drawn as an all-sky camera that looks up sees it: zenith in the middle, "
        "north\n"
        "up, east LEFT (a map of the ground has east right), the horizon a circle, the distance "
        "from\n"
        "the middle proportional to the zenith angle. AoLP is then counted from the vertical "
        "plane,\n"
        "which is the radius: 0 along it, 90 across it. The sun, if the file declares one, and "
        "the\n"
        "neutral points (Babinet, Brewster, Arago) that follow from the map are marked.\n",
        "malus preview"};
    Options options;
    app.add_option("file", options.input, "Image, EXR, or sky map, EXR or CSV")->required();
    app.add_option("-o,--output", options.output,
                   "Folder for NAME_S0_440nm.png, NAME_DoLP_440nm.png, … (the names above) and "
                   "NAME_sheet.png; or a name ending in .png for the sheet alone "
                   "[default: the folder of the file]");
    app.add_option("--wavelengths", options.wavelengths_nm,
                   "Wavelengths to show, nm, e.g. 440,600 [default: all]")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::PositiveNumber);
    app.add_option("--range", options.upper_dolp,
                   "DoLP that has the brightest colour, and R, above 0 and up to 1 (no unit) "
                   "[default: 1, and R from the image]")
        ->check(CLI::Range(1e-4, 1.0));
    app.add_flag("--log", options.log,
                 "S0 on a logarithmic scale of three decades [default: linear]");
    app.add_option(
           "--panels", options.panels,
           "Pictures to make, with commas: S0,DoLP,AoLP,S1_S0,S2_S0,combined [default: all, and "
           "the errors apart from the sheet]")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"S0", "DoLP", "AoLP", "S1_S0", "S2_S0", "combined"}));
    app.add_flag("--errors", options.errors,
                 "Show the errors on the sheet, too, in a second row a wavelength");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& usage) {
        return app.exit(usage) == 0 ? 0 : kUsage;
    }
    run(options);
    return 0;
}

}  // namespace
}  // namespace malus::preview

int main(int argc, char** argv) {
    try {
        return malus::preview::parse_and_run(argc, argv);
    } catch (const malus::Error& error) {
        std::cerr << "malus: " << error.what() << '\n';
    } catch (const std::bad_alloc&) {
        std::cerr << "malus: not enough memory for this; choose fewer --wavelengths\n";
    } catch (const std::exception& error) {
        std::cerr << "malus: " << malus::one_line(error.what()) << '\n';
    }
    return malus::preview::kFailed;
}
