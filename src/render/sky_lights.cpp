// sky_lights.cpp — mathematics in registers, tables lane by lane.
// SPDX-License-Identifier: Apache-2.0
#include "render/sky_lights.h"

namespace malus {
namespace {

// The grid's nodes around points of the dome, as EqualAreaSky::lookup() has them.
void look_up(const EqualAreaSky& grid, const DomePointOf<Reals>& p, unsigned wanted,
             SkyLookups& at) {
    const GridPlaceOf<Reals> place = place_on_grid(to_square(p), grid.cells());
    const auto first = stored(grid.first_node(place));
    std::array<std::array<float, kSide>, 4> weight;
    const std::array<Reals, 4> weights = bilinear_weights(place);
    for (std::size_t k = 0; k < 4; ++k) store_floats(weights[k], weight[k].data());
    for (std::size_t i = 0; i < kSide; ++i)
        at[i] = wanted >> i & 1
                    ? SkyLookup{grid.nodes_from(first[i]),
                                {weight[0][i], weight[1][i], weight[2][i], weight[3][i]}}
                    : SkyLookup{};
}

}  // namespace

Reals locate(const SkyEmitter& sky, const SkyDensity& by_light, const Vec3s& w, unsigned wanted,
             SkyLookups& at) {
    const auto above = w.y >= Reals(0.0);
    wanted &= bits(above);
    const Vec3s up = select(above, w, Vec3s(Vec3{0, 1, 0}));
    const DomePointOf<Reals> p = dome_point(up, sky.dome().first_azimuth());
    if (sky.grid()) {
        look_up(*sky.grid(), p, wanted, at);
    } else {
        const auto directions = stored(up);
        for (std::size_t i = 0; i < kSide; ++i)
            at[i] = wanted >> i & 1 ? sky.dome().locate(directions[i]) : SkyLookup{};
    }
    const auto t = stored(p.t), azimuth = stored(p.azimuth);
    return lanewise<Reals>([&](std::size_t i) {
        return wanted >> i & 1 ? by_light.pdf({t[i], azimuth[i]}) : 0;
    });
}

SkySamples sample_sky(const SkyEmitter& sky, const SkyDensity& by_light, const Reals& u1,
                      const Reals& u2, SkyLookups& at) {
    if (by_light.dark()) {
        at = {};
        return {Vec3s(Vec3{0, 1, 0}), Reals(0.0)};
    }
    const auto draws = by_light.draws(stored(u1), stored(u2));
    const DomePointOf<Reals> p{
        lanewise<Reals>([&](std::size_t i) { return draws[i].point.t; }),
        lanewise<Reals>([&](std::size_t i) { return draws[i].point.azimuth; })};
    const Vec3s w = direction_of(p, sky.dome().first_azimuth());
    if (sky.grid()) {
        look_up(*sky.grid(), p, kAllLanes, at);
    } else {
        const auto directions = stored(w);
        for (std::size_t i = 0; i < kSide; ++i) at[i] = sky.dome().locate(directions[i]);
    }
    return {w, lanewise<Reals>([&](std::size_t i) { return draws[i].pdf; })};
}

}  // namespace malus
