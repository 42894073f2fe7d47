// statistics.h — tests of samples against what they should be.
//
// Random numbers are seeded, so a test's outcome never changes by itself; the false-alarm rates say
// how likely a right program was to fail when the seed was chosen.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <random>
#include <vector>

namespace malus {

/// Uniform numbers in (0,1).
class Uniform {
  public:
    explicit Uniform(unsigned seed) : engine_(seed) {}
    double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53 + 0x1p-54; }

  private:
    std::mt19937_64 engine_;
};

/// z-score of a χ² statistic with `degrees` of freedom: Wilson and Hilferty's cube root (1931).
inline double chi2_z(double chi2, double degrees) {
    const double spread = 2 / (9 * degrees);
    return (std::cbrt(chi2 / degrees) - (1 - spread)) / std::sqrt(spread);
}

/// z-score of counts against expected counts (same total); cells expecting fewer than 5 are pooled.
inline double chi2_z(const std::vector<double>& counts, const std::vector<double>& expected) {
    double chi2 = 0, cells = 0, pooled_count = 0, pooled_expected = 0;
    const auto add = [&](double count, double mean) {
        chi2 += (count - mean) * (count - mean) / mean;
        cells += 1;
    };
    for (std::size_t i = 0; i < counts.size(); ++i) {
        if (expected[i] >= 5) {
            add(counts[i], expected[i]);
        } else {
            pooled_count += counts[i];
            pooled_expected += expected[i];
        }
    }
    if (pooled_expected > 5) add(pooled_count, pooled_expected);
    return chi2_z(chi2, cells - 1);
}

}  // namespace malus
