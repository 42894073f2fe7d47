// dome.h — a sky map as an all-sky camera sees it: the dome from below.
//
//   x = −r sin a,   y = −r cos a,   r = R z/90°      from the zenith in the middle
//
// Frame   looking up: north up, east left (a map of the ground has east right). The projection is
//         equidistant: r is proportional to the zenith angle z, and R is the horizon. Pixels, x to the
//         right, y down; a pixel's middle is at half pixels.
// AoLP    from the vertical plane, counter-clockwise as seen from below and so in the picture: 0° lies
//         along the radius, 90° along the circles around the zenith.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/scene/sky.h"
#include "preview/layers.h"
#include "preview/picture.h"
#include "preview/png.h"

namespace malus::preview {

/// A square with the horizon's circle in its middle and room for N, E, S, W around it; pixels.
struct DomeView {
    int size = 576;
    double radius = 250;
};

/// Where a direction is seen; zenith and azimuth in rad.
Point place_of(const DomeView& view, double zenith, double azimuth);

/// The direction that is seen there; at the horizon if the place lies beyond.
Vec3 direction_at(const DomeView& view, const Point& place);

/// Interpolated where directions do not spin (fixed_frame), then turned into the meridian frame.
/// coverage is 1 above the horizon, else 0.
Layers dome_layers(const SkyDome& dome, std::size_t wavelength, double wavelength_nm,
                   const DomeView& view);

enum class Symbol { kSun, kPoint };

/// A place of the sky that is shown by a symbol and its name.
struct Mark {
    std::string name;
    double zenith, azimuth;  ///< rad; below the horizon it is not drawn
    Symbol symbol = Symbol::kPoint;
};

/// Paints paper over what lies beyond the horizon; draws circle, azimuth ticks each 30° and symbols.
void draw_dome(Picture& picture, const DomeView& view, const std::vector<Mark>& marks);

/// Text on a picture; place and style as draw_text() takes them.
struct Word {
    int x, y;
    std::string text;
    Lettering style;
};

/// N, E, S, W around the dome and the names of the marks, dark where the picture is light.
std::vector<Word> dome_words(const Picture& picture, const DomeView& view,
                             const std::vector<Mark>& marks);

}  // namespace malus::preview
