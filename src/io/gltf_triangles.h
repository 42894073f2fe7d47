// gltf_triangles.h — from a primitive's vertices to triangles and unit normals.
//
//   triangles  (3i, 3i+1, 3i+2)          strip  (i, i+1, i+2), or (i, i+2, i+1) for odd i
//   fan        (i+1, i+2, 0)             all counter-clockwise seen from outside
//
// Source  glTF 2.0 specification, §3.7.2.1. Degenerate triangles are kept.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "malus/core/vec.h"

namespace malus::gltf {

using Triangle = std::array<std::uint32_t, 3>;

/// The modes of glTF that make triangles.
enum class Topology : int { kTriangles = 4, kStrip = 5, kFan = 6 };

std::size_t count_triangles(Topology topology, std::size_t corners);

/// Corners are indices[0], indices[1], …, or 0, 1, … when `indices` is empty.
std::vector<Triangle> make_triangles(Topology topology, std::size_t corners,
                                     std::span<const std::uint32_t> indices);

/// Makes all normals unit. One that has no direction becomes the mean of the flat normals around
/// its vertex, weighted by area. Returns how many those were.
std::size_t unify_normals(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                          std::vector<Vec3f>& normals);

}  // namespace malus::gltf
