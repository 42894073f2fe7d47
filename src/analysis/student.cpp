// student.cpp — the incomplete beta function by its continued fraction; its inverse by bisection.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/student.h"

#include <algorithm>
#include <cmath>

#include "malus/core/contract.h"

namespace malus {
namespace {

// The continued fraction of A&S 26.5.8 for I_x(a, b), evaluated by Lentz's method.
double beta_fraction(double x, double a, double b) {
    constexpr double kTiny = 1e-300;
    const auto kept = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
    double c = 1, d = 1 / kept(1 - (a + b) * x / (a + 1)), result = d;
    for (int m = 1; m < 10000; ++m) {
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        d = 1 / kept(1 + even * d);
        c = kept(1 + even / c);
        result *= d * c;
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / kept(1 + odd * d);
        c = kept(1 + odd / c);
        result *= d * c;
        if (std::abs(d * c - 1) < 1e-14) break;
    }
    return result;
}

// I_x(a, b), y = 1 − x: of both fractions the one that converges.
double incomplete_beta(double x, double y, double a, double b) {
    if (x <= 0) return 0;
    if (y <= 0) return 1;
    const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                  a * std::log(x) + b * std::log(y));
    if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(x, a, b) / a;
    return 1 - front * beta_fraction(y, b, a) / b;
}

constexpr std::size_t kSteps = 256;
constexpr double kMostDegrees = 1e6;  // a normal distribution to 1e-5

}  // namespace

double student_tail(double x, double degrees) {
    EXPECT(x >= 0 && degrees > 0);
    const double square = x * x;
    if (std::isinf(square)) return 0;
    const double all = degrees + square;
    return incomplete_beta(degrees / all, square / all, degrees / 2, 0.5);
}

double student_limit(double p, double degrees) {
    EXPECT(p > 0 && p < 1);
    double low = -80, high = 300;  // ln x
    while (high - low > 1e-10) {
        const double middle = (low + high) / 2;
        (student_tail(std::exp(middle), degrees) > p ? low : high) = middle;
    }
    return std::exp((low + high) / 2);
}

StudentLimits::StudentLimits(double p) {
    for (std::size_t i = 0; i <= kSteps; ++i) {
        const double share = static_cast<double>(i) / kSteps;
        log_limits_.push_back(std::log(student_limit(p, 1 / std::max(share, 1 / kMostDegrees))));
    }
}

double StudentLimits::operator()(double degrees) const {
    const double at = std::min(1.0, 1 / degrees) * kSteps;
    const auto below = std::min(static_cast<std::size_t>(at), kSteps - 1);
    const double above = at - static_cast<double>(below);
    return std::exp((1 - above) * log_limits_[below] + above * log_limits_[below + 1]);
}

double welch_degrees(double a, double degrees_a, double b, double degrees_b) {
    if (!(a + b > 0)) return std::min(degrees_a, degrees_b);
    const double share = a / (a + b);
    return 1 / (share * share / degrees_a + (1 - share) * (1 - share) / degrees_b);
}

}  // namespace malus
