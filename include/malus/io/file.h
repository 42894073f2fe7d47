// file.h — output files that appear whole or not at all.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

namespace malus {

/// Calls `write` with a name beside `path`, then renames that file to `path`. When anything fails
/// the half-written file is removed and nothing that stood at `path` is lost. Throws Error.
void write_whole(const std::filesystem::path& path,
                 const std::function<void(const std::filesystem::path&)>& write);

/// Throws Error unless a file could be written at `path`: to be called before long work.
void check_writable(const std::filesystem::path& path);

/// Throws Error if the output is the same file as one of the others (inputs or other outputs).
void check_distinct(const std::filesystem::path& output,
                    const std::vector<std::filesystem::path>& others);

/// Of all outputs of a command, of which empty names are not asked for: both checks, also against each
/// other.
void check_outputs(const std::vector<std::filesystem::path>& inputs,
                   std::initializer_list<std::string> outputs);

/// The whole of a text file. Throws Error when it is missing, not a regular file or over 1 GiB.
std::string read_text(const std::filesystem::path& path);

/// write_whole with these bytes.
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace malus
