// gltf_file.h — the bytes a glTF scene asks for, from places where it may ask.
//
// Files  only regular ones (a pipe would block for ever, a folder or device has no size), only
//        inside the scene's folder after all links are resolved, and only up to a size limit.
// URIs   RFC 3986 relative paths, percent-decoded; RFC 2397 data URIs, base64 or plain.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace malus::gltf {

using Bytes = std::vector<unsigned char>;

/// The whole of a regular file of at most `most` bytes; `place` is what messages point at.
Bytes read_regular_file(const std::filesystem::path& path, std::size_t most,
                        const std::string& place);

/// What a buffer's URI stands for: data in the URI itself or a file inside `folder`.
Bytes read_uri(const std::string& uri, const std::filesystem::path& folder, std::size_t most,
               const std::string& place);

}  // namespace malus::gltf
