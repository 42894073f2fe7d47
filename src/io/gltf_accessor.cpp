// gltf_accessor.cpp — bounds, sparse elements and component types of accessors.
//
// Bytes are copied out with memcpy: nothing promises that they are aligned.
// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_accessor.h"

#include <algorithm>
#include <cstring>

#include "io/gltf_error.h"
#include "malus/core/contract.h"

namespace malus::gltf {
namespace {

std::uint64_t size_of(Component type) {
    switch (type) {
        case Component::kInt8:
        case Component::kUint8:
            return 1;
        case Component::kInt16:
        case Component::kUint16:
            return 2;
        case Component::kUint32:
        case Component::kFloat:
            return 4;
    }
    return 4;
}

std::uint64_t element_size(const Accessor& accessor) {
    return size_of(accessor.type) * static_cast<std::uint64_t>(accessor.components);
}

template <class T>
T copied(const unsigned char* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

const unsigned char* at(const BufferSlice& view, std::uint64_t i, std::uint64_t size) {
    return view.bytes.data() + view.offset + i * (view.stride != 0 ? view.stride : size);
}

std::uint32_t read_unsigned(const unsigned char* bytes, Component type) {
    if (type == Component::kUint8) return *bytes;
    if (type == Component::kUint16) return copied<std::uint16_t>(bytes);
    EXPECT(type == Component::kUint32);
    return copied<std::uint32_t>(bytes);
}

float read_float(const unsigned char* bytes, Component type, bool normalized) {
    const auto scaled = [normalized](auto value, float most) {
        const auto x = static_cast<float>(value);
        return normalized ? std::max(x / most, -1.0f) : x;
    };
    switch (type) {
        case Component::kInt8:
            return scaled(copied<std::int8_t>(bytes), 127.0f);
        case Component::kUint8:
            return scaled(*bytes, 255.0f);
        case Component::kInt16:
            return scaled(copied<std::int16_t>(bytes), 32767.0f);
        case Component::kUint16:
            return scaled(copied<std::uint16_t>(bytes), 65535.0f);
        case Component::kUint32:
            return scaled(copied<std::uint32_t>(bytes), 4294967295.0f);
        case Component::kFloat:
            break;
    }
    return copied<float>(bytes);
}

void check_view(const BufferSlice& view, std::uint64_t count, std::uint64_t size,
                const std::string& place) {
    const std::uint64_t stride = view.stride != 0 ? view.stride : size;
    if (stride < size)
        fail(place, "bufferView's stride " + std::to_string(stride) +
                        " is less than the element's " + std::to_string(size) + " bytes");
    const std::uint64_t end = view.offset + stride * (count - 1) + size;
    if (end > view.bytes.size())
        fail(place, "reads to byte " + std::to_string(end) + " of a bufferView of " +
                        std::to_string(view.bytes.size()) + " bytes (count out of range)");
}

void check_sparse(const Accessor& accessor) {
    const Sparse& sparse = *accessor.sparse;
    const std::string place = accessor.place + ".sparse";
    if (sparse.count == 0 || sparse.count > accessor.count)
        fail(place + ".count", std::to_string(sparse.count) +
                                   " is not from 1 to the accessor's count " +
                                   std::to_string(accessor.count));
    if (sparse.index_type != Component::kUint8 && sparse.index_type != Component::kUint16 &&
        sparse.index_type != Component::kUint32)
        fail(place + ".indices.componentType", "is not an unsigned integer");
    const std::uint64_t index_size = size_of(sparse.index_type);
    check_view(sparse.indices, sparse.count, index_size, place + ".indices");
    check_view(sparse.values, sparse.count, element_size(accessor), place + ".values");
    std::uint64_t next = 0;
    for (std::uint64_t k = 0; k < sparse.count; ++k) {
        const auto index = read_unsigned(at(sparse.indices, k, index_size), sparse.index_type);
        if (index >= accessor.count)
            fail(place, "index " + std::to_string(index) + " is out of range (the accessor has " +
                            std::to_string(accessor.count) + " elements)");
        if (index < next)
            fail(place, "index " + std::to_string(index) + " does not increase on the one before");
        next = std::uint64_t{index} + 1;
    }
}

// Calls put(i, bytes) for each element that has bytes, in such an order that the last one counts.
template <class Put>
void visit_elements(const Accessor& accessor, Put put) {
    const std::uint64_t size = element_size(accessor);
    if (accessor.view)
        for (std::uint64_t i = 0; i < accessor.count; ++i) put(i, at(*accessor.view, i, size));
    if (!accessor.sparse) return;
    const Sparse& sparse = *accessor.sparse;
    for (std::uint64_t k = 0; k < sparse.count; ++k)
        put(read_unsigned(at(sparse.indices, k, size_of(sparse.index_type)), sparse.index_type),
            at(sparse.values, k, size));
}

}  // namespace

void check_ranges(const Accessor& accessor) {
    if (accessor.count == 0)
        fail(accessor.place + ".count", "is 0, an empty accessor makes no triangle");
    if (accessor.view)
        check_view(*accessor.view, accessor.count, element_size(accessor), accessor.place);
    if (accessor.sparse) check_sparse(accessor);
}

std::vector<Vec3f> read_vectors(const Accessor& accessor) {
    EXPECT(accessor.components == 3);
    std::vector<Vec3f> vectors(accessor.count);
    const std::uint64_t step = size_of(accessor.type);
    visit_elements(accessor, [&](std::uint64_t i, const unsigned char* bytes) {
        vectors[i] = {read_float(bytes, accessor.type, accessor.normalized),
                      read_float(bytes + step, accessor.type, accessor.normalized),
                      read_float(bytes + 2 * step, accessor.type, accessor.normalized)};
    });
    return vectors;
}

std::vector<std::uint32_t> read_integers(const Accessor& accessor) {
    EXPECT(accessor.components == 1);
    std::vector<std::uint32_t> integers(accessor.count);
    visit_elements(accessor, [&](std::uint64_t i, const unsigned char* bytes) {
        integers[i] = read_unsigned(bytes, accessor.type);
    });
    return integers;
}

std::uint32_t largest(Component type) {
    if (type == Component::kUint8) return 0xFF;
    return type == Component::kUint16 ? 0xFFFF : 0xFFFFFFFF;
}

}  // namespace malus::gltf
