// sun_disc.cpp — where the sun's disc is and how bright.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/sun_disc.h"

#include <algorithm>

namespace malus {

const double SunDisc::kEdge2 = sqr(2 * std::sin(kSunRadius / 2));

SunDisc::SunDisc(const Sky& sky, std::span<const double> wavelengths_nm)
    : radiance_(wavelengths_nm.size() + SkyDome::kPadding, 0.0f) {
    if (!sky.sun || sky.sun->irradiance.empty()) return;
    toward_ = Basis(direction(sky.sun->zenith, sky.sun->azimuth), kUp);
    const std::vector<std::size_t> which = wavelength_indices(sky, wavelengths_nm);
    double brightest = 0;
    for (std::size_t i = 0; i < which.size(); ++i) {
        const double irradiance = sky.sun->irradiance[which[i]];
        brightest = std::max(brightest, irradiance);
        radiance_[i] = static_cast<float>(irradiance / (kPi * sqr(std::sin(kSunRadius))));
    }
    present_ = brightest > 0 && sky.sun->zenith < kPi / 2 + kSunRadius;
}

double SunDisc::pdf() const {
    return 1 / (kPi * kEdge2);
}

}  // namespace malus
