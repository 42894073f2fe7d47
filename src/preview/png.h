// png.h — letters, colour maps and PNG files: the one place that knows OpenImageIO.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "preview/picture.h"

namespace malus::preview {

/// One of OpenImageIO's colour maps, "inferno" for one, as 256 colours from its start to its end.
std::vector<Color> color_table(const std::string& map);

/// What OpenImageIO knows a font by: a name or a path. Empty: there is none, nothing is drawn.
struct Font {
    std::string name;
};

/// DejaVu Sans if the machine has it, else another plain one, else none.
Font find_font();

enum class Align { kLeft, kCenter, kRight };

struct Lettering {
    int size = 13;  ///< pixels
    Color color{40, 40, 40};
    Align align = Align::kLeft;
    int halo = 0;  ///< width of a black edge, pixels
};

/// Writes text on its baseline y, from, around or up to x. Digits, '-' and 'o' after a '^' are
/// raised: "sr^-1", "45^o" for degrees. What is not ASCII becomes '?'.
void draw_text(Picture& picture, const Font& font, int x, int y, const std::string& text,
               const Lettering& style);

/// 8-bit sRGB. Appears whole or not at all; throws Error.
void write_png(const std::filesystem::path& path, const Picture& picture);

}  // namespace malus::preview
