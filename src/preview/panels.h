// panels.h — pictures of S0, DoLP and AoLP, and the legends by which they are read.
//
//   S0     grey, white at the 99.5th percentile of the pixels that show a surface
//   DoLP   sequential map, 0 to a stated upper end
//   AoLP   cyclic map, faded to grey where the angle is uncertain
//
// Dark grey, in DoLP and AoLP: no light comes from there (S0 = 0), so there is nothing to show.
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
    std::function<Color(double)> color;  ///< of a place on the bar, 0 to 1
    std::vector<Tick> ticks;
    std::vector<std::string> captions;     ///< one a line
    std::optional<double> wheel_from_deg;  ///< angles as directions: where the bar's start points,
                                           ///< counter-clockwise from the right
};

struct Panel {
    std::string quantity;     ///< for file names: "DoLP"
    std::string title;        ///< for the sheet: "DoLP, 440 nm"
    std::string description;  ///< for the terminal: one line that says what is seen and how
    Picture picture;
    Legend legend;
};

enum class GreyScale { kLinear, kLog };

Panel s0_panel(const Layers& layers, GreyScale scale);
Panel dolp_panel(const Layers& layers, double upper_dolp);
Panel aolp_panel(const Layers& layers);

}  // namespace malus::preview
