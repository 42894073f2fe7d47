// scene.cpp — counts and bounds of a scene.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/scene.h"

namespace malus {

std::size_t triangle_count(const Scene& scene) {
    std::size_t count = 0;
    for (const Instance& instance : scene.instances)
        count += scene.meshes[static_cast<std::size_t>(instance.mesh)].triangles.size();
    return count;
}

bool is_below(const Scene& scene, int node, int root) {
    for (; node >= 0; node = scene.nodes[static_cast<std::size_t>(node)].parent)
        if (node == root) return true;
    return false;
}

Box bounds(const Scene& scene, int root) {
    Box box;
    for (const Instance& instance : scene.instances) {
        if (root >= 0 && !is_below(scene, instance.node, root)) continue;
        const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
        for (const auto& triangle : mesh.triangles)
            for (std::uint32_t v : triangle)
                box.add(instance.to_world.point(Vec3(mesh.positions[v])));
    }
    return box;
}

}  // namespace malus
