// gltf.h — reads a scene from glTF 2.0 (.gltf with files or data URIs beside it, or .glb).
//
// Checks  everything that the library underneath does not: container, types, ranges, hierarchy,
//         required extensions, file access. Buffers come only from regular files inside the
//         scene's own folder. Textures, animations, skins and morph targets are not used.
// Result  indices in range, positions finite, normals unit, placements finite but perhaps singular
//         (a scale of zero is legal); at most 1 GiB of buffers and 1 GiB of meshes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "malus/scene/scene.h"

namespace malus {

/// The scene in `path`: its default glTF scene, or the first, or every root node if there is none.
/// Throws Error ("FILE: place: problem; remedy") when the file cannot be read, is not valid where
/// it matters here, requires an extension that is not supported, or holds no triangle.
Scene read_gltf(const std::filesystem::path& path);

}  // namespace malus
