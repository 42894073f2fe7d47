// error.h — the one exception for what the user can mend, and help with misspelt names.
//
// Text   "place: problem (why) remedy", one line, e.g.
//        paints.json: green_paint: row 2: unknown key 'sigmma'; did you mean 'sigma'?
// Who    only io and constructors throw it; main alone catches it, prints one line, exits 1.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace malus {

/// A file, scene or option that the user has to mend. what() is one line for a person.
class Error : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// "; did you mean 'X'?" for the known name nearest to `name` in edit distance, or, when none is
/// near, "; known: 'A', 'B', …" (at most eight). Empty when `known` is empty.
std::string suggest(const std::string& name, const std::vector<std::string>& known);

/// `text` made fit for one line of a message: control characters and bytes that are not valid
/// UTF-8 become '?', and what is longer than `most` bytes is cut and ends in "…".
std::string one_line(const std::string& text, std::size_t most = 160);

}  // namespace malus
