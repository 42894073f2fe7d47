// gltf_schema.h — checks every JSON value that this reader uses for type, range and reference.
//
// The results are new JSON with the checked values alone, whole numbers written as such.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace malus::gltf {

using Json = nlohmann::json;

/// Most entries of a list: each costs the library about 600 bytes.
inline constexpr std::size_t kMostEntries = std::size_t{1} << 19;

/// The number if it is whole and from 0 to 2³¹−1. 48.0 is a legal way to write 48.
std::optional<std::int64_t> as_whole(const Json& value);

/// A value as messages show it.
std::string shown(const Json& value);

/// Throws Error unless each list at the root of a glTF file is one.
void check_lists(const Json& root);

/// Everything but buffers, which come from files, and cameras, which matter less than those.
Json checked_contents(const Json& root);

Json checked_cameras(const Json& root);

}  // namespace malus::gltf
