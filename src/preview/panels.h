// panels.h — pictures of what a wavelength's layers hold, and the legends by which they are read.
//
//   S0            grey, white at the 99.5th percentile of the pixels that show a surface
//   DoLP          sequential map, 0 to a stated upper end
//   AoLP          cyclic map, faded to grey where the angle is uncertain
//   S1/S0, S2/S0  diverging map, −R to R, R the 99.5th percentile of √(S1² + S2²)/S0 or as asked
//   combined      hue AoLP, strength DoLP (full at R), brightness S0
//   errors        of S0 (relative), DoLP and AoLP: sequential map, logarithmic
//
// Dark grey but in S0: no light comes from there (S0 = 0), so there is nothing to show.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "preview/layers.h"
#include "preview/picture.h"

namespace malus::preview {

struct Tick {
    double at;  ///< place on the bar, 0 to 1
    std::string label;
};

struct Legend {
    std::function<Color(double, double)> color;  ///< of a place on the bar, along and up, 0 to 1
    std::vector<Tick> ticks;
    std::vector<std::string> captions;     ///< one a line
    std::optional<double> wheel_from_deg;  ///< angles as directions: where the bar's start points,
                                           ///< counter-clockwise from the right
};

struct Panel {
    std::string quantity;     ///< for file names: "DoLP", "S1_S0"
    std::string title;        ///< for the sheet: "DoLP, 440 nm"
    std::string description;  ///< for the terminal: one line that says what is seen and how
    Picture picture;
    Legend legend;
};

enum class GreyScale { kLinear, kLog };

/// Which numbers have which colours.
struct Scales {
    GreyScale grey = GreyScale::kLinear;
    double white = 1;                                           ///< S0 of white
    double upper_dolp = 1;                                      ///< DoLP of the brightest colour
    double ratio = 1;                                           ///< R
    std::vector<Color> sequential{{0, 0, 0}, {255, 255, 255}};  ///< even steps from dark to bright
};
/// `upper_dolp`, if given, is R, too.
Scales scales_of(const Layers& layers, GreyScale grey, std::optional<double> upper_dolp = {});

/// The colour at t in [0,1] of a table of even steps, between two colours the mean; t is clipped.
Color color_at(const std::vector<Color>& table, double t);

Panel s0_panel(const Layers& layers, const Scales& scales);
Panel dolp_panel(const Layers& layers, const Scales& scales);
Panel aolp_panel(const Layers& layers);
Panel s1_panel(const Layers& layers, const Scales& scales);
Panel s2_panel(const Layers& layers, const Scales& scales);
Panel combined_panel(const Layers& layers, const Scales& scales);
/// Of S0, DoLP and AoLP; none if the image knows no errors.
std::vector<Panel> error_panels(const Layers& layers, const Scales& scales);

}  // namespace malus::preview
