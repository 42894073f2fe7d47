// gltf_front.h — from a path to a document that the glTF library underneath can be trusted with.
//
// The library takes an optional number of the wrong kind for absent, cuts large ones to int, loads
// images and opens any file. So the JSON is read here first: every value that this reader uses is
// checked for type, range and reference, and a new JSON is written with these values alone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/gltf_file.h"

namespace malus::gltf {

/// Beside the attributes POSITION and NORMAL, a primitive's indices travel under this name: the
/// library refuses an index accessor without bufferView, which is legal when it is sparse.
inline constexpr const char* kIndicesAttribute = "indices";

/// The URI of buffer i in Document::json is this and i; no file has to be opened any more.
inline constexpr const char* kBufferName = "malus-buffer-";

struct Document {
    std::string json;                    ///< for the library; only checked keys are left
    std::vector<Bytes> buffers;          ///< each of exactly its byteLength
    std::vector<std::string> materials;  ///< names
    std::vector<std::string> warnings;
    std::size_t primitives = 0;  ///< in all meshes together
    bool quantized = false;      ///< KHR_mesh_quantization: positions and normals may be integers
};

Document read_document(const std::filesystem::path& path);

}  // namespace malus::gltf
