// scores_test.cpp — the yardstick of the z-scores.
// SPDX-License-Identifier: Apache-2.0
#include "support/scores.h"

#include "support/catch.h"

using namespace malus;

TEST_CASE("Student's t: its 97.5 % quantiles are those of the tables") {
    // To the last digit of tables such as R's qt(0.975, n), and the normal distribution's.
    CHECK(student95(7) == near(2.3646, 1e-3));
    CHECK(student95(14) == near(2.1448, 1e-3));
    CHECK(student95(20) == near(2.0860, 1e-3));
    CHECK(student95(60) == near(2.0003, 1e-3));
    CHECK(student95(1e9) == near(1.960, 1e-4));
}
