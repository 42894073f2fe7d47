// digest.h — a short mark of many numbers, by which they are known again. Not for secrets.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "malus/core/sampler.h"

namespace malus {

class Digest {
  public:
    void add(std::uint64_t value) { state_ = hash(state_, value); }
    /// 16 hexadecimal digits, which depend on each value and their order.
    std::string text() const {
        char digits[17];
        std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(state_));
        return digits;
    }

  private:
    std::uint64_t state_ = 0;
};

}  // namespace malus
