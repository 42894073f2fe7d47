// csv.cpp — CSV as other programs write it: blanks, CRLF and a byte order mark allowed.
// SPDX-License-Identifier: Apache-2.0
#include "io/csv.h"

#include <charconv>
#include <sstream>

#include "malus/core/error.h"

namespace malus {

double number_in(std::string_view text, const std::string& place) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    double x = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), x);
    if (text.empty() || read.ec != std::errc() || read.ptr != text.data() + text.size())
        throw Error(place + ": '" + one_line(std::string(text), 40) + "' is not a number");
    return x;
}

std::vector<std::string_view> csv_cells(std::string_view line) {
    std::vector<std::string_view> cells;
    for (std::size_t start = 0;;) {
        const std::size_t end = std::min(line.find(',', start), line.size());
        cells.push_back(line.substr(start, end - start));
        if (end == line.size()) return cells;
        start = end + 1;
    }
}

std::vector<double> csv_numbers(std::string_view line, std::size_t columns,
                                const std::string& place, const std::string& names) {
    std::vector<double> numbers;
    for (std::string_view cell : csv_cells(line)) numbers.push_back(number_in(cell, place));
    if (numbers.size() != columns)
        throw Error(place + ": " + std::to_string(numbers.size()) + " columns instead of " +
                    std::to_string(columns) + (names.empty() ? "" : " (" + names + ")"));
    return numbers;
}

std::string csv_place(const std::string& file, int number) {
    return file + ": line " + std::to_string(number);
}

void for_each_csv_line(const std::string& text,
                       const std::function<void(const std::string& line, int number)>& line) {
    std::istringstream lines(text);
    int number = 0;
    for (std::string one; std::getline(lines, one);) {
        ++number;
        while (!one.empty() && (one.back() == '\r' || one.back() == ' ')) one.pop_back();
        if (number == 1 && one.starts_with("\xEF\xBB\xBF")) one.erase(0, 3);
        if (!one.empty() && one.front() != '#') line(one, number);
    }
}

}  // namespace malus
