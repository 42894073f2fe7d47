// main.cpp — malus-preview: PNG pictures of S0, DoLP and AoLP of an image or of the sky.
//
// Called as `malus preview FILE …`: an image EXR, or a sky map as EXR (in the frame "meridian") or
// CSV, which is drawn as a dome (dome.h).
// Exit    0 done; 1 an input or the run failed; 2 wrong usage.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <new>
#include <span>

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
    double upper_dolp = 1;
    bool log = false;
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

// The wavelengths to show as the file has them, in the order that was asked for.
std::vector<double> chosen_wavelengths(const Options& options,
                                       const std::vector<double>& available) {
    if (available.empty())
        throw Error(
            "no Stokes channels (S0.440,000000nm and so on); name an image or sky "
            "map that malus wrote");
    if (options.wavelengths_nm.empty()) return available;
    std::vector<double> chosen;
    for (double nm : options.wavelengths_nm) {
        const auto found = find_wavelength(available, nm);
        if (!found)
            throw Error("no " + to_text(nm) + " nm; choose --wavelengths among " +
                        to_text(available));
        if (find_wavelength(chosen, nm))
            throw Error("--wavelengths: " + to_text(nm) + " nm stands twice; keep one");
        chosen.push_back(available[*found]);
    }
    return chosen;
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
        return size + ", reduced to " + size_text(shown.width, shown.height);
    return size;
}

std::vector<Panel> make_panels(const Layers& layers, const Options& options) {
    return {s0_panel(layers, options.log ? GreyScale::kLog : GreyScale::kLinear),
            dolp_panel(layers, options.upper_dolp), aolp_panel(layers)};
}

// Writes a wavelength's panels one by one, where that is wanted; returns them in the sheet's size.
std::vector<Panel> saved(std::vector<Panel> panels, double wavelength_nm, const Options& options,
                         const Destination& to) {
    const std::string stem = fs::path(options.input).stem().string();
    for (Panel& panel : panels) {
        const std::string name =
            stem + "_" + panel.quantity + "_" + to_text(wavelength_nm) + "nm.png";
        if (!to.sheet_only) save(to.folder / name, panel.picture, panel.description);
        panel.picture = fit_to_sheet(panel.picture);
    }
    return panels;
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
         "S0, DoLP and AoLP side by side at " + to_text(wavelengths_nm) +
             " nm, with scales and units");
}

void preview_image(const Image& image, const Options& options) {
    std::vector<double> wavelengths_nm;
    std::vector<Layers> layers;
    try {
        wavelengths_nm = chosen_wavelengths(options, stokes_wavelengths(image));
        for (double nm : wavelengths_nm) layers.push_back(read_layers(image, nm));
    } catch (const Error& error) {
        throw Error(options.input + ": " + error.what());
    }
    const Destination to = destination(options);
    std::vector<std::vector<Panel>> rows;
    for (const Layers& at : layers)
        rows.push_back(saved(make_panels(at, options), at.wavelength_nm, options, to));
    save_sheet(size_note(image, rows.front().front().picture), rows, wavelengths_nm, options, to,
               font_or_note());
}

void preview_sky(const Sky& sky, const Options& options) {
    for (const std::string& warning : sky.warnings) std::cerr << "malus: note: " << warning << '\n';
    std::vector<double> wavelengths_nm;
    try {
        wavelengths_nm = chosen_wavelengths(options, sky.wavelengths_nm);
    } catch (const Error& error) {
        throw Error(options.input + ": " + error.what());
    }
    const Destination to = destination(options);
    const Font font = font_or_note();
    const SkyDome dome(sky, wavelengths_nm);
    std::vector<std::vector<Panel>> rows;
    for (std::size_t w = 0; w < wavelengths_nm.size(); ++w) {
        const DomeView view;
        std::vector<Panel> panels =
            make_panels(dome_layers(dome, w, wavelengths_nm[w], view), options);
        mark_dome(panels, view, sky.sun, dome, w, font);
        rows.push_back(saved(std::move(panels), wavelengths_nm[w], options, to));
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
        "Make PNG pictures (8-bit sRGB) of an image or sky map: S0, DoLP and AoLP of each "
        "wavelength, and a sheet of all with scales and units.\n\n"
        "S0    grey, white at the 99.5th percentile of the pixels that show a surface or sky,\n"
        "      W m^-2 sr^-1 nm^-1\n"
        "DoLP  degree of linear polarization, dark (0) to bright\n"
        "AoLP  angle of linear polarization, hue for 0 to 180 degrees counter-clockwise from "
        "image\n"
        "      right; grey where its standard error nears 30 degrees or DoLP is below 3 standard\n"
        "      errors; dark where S0 is 0\n\n"
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
                   "Folder for NAME_S0_440nm.png, NAME_DoLP_440nm.png, NAME_AoLP_440nm.png … and "
                   "NAME_sheet.png; or a name ending in .png for the sheet alone "
                   "[default: the folder of the file]");
    app.add_option("--wavelengths", options.wavelengths_nm,
                   "Wavelengths to show, nm, e.g. 440,600 [default: all]")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::PositiveNumber);
    app.add_option("--range", options.upper_dolp,
                   "DoLP that has the brightest colour, above 0 and up to 1 (no unit)")
        ->check(CLI::Range(1e-4, 1.0))
        ->capture_default_str();
    app.add_flag("--log", options.log,
                 "S0 on a logarithmic scale of three decades [default: linear]");
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
