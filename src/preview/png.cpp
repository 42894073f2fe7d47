// png.cpp — text and PNG by OpenImageIO.
// SPDX-License-Identifier: Apache-2.0
#include "preview/png.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "malus/core/error.h"
#include "malus/io/file.h"
#include "preview/color_maps.h"

namespace malus::preview {
namespace {

static_assert(sizeof(Color) == 3, "OpenImageIO takes the pixels as bytes without gaps");

OIIO::ImageSpec spec_of(const Picture& picture) {
    OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    return spec;
}

// OpenImageIO looks for names in some folders, by version; paths are where systems keep DejaVu.
constexpr std::array kFonts{
    "DejaVuSans",
    "DejaVu Sans",
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",    // Debian, Ubuntu
    "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",  // Fedora
    "/usr/share/fonts/TTF/DejaVuSans.ttf",                // Arch
    "/usr/share/fonts/truetype/DejaVuSans.ttf",           // openSUSE
    "/usr/share/fonts/dejavu/DejaVuSans.ttf",             // Alpine, Gentoo, RHEL 7
    "/usr/local/share/fonts/dejavu/DejaVuSans.ttf",       // FreeBSD
    "/Library/Fonts/DejaVuSans.ttf",                      // macOS
    "LiberationSans-Regular",
    "DroidSans",  // comes with OpenImageIO
    "Arial",
};

/// Letters of one height: on the line, or smaller and raised.
struct Run {
    std::string text;
    bool raised = false;
};

// OpenImageIO 2.4 draws only ASCII rightly: exponents and the degree sign are made of raised
// letters, and what else is not ASCII becomes '?', one for each character.
std::vector<Run> runs_of(const std::string& text) {
    std::vector<Run> runs(1);
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte >= 0x80 && byte < 0xC0) continue;  // a later byte of a character
        const bool raisable = std::string_view("-0123456789o").find(c) != std::string_view::npos;
        if (c == '^' || (runs.back().raised && !raisable)) runs.push_back({"", c == '^'});
        if (c != '^') runs.back().text += byte < 0x80 ? c : '?';
    }
    return runs;
}

int size_of(const Run& run, int size) {
    return run.raised ? std::max(1, (size * 7 + 5) / 10) : size;
}

// How far the pen moves. What is measured is ink, so a bar after the text makes spaces count.
int advance(const Run& run, int size, const Font& font) {
    const auto ink_end = [&](const std::string& text) {
        return OIIO::ImageBufAlgo::text_size(text, size_of(run, size), font.name).xend;
    };
    return ink_end(run.text + "|") - ink_end("|");
}

void write_bytes(const std::filesystem::path& path, const Picture& picture) {
    const auto out = OIIO::ImageOutput::create("png");
    if (!out) throw Error("this OpenImageIO has no PNG: " + OIIO::geterror());
    if (!out->open(path.string(), spec_of(picture)) ||
        !out->write_image(OIIO::TypeDesc::UINT8, picture.pixels.data()) || !out->close())
        throw Error(out->geterror());
}

}  // namespace

std::vector<Color> color_table(const std::string& map) {
    constexpr int kColors = 256;
    std::vector<float> places;
    for (int i = 0; i < kColors; ++i) places.push_back(static_cast<float>(i) / (kColors - 1));
    const OIIO::ImageBuf ramp(OIIO::ImageSpec(kColors, 1, 1, OIIO::TypeDesc::FLOAT), places.data());
    // Its colours are linear in light.
    const OIIO::ImageBuf colors = OIIO::ImageBufAlgo::color_map(ramp, 0, map);
    std::vector<Color> table;
    for (int i = 0; i < kColors; ++i) {
        const auto light = [&](int channel) { return double{colors.getchannel(i, 0, 0, channel)}; };
        table.push_back(to_color({light(0), light(1), light(2)}));
    }
    return table;
}

Font find_font() {
    for (const char* name : kFonts) {
        const bool found = OIIO::ImageBufAlgo::text_size("0", 13, name).defined();
        OIIO::geterror();  // a font that is not there is no error of ours
        if (found) return {name};
    }
    return {};
}

void draw_text(Picture& picture, const Font& font, int x, int y, const std::string& text,
               const Lettering& style) {
    if (font.name.empty() || text.empty()) return;
    const std::vector<Run> runs = runs_of(text);
    int width = 0;
    for (const Run& run : runs) width += advance(run, style.size, font);
    if (style.align != Align::kLeft) x -= style.align == Align::kCenter ? width / 2 : width;
    OIIO::ImageBuf canvas(spec_of(picture), picture.pixels.data());
    const auto part = [](std::uint8_t code) { return static_cast<float>(code) / 255.0f; };
    const std::array color{part(style.color.r), part(style.color.g), part(style.color.b)};
    for (const Run& run : runs) {
        const int baseline = run.raised ? y - (style.size * 2 + 2) / 5 : y;
        if (!run.text.empty() && !OIIO::ImageBufAlgo::render_text(
                                     canvas, x, baseline, run.text, size_of(run, style.size),
                                     font.name, color, OIIO::ImageBufAlgo::TextAlignX::Left,
                                     OIIO::ImageBufAlgo::TextAlignY::Baseline, style.halo))
            throw Error("font " + font.name + ": cannot be drawn with (" +
                        one_line(canvas.geterror()) + "); install the fonts DejaVu");
        x += advance(run, style.size, font);
    }
}

void write_png(const std::filesystem::path& path, const Picture& picture) {
    write_whole(path, [&](const std::filesystem::path& beside) { write_bytes(beside, picture); });
}

}  // namespace malus::preview
