// gltf_triangles.cpp — topologies and normals of glTF primitives.
// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_triangles.h"

namespace malus::gltf {
namespace {

// Scaled first: squares of float range fit a double, products of them would not.
Vec3 unit_or_zero(const Vec3& v) {
    const double most = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!is_finite(v) || !(most > 0)) return {};
    return normalize(Vec3(v.x / most, v.y / most, v.z / most));
}

Triangle triangle_at(Topology topology, std::uint32_t i) {
    if (topology == Topology::kTriangles) return {3 * i, 3 * i + 1, 3 * i + 2};
    if (topology == Topology::kFan) return {i + 1, i + 2, 0};
    return {i, i + 1 + i % 2, i + 2 - i % 2};
}

}  // namespace

std::size_t count_triangles(Topology topology, std::size_t corners) {
    if (topology == Topology::kTriangles) return corners / 3;
    return corners < 3 ? 0 : corners - 2;
}

std::vector<Triangle> make_triangles(Topology topology, std::size_t corners,
                                     std::span<const std::uint32_t> indices) {
    const std::size_t count = count_triangles(topology, corners);
    std::vector<Triangle> triangles;
    triangles.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const Triangle t = triangle_at(topology, static_cast<std::uint32_t>(i));
        triangles.push_back(
            indices.empty() ? t : Triangle{indices[t[0]], indices[t[1]], indices[t[2]]});
    }
    return triangles;
}

std::size_t unify_normals(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                          std::vector<Vec3f>& normals) {
    std::size_t missing = 0;
    for (Vec3f& normal : normals) {
        normal = Vec3f(unit_or_zero(Vec3(normal)));
        missing += normal == Vec3f() ? 1 : 0;
    }
    if (missing == 0) return 0;
    std::vector<Vec3> sums(normals.size());
    for (const Triangle& triangle : triangles) {
        const Vec3 a(positions[triangle[0]]), b(positions[triangle[1]]), c(positions[triangle[2]]);
        for (const std::uint32_t corner : triangle) sums[corner] += cross(b - a, c - a);
    }
    for (std::size_t i = 0; i < normals.size(); ++i) {
        if (normals[i] != Vec3f()) continue;
        const Vec3 mean = unit_or_zero(sums[i]);
        // Around such a vertex nothing has an area, so no ray will ask.
        normals[i] = mean == Vec3() ? Vec3f(0, 0, 1) : Vec3f(mean);
    }
    return missing;
}

}  // namespace malus::gltf
