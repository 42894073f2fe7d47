// scene.h — what stands under the sky: triangle meshes placed by nodes. Plain data.
//
// World   glTF's: right-handed, +Y up, metres, node transforms in double.
// Sides   triangles reflect on both sides, so neither winding nor mirroring changes a picture.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "malus/core/vec.h"
#include "malus/scene/camera.h"

namespace malus {

/// One glTF primitive: triangles of one material, in the mesh's own coordinates.
struct Mesh {
    std::string name;  ///< of the glTF mesh; may be empty
    int surface = -1;  ///< index into Scene::surfaces; −1 when the primitive names no material
    std::vector<Vec3f> positions;
    std::vector<Vec3f> normals;  ///< unit, one a position; empty: flat triangles
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

struct Node {
    std::string name;  ///< may be empty
    int parent = -1;   ///< index into Scene::nodes; −1 for a root
};

/// A mesh placed in the world by a node. Many instances may share one mesh.
struct Instance {
    int mesh = 0;
    int node = 0;
    Affine to_world;
};

struct Scene {
    std::vector<Mesh> meshes;
    std::vector<Node> nodes;
    std::vector<Instance> instances;
    std::vector<std::string> surfaces;  ///< names of the glTF materials, may be empty strings
    std::vector<Camera> cameras;        ///< in the order in which the nodes are visited
    std::vector<std::string> warnings;  ///< what was read but not used, one line each
};

/// Number of triangles as seen: each instance counts its mesh's.
std::size_t triangle_count(const Scene& scene);

/// Is `node` the node `root` or below it?
bool is_below(const Scene& scene, int node, int root);

/// World box of all instances whose node is `root` or below it; root = −1: of the whole scene.
Box bounds(const Scene& scene, int root = -1);

}  // namespace malus
