// benchmark_scenes.h — what tools/benchmark renders, made on the spot.
//
// plain    a box on level ground, most of which meets no occluder but that box
// relief   a box on rolling ground of a million triangles
// canyon   streets between 24 × 24 towers, seen from below their roofs: most sky is hidden
// bumps    a bumpy sphere of 100 000 triangles on a plane, no sky in view, lit by an even unpolarized
//          sky, in a paint that is Beckmann's rough conductor: the scene that Mitsuba was timed with
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/scene/material.h"
#include "malus/scene/scene.h"
#include "malus/scene/sky.h"

namespace malus {

struct BenchmarkScene {
    std::string name;
    Scene scene;
    std::vector<int> paints;  ///< of the instances
    std::vector<Material> materials;
    int max_depth = 2;
};

/// Paints are the first two of `materials`; cameras are the scenes' first.
BenchmarkScene plain_scene(const std::vector<Material>& materials);
BenchmarkScene relief_scene(const std::vector<Material>& materials);
BenchmarkScene canyon_scene(const std::vector<Material>& materials);
BenchmarkScene bumps_scene();

/// Radiance 1 everywhere, unpolarized.
Sky even_sky(const std::vector<double>& wavelengths_nm);

}  // namespace malus
