// gltf_error.h — how the glTF reader says what is wrong: "place: problem; remedy".
//
// Place  as in JSON, e.g. accessors[3].count; empty when it is the file as a whole. read_gltf puts
//        the file's name in front.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "malus/core/error.h"

namespace malus::gltf {

/// Text that comes from the file goes into `problem` through one_line() only.
[[noreturn]] inline void fail(const std::string& place, const std::string& problem,
                              const std::string& remedy = "re-export the scene") {
    throw Error((place.empty() ? "" : place + ": ") + problem + "; " + remedy);
}

/// "meshes[3]": one entry of a list.
inline std::string entry(const std::string& list, std::size_t i) {
    return list + "[" + std::to_string(i) + "]";
}

}  // namespace malus::gltf
