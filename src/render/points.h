// points.h — sample points of several paths side by side (core/sampler.h).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/core/sampler.h"
#include "render/lanes.h"

namespace malus {

/// Which point of which block, for each lane.
struct PointPlaces {
    std::array<const Scramble*, kSide> scramble;
    std::array<std::uint32_t, kSide> sample;
};

/// Coordinates First to First + Count − 1 of a point for each lane.
template <std::size_t First, std::size_t Count>
std::array<Reals, Count> points(const PointPlaces& at) {
    std::array<double, kSide * Count> u;  // [lane][coordinate]
    if (at.scramble[0]->sampling == Sampling::kIndependent) {
        for (std::size_t i = 0; i < kSide; ++i) {
            const SamplePoint point = at.scramble[i]->point(at.sample[i]);
            std::copy_n(point.begin() + First, Count, &u[i * Count]);
        }
    } else {
        std::array<std::uint32_t, kSide * Count> x, seed;
        std::array<std::uint32_t, kBlockDimensions> sobol_point{};
        for (std::size_t i = 0; i < kSide; ++i) {
            const Scramble& own = *at.scramble[i];
            const bool same = i > 0 && !own.shuffled && at.sample[i] == at.sample[i - 1] &&
                              own.block == at.scramble[i - 1]->block;
            if (!same) sobol_point = sobol(own.index(at.sample[i]), own.block);
            for (std::size_t d = 0; d < Count; ++d) {
                x[i * Count + d] = sobol_point[First + d];
                seed[i * Count + d] = own.seeds[First + d];
            }
        }
        for (std::size_t i = 0; i < kSide * Count; ++i)
            u[i] = fraction(owen_scramble(x[i], seed[i]));
    }
    std::array<Reals, Count> point;
    for (std::size_t d = 0; d < Count; ++d)
        point[d] = lanewise<Reals>([&](std::size_t i) { return u[i * Count + d]; });
    return point;
}

}  // namespace malus
