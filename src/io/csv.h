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

/// The cells of a line, blanks included.
std::vector<std::string_view> csv_cells(std::string_view line);

/// The numbers of a line. Throws Error at `place` unless there are `columns` of them; `names` says
/// which, where the message should.
std::vector<double> csv_numbers(std::string_view line, std::size_t columns,
                                const std::string& place, const std::string& names = {});

/// "file: line 7".
std::string csv_place(const std::string& file, int number);

/// Calls `line(text, number)` for each line that is neither empty nor a comment (#); numbers count
/// every line from 1.
void for_each_csv_line(const std::string& text,
                       const std::function<void(const std::string& line, int number)>& line);

}  // namespace malus
