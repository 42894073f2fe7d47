// error.cpp — help with misspelt names; text made fit for one line.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/error.h"

#include <algorithm>
#include <numeric>

namespace malus {
namespace {

// Levenshtein distance: fewest insertions, deletions and replacements of one byte.
std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

// Length in bytes of the well-formed UTF-8 sequence at text[i], 0 if there is none.
std::size_t utf8_length(const std::string& text, std::size_t i) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
    const unsigned char lead = byte(i);
    const std::size_t length = lead < 0x80                    ? 1
                               : lead >= 0xC2 && lead <= 0xDF ? 2
                               : lead >= 0xE0 && lead <= 0xEF ? 3
                               : lead >= 0xF0 && lead <= 0xF4 ? 4
                                                              : 0;
    if (length == 0 || i + length > text.size()) return 0;
    for (std::size_t k = 1; k < length; ++k)
        if ((byte(i + k) & 0xC0) != 0x80) return 0;
    return length;
}

}  // namespace

std::string suggest(const std::string& name, const std::vector<std::string>& known) {
    if (known.empty()) return {};
    const auto nearest =
        std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
            return edit_distance(name, a) < edit_distance(name, b);
        });
    if (edit_distance(name, *nearest) <= std::max<std::size_t>(2, name.size() / 3))
        return "; did you mean '" + *nearest + "'?";
    std::string text = "; known: ";
    constexpr std::size_t kMost = 8;
    for (std::size_t i = 0; i < std::min(kMost, known.size()); ++i)
        text += (i ? ", '" : "'") + known[i] + "'";
    return known.size() > kMost ? text + ", …" : text;
}

std::string one_line(const std::string& text, std::size_t most) {
    std::string line;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = utf8_length(text, i);
        const bool plain = length > 1 || (length == 1 && text[i] >= 0x20 && text[i] != 0x7F);
        if (line.size() + std::max<std::size_t>(length, 1) > most) return line + "…";
        line += plain ? text.substr(i, length) : "?";
        i += std::max<std::size_t>(length, 1);
    }
    return line;
}

}  // namespace malus
