// geometries.h — directions of light and sensor over a surface whose normal is +Z.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/core/vec.h"
#include "malus/scene/material.h"

namespace malus {

/// The unit vector at `theta_deg` from +Z, `phi_deg` from +X toward +Y.
Vec3 direction_from(double theta_deg, double phi_deg);

/// Light from wi, sensor toward wo.
struct Geometry {
    std::string name;
    double beside;  ///< how far the light was moved from the singular point, rad
    Vec3 wi, wo;
};

/// Where formulas have removable singularities or run out of digits (specular, retro-reflection,
/// normal, Brewster's angle of n = 1.5, grazing), at the point and with the light 1e-12, 1e-6 and
/// 1e-3 rad beside it in three directions.
std::vector<Geometry> singular_geometries();

/// P SO G/(4 cosθi cosθo): what f would be with perfectly reflecting facets, sr⁻¹.
double facet_strength(const Material& paint, const MaterialRow& row, const Reflection& r);

}  // namespace malus
