// gltf_container.h — from a file's bytes to JSON text and, for a .glb, its binary chunk.
//
// GLB     12-byte header (magic "glTF", version 2, length), then chunks of 8-byte header (length,
//         type) and data; the first is JSON, the second may be BIN. Little-endian, glTF 2.0 §4.4.
// Safety  the text is scanned for nesting and for its number of values before anything parses
//         it: parsers recurse, and a small file can ask for much memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "io/gltf_file.h"

namespace malus::gltf {

struct Container {
    std::string text;          ///< JSON, scanned but not parsed
    std::optional<Bytes> bin;  ///< the GLB's BIN chunk
};

/// Told apart by the first four bytes, not by the file's name.
Container open_container(Bytes file);

}  // namespace malus::gltf
