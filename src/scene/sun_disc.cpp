// sun_disc.cpp — where the sun's disc is and how bright.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/sun_disc.h"

#include <algorithm>

namespace malus {
namespace {

// Square of the chord between the middle of the disc and its edge on the unit sphere.
const double kEdge2 = sqr(2 * std::sin(kSunRadius / 2));

}  // namespace

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

bool SunDisc::contains(const Vec3& w) const {
    const Vec3 chord = w - toward_.n;
    return present_ && w.y >= 0 && dot(chord, chord) < kEdge2;
}

// Even in solid angle means even in the square of the chord.
Vec3 SunDisc::sample(double u1, double u2) const {
    const double chord2 = kEdge2 * u1, cosine = 1 - chord2 / 2;
    const double sine = std::sqrt(chord2 * (1 - chord2 / 4));
    const double turn = 2 * kPi * u2;
    return toward_.to_world({sine * std::cos(turn), sine * std::sin(turn), cosine});
}

double SunDisc::pdf() const {
    return 1 / (kPi * kEdge2);
}

}  // namespace malus
