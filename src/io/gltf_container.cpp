// gltf_container.cpp — GLB chunks, and a scan of the JSON text before it is parsed.
// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_container.h"

#include <cstdint>
#include <cstring>
#include <string_view>

#include "io/gltf_error.h"

namespace malus::gltf {
namespace {

constexpr std::uint64_t kHeaderBytes = 12;
constexpr std::uint64_t kChunkHeaderBytes = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN\0"
constexpr int kDeepest = 200;
// About 100 bytes a value when parsed, and two parsers see them: less than 2 GB together.
constexpr std::size_t kMostMarks = 8'000'000;
// The parser holds a long string (a data URI) up to four times while it reads it.
constexpr std::size_t kMostText = std::size_t{512} << 20;

struct Chunk {
    std::uint32_t type = 0;
    std::size_t begin = 0, size = 0;  // of the data, in the file
};

std::uint32_t little_endian_32(const Bytes& file, std::uint64_t at) {
    std::uint32_t value = 0;
    for (std::uint64_t i = 4; i-- > 0;) value = value << 8 | file[at + i];
    return value;
}

std::uint64_t checked_glb_length(const Bytes& file) {
    if (file.size() < kHeaderBytes + kChunkHeaderBytes)
        fail("GLB", "file is truncated (" + std::to_string(file.size()) + " bytes)");
    const std::uint32_t version = little_endian_32(file, 4);
    if (version != 2)
        fail("GLB",
             "container version " + std::to_string(version) + (version == 1 ? " (glTF 1.0)" : "") +
                 " is not supported",
             "export it as glTF 2.0");
    const std::uint64_t length = little_endian_32(file, 8);
    if (length > file.size())
        fail("GLB", "header's length " + std::to_string(length) + " exceeds the file's " +
                        std::to_string(file.size()) + " bytes (truncated?)");
    if (length < kHeaderBytes + kChunkHeaderBytes)
        fail("GLB", "header's length " + std::to_string(length) + " leaves no room for a chunk");
    return length;
}

// All chunks, each known to lie inside the file. Sums are of 64 bits and so cannot wrap.
std::vector<Chunk> find_chunks(const Bytes& file) {
    const std::uint64_t length = checked_glb_length(file);
    std::vector<Chunk> chunks;
    for (std::uint64_t at = kHeaderBytes; at < length;) {
        const std::string place = "GLB: " + entry("chunk", chunks.size());
        if (at + kChunkHeaderBytes > length)
            fail(place, "header exceeds the file's length (truncated?)");
        const std::uint64_t size = little_endian_32(file, at);
        if (at + kChunkHeaderBytes + size > length)
            fail(place,
                 "length " + std::to_string(size) + " exceeds the file's length (truncated?)");
        chunks.push_back({little_endian_32(file, at + 4),
                          static_cast<std::size_t>(at + kChunkHeaderBytes),
                          static_cast<std::size_t>(size)});
        at += kChunkHeaderBytes + size;
    }
    return chunks;
}

Container open_glb(Bytes file) {
    const std::vector<Chunk> chunks = find_chunks(file);
    if (chunks[0].type != kJsonChunk) fail("GLB: chunk[0]", "first chunk's type is not JSON");
    Container container;
    container.text.assign(reinterpret_cast<const char*>(file.data()) + chunks[0].begin,
                          chunks[0].size);
    if (chunks.size() > 1 && chunks[1].type == kBinChunk) {  // others are to be ignored
        file.resize(chunks[1].begin + chunks[1].size);
        file.erase(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(chunks[1].begin));
        container.bin = std::move(file);
    }
    return container;
}

// Counts brackets and separators outside strings; whether they match is the parser's business.
void scan_structure(std::string_view text) {
    if (text.size() > kMostText)
        fail("JSON", "text is too large for the memory limit", "export the scene as .glb");
    int depth = 0;
    std::size_t marks = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '"') in_string = !in_string;
        if (in_string) {
            if (c == '\\') ++i;
            continue;
        }
        const bool opens = c == '{' || c == '[', closes = c == '}' || c == ']';
        depth += opens ? 1 : closes ? -1 : 0;
        marks += opens || closes || c == ',' || c == ':' ? 1 : 0;
        if (depth > kDeepest)
            fail("JSON", "nested deeper than " + std::to_string(kDeepest) + " levels",
                 "remove deep extras");
        if (marks > kMostMarks)
            fail("JSON", "too many values for the memory limit", "split the scene");
    }
}

}  // namespace

Container open_container(Bytes file) {
    Container container;
    if (file.size() >= 4 && std::memcmp(file.data(), "glTF", 4) == 0) {
        container = open_glb(std::move(file));
    } else {
        container.text.assign(file.begin(), file.end());
    }
    scan_structure(container.text);
    return container;
}

}  // namespace malus::gltf
