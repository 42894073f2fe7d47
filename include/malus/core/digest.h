// digest.h — a short mark of many numbers, by which they are known again. Not for secrets.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "malus/core/sampler.h"

namespace malus {

class Digest {
  public:
    void add(std::uint64_t value) { state_ = hash(state_, value); }
    /// Numbers of 32 bits or fewer. One after another they would each wait for the one before: every eighth
    /// goes to a mark of its own, side by side, and the mark is of these eight and the count.
    template <class Number, class Allocator>
    void add_all(const std::vector<Number, Allocator>& numbers) {
        std::array<Digest, 8> marks;
        std::size_t i = 0;
        for (; i + marks.size() <= numbers.size(); i += marks.size())
            for (std::size_t k = 0; k < marks.size(); ++k) marks[k].add(bits(numbers[i + k]));
        for (; i < numbers.size(); ++i) marks[0].add(bits(numbers[i]));
        add(numbers.size());
        for (const Digest& mark : marks) add(mark.state_);
    }
    /// 16 hexadecimal digits, which depend on each value and their order.
    std::string text() const {
        char digits[17];
        std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(state_));
        return digits;
    }

  private:
    static std::uint64_t bits(float x) { return std::bit_cast<std::uint32_t>(x); }
    static std::uint64_t bits(std::uint32_t n) { return n; }
    static std::uint64_t bits(std::int32_t n) { return static_cast<std::uint32_t>(n); }
    static std::uint64_t bits(std::uint8_t n) { return n; }

    std::uint64_t state_ = 0;
};

}  // namespace malus
