// neutral_points.h — where on the sun's vertical the sky's light is unpolarized.
//
//   Babinet's above the sun, Brewster's below it, Arago's above the point opposite to the sun
//
// Light scattered once is polarized across the sun's vertical (S1 < 0 in the frame of that plane);
// around the sun and the point opposite, light scattered more often outdoes it, polarized in the
// plane (S1 > 0). A neutral point is where S1 falls through zero on the way out.
//
// Frame   the plane through zenith and sun holds the meridians on both sides of the zenith, so that
//         S1 is continuous along the walk. A sky that is not the same on both sides of the plane
//         can have some S2 left where S1 changes sign.
// Units   rad; azimuth clockwise from north.
// Source  K. L. Coulson, Polarization and Intensity of Light in the Atmosphere (1988).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/scene/sky.h"

namespace malus {

struct NeutralPoint {
    std::string name;        ///< "Babinet", "Brewster" or "Arago"
    double zenith, azimuth;  ///< rad
    double distance;         ///< from the sun; Arago's from the point opposite to it; rad
};

/// Those above the horizon, in this order, at most 90° from the sun or the point opposite. The 2°
/// around the sun, where a map may hold its disc, are left out. `wavelength` is the dome's index.
std::vector<NeutralPoint> neutral_points(const SkyDome& dome, std::size_t wavelength,
                                         const Sun& sun);

}  // namespace malus
