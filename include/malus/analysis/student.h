// student.h — Student's t: how often noise alone gives so large a ratio of a difference to its error.
//
//   P(|t| > x) = I(ν/(ν + x²); ν/2, 1/2),  I the regularized incomplete beta function, ν degrees of freedom
//   Welch and Satterthwaite: of √(e_a² + e_b²)   ν = (e_a² + e_b²)²/(e_a⁴/ν_a + e_b⁴/ν_b)
//
// Source  Abramowitz & Stegun 26.5.8, 26.7.1; Welch, Biometrika 34, 28 (1947).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace malus {

/// P(|t| > x), x ≥ 0, for `degrees` > 0 of freedom; to 1e-10 of itself.
double student_tail(double x, double degrees);

/// What |t| exceeds with probability `p` in (0,1), for `degrees` of freedom; to 1e-9 of itself.
double student_limit(double p, double degrees);

/// student_limit() of one p for many degrees of freedom of at least 1: from a table, to 1e-3 of itself.
class StudentLimits {
  public:
    explicit StudentLimits(double p);
    double operator()(double degrees) const;

  private:
    std::vector<double> log_limits_;  // at equal steps of 1/ν from 0 to 1
};

/// Degrees of freedom of e_a² + e_b², variances with ν_a and ν_b of their own; the smaller of both
/// where there is no variance.
double welch_degrees(double variance_a, double degrees_a, double variance_b, double degrees_b);

}  // namespace malus
