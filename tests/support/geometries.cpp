// geometries.cpp — singular geometries of a reflection.
// SPDX-License-Identifier: Apache-2.0
#include "support/geometries.h"

#include <cmath>

#include "malus/core/frame.h"

namespace malus {

Vec3 direction_from(double theta_deg, double phi_deg) {
    const double t = to_radians(theta_deg), p = to_radians(phi_deg);
    return {std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
}

std::vector<Geometry> singular_geometries() {
    const double brewster = to_degrees(std::atan(1.5));
    const Vec3 wo = direction_from(40, 20), pole{0, 0, 1};
    std::vector<Geometry> at{
        {"specular", 0, direction_from(40, 200), wo},
        {"retro", 0, wo, wo},
        {"light and sensor along the normal", 0, pole, pole},
        {"light along the normal", 0, pole, wo},
        {"Brewster", 0, direction_from(brewster, 200), direction_from(brewster, 20)}};
    for (double grazing : {89.9, 89.999, 89.99999}) {
        const Vec3 forward = direction_from(grazing, 200), back = direction_from(grazing, 20);
        const Vec3 aside = direction_from(grazing, 130);
        at.push_back({"grazing light", 0, aside, wo});
        at.push_back({"grazing sensor", 0, wo, aside});
        at.push_back({"grazing both, forward", 0, forward, back});
        at.push_back({"grazing both, back", 0, back, back});
    }
    std::vector<Geometry> all;
    for (const Geometry& g : at) {
        const Vec3 side = any_perpendicular(g.wi), other = cross(g.wi, side);
        for (double beside : {0.0, 1e-12, 1e-6, 1e-3})
            for (const Vec3& way : {side, -other, normalize(side + 2.0 * other)}) {
                const Vec3 wi = normalize(g.wi + beside * way);
                if (wi.z > 0) all.push_back({g.name, beside, wi, g.wo});
            }
    }
    return all;
}

double facet_strength(const Material& paint, const MaterialRow& row, const Reflection& r) {
    PriestGermer<double> perfect = row.p;
    perfect.n = 1, perfect.k = 1e9;
    return eval(perfect, paint.slopes, paint.attenuation, r).facet.a();
}

}  // namespace malus
