// main.cpp — malus-preview: PNG pictures of an image's S0, DoLP and AoLP.
//
// Called as `malus preview IMAGE.exr …`.
// Exit    0 done; 1 an input or the run failed; 2 wrong usage.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <new>

#include "malus/core/error.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/wavelengths.h"
#include "preview/panels.h"
#include "preview/png.h"
#include "preview/sheet.h"

namespace fs = std::filesystem;

namespace malus::preview {
namespace {

constexpr int kFailed = 1, kUsage = 2;

struct Options {
    std::string image, output;
    std::vector<double> wavelengths_nm;
    double upper_dolp = 1;
    bool log = false;
};

/// Where pictures go: all of them into a folder, or the sheet alone into a file.
struct Destination {
    fs::path folder, sheet;
    bool sheet_only = false;
};

Destination destination(const Options& options) {
    const fs::path image = options.image, output = options.output;
    const std::string sheet_name = image.stem().string() + "_sheet.png";
    if (output.empty()) return {image.parent_path(), image.parent_path() / sheet_name};
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

// The wavelengths to show as the image has them, in the order that was asked for.
std::vector<double> chosen_wavelengths(const Options& options, const Image& image) {
    const std::vector<double> available = stokes_wavelengths(image);
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

// The panels of a wavelength, written one by one where that is wanted, then in the sheet's size.
std::vector<Panel> make_row(const Layers& layers, const Options& options, const Destination& to) {
    std::vector<Panel> row{
        s0_panel(layers, options.log ? GreyScale::kLog : GreyScale::kLinear),
        dolp_panel(layers, options.upper_dolp),
        aolp_panel(layers),
    };
    const std::string stem = fs::path(options.image).stem().string();
    for (Panel& panel : row) {
        const std::string name =
            stem + "_" + panel.quantity + "_" + to_text(layers.wavelength_nm) + "nm.png";
        if (!to.sheet_only) save(to.folder / name, panel.picture, panel.description);
        panel.picture = fit_to_sheet(panel.picture);
    }
    return row;
}

Font font_or_note() {
    const Font font = find_font();
    if (font.name.empty())
        std::cerr << "malus: note: no font found, the sheet has no labels; install DejaVu Sans or "
                     "name its folder in OPENIMAGEIO_FONTS\n";
    return font;
}

void run(const Options& options) {
    const Image image = read_exr(options.image);
    std::vector<double> wavelengths_nm;
    std::vector<Layers> layers;
    try {
        wavelengths_nm = chosen_wavelengths(options, image);
        for (double nm : wavelengths_nm) layers.push_back(read_layers(image, nm));
    } catch (const Error& error) {
        throw Error(options.image + ": " + error.what());
    }
    const Destination to = destination(options);
    if (to.sheet_only) check_writable(to.sheet);
    std::vector<std::vector<Panel>> rows;
    for (const Layers& at : layers) rows.push_back(make_row(at, options, to));
    const std::string heading = one_line(fs::path(options.image).filename().string(), 70);
    const std::string size = size_note(image, rows.front().front().picture);
    save(to.sheet, make_sheet(heading, size, rows, font_or_note()),
         "S0, DoLP and AoLP side by side at " + to_text(wavelengths_nm) +
             " nm, with scales and units");
}

int parse_and_run(int argc, char** argv) {
    CLI::App app{
        "Make PNG pictures (8-bit sRGB) of an image or sky map: S0, DoLP and AoLP of each "
        "wavelength, and a sheet of all with scales and units.\n\n"
        "S0    grey, white at the 99.5th percentile of the pixels that show a surface,\n"
        "      W m^-2 sr^-1 nm^-1\n"
        "DoLP  degree of linear polarization, dark (0) to bright\n"
        "AoLP  angle of linear polarization, hue for 0 to 180 degrees counter-clockwise from "
        "image\n"
        "      right (sky maps: from the direction of the zenith); grey where its standard error\n"
        "      nears 30 degrees or DoLP is below 3 standard errors; dark where S0 is 0\n",
        "malus preview"};
    Options options;
    app.add_option("image", options.image, "Image or sky map, EXR")->required();
    app.add_option("-o,--output", options.output,
                   "Folder for NAME_S0_440nm.png, NAME_DoLP_440nm.png, NAME_AoLP_440nm.png … and "
                   "NAME_sheet.png; or a name ending in .png for the sheet alone "
                   "[default: the folder of the image]");
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
