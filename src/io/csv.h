// csv.h — lines and numbers of CSV files, independent of the locale.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace malus {

/// Throws Error at `place` unless the whole text, but for blanks around it, is a number.
double number_in(std::string_view text, const std::string& place);

/// The numbers of a line. Throws Error at `place` unless there are `columns` of them.
std::vector<double> csv_numbers(std::string_view line, std::size_t columns,
                                const std::string& place);

/// Calls `line(text, place)` for each line that is neither empty nor a comment (#); place is
/// "file: line 7".
void for_each_csv_line(
    const std::string& text, const std::string& file,
    const std::function<void(const std::string& line, const std::string& place)>& line);

}  // namespace malus
