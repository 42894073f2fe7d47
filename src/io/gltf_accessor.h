// gltf_accessor.h — decodes typed data from a buffer's bytes, never past their end.
//
//   element i = byteOffset + stride·i of the bufferView, or zero where there is none; sparse
//   values then replace single elements.
//
// Range   all counts, offsets and strides are below 2³¹ (gltf_front), so sums fit 64 bits.
// Source  glTF 2.0 specification, §3.6.2; integers to floats as in §3.11.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "malus/core/vec.h"

namespace malus::gltf {

/// The codes of glTF.
enum class Component : int {
    kInt8 = 5120,
    kUint8 = 5121,
    kInt16 = 5122,
    kUint16 = 5123,
    kUint32 = 5125,
    kFloat = 5126
};

/// A bufferView from an accessor's byteOffset on.
struct BufferSlice {
    std::span<const unsigned char> bytes;  ///< of the whole bufferView
    std::uint64_t offset = 0;
    std::uint64_t stride = 0;  ///< bytes from element to element; 0: tightly packed
};

struct Sparse {
    std::uint64_t count = 0;
    Component index_type = Component::kUint8;
    BufferSlice indices, values;
};

struct Accessor {
    std::string place;  ///< for messages, e.g. "accessors[3]"
    Component type = Component::kFloat;
    bool normalized = false;
    int components = 1;  ///< of one element
    std::uint64_t count = 0;
    std::optional<BufferSlice> view;
    std::optional<Sparse> sparse;
};

/// Throws Error unless every byte and every sparse index is in range. Decode only what passed.
void check_ranges(const Accessor& accessor);

/// An accessor of three components.
std::vector<Vec3f> read_vectors(const Accessor& accessor);

/// An accessor of one unsigned integer component.
std::vector<std::uint32_t> read_integers(const Accessor& accessor);

/// The largest value of an unsigned integer type; as an index it means primitive restart.
std::uint32_t largest(Component type);

}  // namespace malus::gltf
