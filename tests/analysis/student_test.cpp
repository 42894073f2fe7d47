// student_test.cpp — Student's t against closed forms and printed tables.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/student.h"

#include <cmath>
#include <numbers>

#include "support/catch.h"

using namespace malus;

TEST_CASE("Student: one, two and many degrees of freedom have closed forms") {
    for (double x : {0.0, 0.1, 1.0, 3.0, 50.0, 1e4}) {
        CAPTURE(x);
        // Cauchy's distribution: 1 − (2/π) atan x = (2/π) atan(1/x).
        const double cauchy = 2 / std::numbers::pi * std::atan2(1, x);
        CHECK(student_tail(x, 1) == Approx(cauchy).epsilon(1e-10));
        // 1 − x/√(2 + x²), without the cancellation.
        const double root = std::sqrt(2 + x * x);
        CHECK(student_tail(x, 2) == Approx(2 / (root * (root + x))).epsilon(1e-10));
    }
    CHECK(student_tail(5, 1e6) == Approx(std::erfc(5 / std::sqrt(2))).epsilon(1e-3));
    CHECK(student_tail(HUGE_VAL, 7) == 0);
}

TEST_CASE("Student: limits of Abramowitz and Stegun, table 26.10") {
    // A = 1 − p: two-sided; three decimals are printed.
    CHECK(student_limit(0.05, 7) == near(2.365, 5e-4));
    CHECK(student_limit(0.05, 14) == near(2.145, 5e-4));
    CHECK(student_limit(0.01, 7) == near(3.499, 5e-4));
    CHECK(student_limit(0.001, 7) == near(5.408, 5e-4));
    CHECK(student_limit(0.001, 14) == near(4.140, 5e-4));
    CHECK(student_limit(0.01, 60) == near(2.660, 5e-4));
}

TEST_CASE("Student: the table of limits is the limit, for any degrees of freedom") {
    for (double p : {0.01, 1e-6, 1e-10}) {
        const StudentLimits limits(p);
        for (double degrees : {3.0, 7.0, 7.7, 12.3, 14.0, 100.0, 5000.0})
            CHECK(limits(degrees) == Approx(student_limit(p, degrees)).epsilon(1e-3));
        CHECK(student_tail(limits(9.5), 9.5) == Approx(p).epsilon(0.02));
    }
}

TEST_CASE("Student: degrees of freedom of two errors together, by Welch and Satterthwaite") {
    CHECK(welch_degrees(1, 7, 1, 7) == near(14, 1e-12));
    CHECK(welch_degrees(1, 7, 0, 7) == near(7, 1e-12));
    // (1 + 3)²/(1/7 + 9/31)
    CHECK(welch_degrees(1, 7, 3, 31) == near(16 / (1.0 / 7 + 9.0 / 31), 1e-12));
    CHECK(welch_degrees(0, 7, 0, 31) == 7);
}
