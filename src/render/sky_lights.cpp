// sky_lights.cpp — mathematics in registers, tables lane by lane.
// SPDX-License-Identifier: Apache-2.0
#include "render/sky_lights.h"

namespace malus {
namespace {

// The grid's nodes around points of the dome, as EqualAreaSky::lookup() has them.
void look_up(const EqualAreaSky& grid, const DomePointOf<Reals>& p, unsigned wanted,
             std::array<SkyLookup, kSide>& at) {
    const GridPlaceOf<Reals> place = place_on_grid(to_square(p), grid.cells());
    const auto line = static_cast<std::uint32_t>(grid.cells() + 1);
    const auto first = stored(place.line * Reals(line) + place.column);
    const Reals right = place.u, left = Reals(1.0) - right, low = place.v, high = Reals(1.0) - low;
    std::array<std::array<float, kSide>, 4> weight;
    store_floats(high * left, weight[0].data());
    store_floats(high * right, weight[1].data());
    store_floats(low * left, weight[2].data());
    store_floats(low * right, weight[3].data());
    for (std::size_t i = 0; i < kSide; ++i) {
        const auto node = static_cast<std::uint32_t>(first[i]);
        at[i] = {{node, node + 1, node + line, node + line + 1},
                 {weight[0][i], weight[1][i], weight[2][i], weight[3][i]}};
        if (!(wanted >> i & 1)) at[i] = {};
    }
}

}  // namespace

SkyLights locate(const SkyEmitter& sky, const SkyDensity& by_light, const Vec3s& w,
                 unsigned wanted) {
    const auto above = w.y >= Reals(0.0);
    wanted &= bits(above);
    const Vec3s up = select(above, w, Vec3s(Vec3{0, 1, 0}));
    const DomePointOf<Reals> p = dome_point(up, sky.dome().first_azimuth());
    SkyLights lights;
    if (sky.grid()) {
        look_up(*sky.grid(), p, wanted, lights.at);
    } else {
        const auto directions = stored(up);
        for (std::size_t i = 0; i < kSide; ++i)
            lights.at[i] = wanted >> i & 1 ? sky.dome().locate(directions[i]) : SkyLookup{};
    }
    const auto t = stored(p.t), azimuth = stored(p.azimuth);
    lights.pdf = lanewise<Reals>([&](std::size_t i) {
        return wanted >> i & 1 ? by_light.pdf({t[i], azimuth[i]}) : 0;
    });
    return lights;
}

SkySamples sample_sky(const SkyEmitter& sky, const SkyDensity& by_light, const Reals& u1,
                      const Reals& u2) {
    SkySamples samples;
    if (by_light.dark()) return {Vec3s(Vec3{0, 1, 0}), {{}, Reals(0.0)}};
    const auto draws = by_light.draws(stored(u1), stored(u2));
    const DomePointOf<Reals> p{
        lanewise<Reals>([&](std::size_t i) { return draws[i].point.t; }),
        lanewise<Reals>([&](std::size_t i) { return draws[i].point.azimuth; })};
    samples.w = direction_of(p, sky.dome().first_azimuth());
    samples.lights.pdf = lanewise<Reals>([&](std::size_t i) { return draws[i].pdf; });
    if (sky.grid()) {
        look_up(*sky.grid(), p, kAllLanes, samples.lights.at);
    } else {
        const auto directions = stored(samples.w);
        for (std::size_t i = 0; i < kSide; ++i)
            samples.lights.at[i] = sky.dome().locate(directions[i]);
    }
    return samples;
}

}  // namespace malus
