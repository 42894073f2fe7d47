// program.h — runs malus as a shell would.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace malus {

struct Outcome {
    int exit_code;  ///< minus the number of the signal that ended it
    std::string out, err;
    /// A message is one line: text, newline, nothing else.
    bool one_line() const { return !err.empty() && err.find('\n') == err.size() - 1; }
};

/// Runs malus with these arguments.
Outcome run(const std::string& arguments);

/// In quotes, as one word of the arguments.
std::string quoted(const std::string& word);

/// A file of this repository, quoted.
std::string shipped(const std::string& file);

/// The arguments of a small render of the shipped panel.
std::string small_render(const std::string& out, const std::string& more = "",
                         const std::string& size = "--width 8 --height 8 --spp 8");

/// Checks that it fails with exit 1 and one line that holds these words, and leaves no image.
void check_fails(const std::string& arguments, const std::filesystem::path& image,
                 const std::vector<std::string>& words);

}  // namespace malus
