// digest_test.cpp — marks of many numbers.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/digest.h"

#include <set>

#include "support/catch.h"

using namespace malus;

namespace {

std::string mark_of(const std::vector<std::uint32_t>& numbers) {
    Digest digest;
    digest.add_all(numbers);
    return digest.text();
}

}  // namespace

TEST_CASE("Digest: of many numbers, each one, its place and their count count") {
    // 21: registers of eight and a rest. By chance two of the marks are alike once in 1e15 such tests.
    std::vector<std::uint32_t> numbers(21);
    for (std::uint32_t i = 0; i < numbers.size(); ++i) numbers[i] = 7 * i;
    std::set<std::string> marks{mark_of(numbers)};
    CHECK(mark_of(numbers) == *marks.begin());
    std::size_t made = 1;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        std::vector<std::uint32_t> changed = numbers;
        changed[i] ^= 1u << 31;
        marks.insert(mark_of(changed));
        ++made;
        for (std::size_t other = 0; other < i; ++other, ++made) {
            std::vector<std::uint32_t> swapped = numbers;
            std::swap(swapped[i], swapped[other]);
            marks.insert(mark_of(swapped));
        }
    }
    std::vector<std::uint32_t> longer = numbers;
    longer.push_back(0);
    marks.insert(mark_of(longer)), ++made;
    CHECK(marks.size() == made);
}

TEST_CASE("Digest: floats are marked by their bits") {
    Digest plus, minus, bits;
    plus.add_all(std::vector<float>{0.f, 1.f});
    minus.add_all(std::vector<float>{-0.f, 1.f});
    bits.add_all(std::vector<std::uint32_t>{0, 0x3f800000});  // IEEE 754
    CHECK(plus.text() == bits.text());
    CHECK(plus.text() != minus.text());
}
