// sky_lights.h — the light of the sky for several directions side by side (scene/sky_emitter.h).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/lanes.h"
#include "scene/sky_emitter.h"

namespace malus {

/// Where directions lie on the sky.
struct SkyLights {
    std::array<SkyLookup, kSide> at;
    Reals pdf;  ///< density of sample_sky() there, sr⁻¹
};

/// Of the lanes in `wanted`; others are black. Directions below the horizon are, too. `by_light`: what
/// draws directions, the sky's own density or another, whose azimuths begin where the sky's do.
SkyLights locate(const SkyEmitter& sky, const SkyDensity& by_light, const Vec3s& w,
                 unsigned wanted);

struct SkySamples {
    Vec3s w;  ///< upward, whatever the sky
    SkyLights lights;
};
/// Directions drawn from two numbers in (0,1). pdf = 0 where all is black.
SkySamples sample_sky(const SkyEmitter& sky, const SkyDensity& by_light, const Reals& u1,
                      const Reals& u2);

}  // namespace malus
