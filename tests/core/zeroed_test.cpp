// zeroed_test.cpp — arrays of zeros.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/zeroed.h"

#include "support/catch.h"

using namespace malus;

TEST_CASE("Zeroed: memory that others left behind is 0, copies and values are as of any vector") {
    for (std::size_t size : {1u, 1000u, 3000000u})
        for (int round = 0; round < 3; ++round) {
            ZeroedVector<float> numbers(size);
            bool all_zero = true;
            for (float x : numbers) all_zero &= x == 0;
            CHECK(all_zero);
            for (float& x : numbers) x = 7;  // for the next round to find
            ZeroedVector<float> copy = numbers;
            CHECK(copy == numbers);
            numbers[0] = 8;
            CHECK(copy[0] == 7);
        }
    CHECK(ZeroedVector<int>(3, 5) == ZeroedVector<int>{5, 5, 5});
}
