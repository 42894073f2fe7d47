// sky_lights.h — the light of the sky for several directions side by side (scene/sky_emitter.h).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/lanes.h"
#include "scene/sky_emitter.h"

namespace malus {

/// Where directions lie among the nodes of a sky.
using SkyLookups = std::array<SkyLookup, kSide>;

/// Where the directions in `wanted` lie goes to `at`; others are black there, and so are those below the
/// horizon. Returns their density by `by_light`, sr⁻¹: the sky's own, or another that draws directions and whose
/// azimuths begin where the sky's do.
Reals locate(const SkyEmitter& sky, const SkyDensity& by_light, const Vec3s& w, unsigned wanted,
             SkyLookups& at);

struct SkySamples {
    Vec3s w;    ///< upward, whatever the sky
    Reals pdf;  ///< sr⁻¹; 0 where all is black
};
/// Directions drawn from two numbers in (0,1); where they lie goes to `at`.
SkySamples sample_sky(const SkyEmitter& sky, const SkyDensity& by_light, const Reals& u1,
                      const Reals& u2, SkyLookups& at);

}  // namespace malus
