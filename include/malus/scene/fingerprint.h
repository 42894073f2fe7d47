// fingerprint.h — short marks by which two renders are known to show the same.
//
// A mark is a hash of what light meets, not of names of files or of options: 16 hexadecimal digits.
// Numbers count as floats, placed vectors to a millionth, so that machines which round doubles
// differently agree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "malus/scene/camera.h"
#include "malus/scene/material.h"
#include "malus/scene/scene.h"
#include "malus/scene/sky.h"

namespace malus {

/// Triangles, normals, placements and the names of nodes.
std::string fingerprint(const Scene& scene);
/// Names and parameters of each instance's paint at these wavelengths.
std::string fingerprint(const std::vector<Material>& materials, const std::vector<int>& paints,
                        std::span<const double> wavelengths_nm);
/// The map and the sun's disc at these wavelengths. Throws Error when the sky lacks one.
std::string fingerprint(const Sky& sky, std::span<const double> wavelengths_nm);
/// Where the camera stands and what it frames.
std::string fingerprint(const Camera& camera);

}  // namespace malus
