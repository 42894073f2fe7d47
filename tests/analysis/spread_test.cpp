// spread_test.cpp — moments by hand, and Gaussians of known truth and noise.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/spread.h"

#include "support/catch.h"
#include "support/statistics.h"

using namespace malus;

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Box and Muller's normal deviates.
class Normal {
  public:
    explicit Normal(unsigned seed) : u_(seed) {}
    double operator()() {
        return std::sqrt(-2 * std::log(u_())) * std::cos(2 * 3.14159265358979 * u_());
    }

  private:
    Uniform u_;
};

// Normal truths of this deviation about `middle`, each moved by an error of its own: σ of one half
// of the values is `small`, of the other `large`.
struct Noisy {
    std::vector<float> values, errors;
};
Noisy noisy(unsigned seed, int n, double middle, double truth, double small, double large) {
    Normal normal(seed);
    Noisy all;
    for (int i = 0; i < n; ++i) {
        const double error = i % 2 ? small : large;
        all.values.push_back(static_cast<float>(middle + truth * normal() + error * normal()));
        all.errors.push_back(static_cast<float>(error));
    }
    return all;
}

Mask all_of(const std::vector<float>& values) {
    return Mask(values.size(), 1);
}

}  // namespace

TEST_CASE("Spread: mean, median and deviation by hand, of finite values in the mask only") {
    const std::vector<float> values{2, 4, 4, 4, 5, 5, 7, 9, 100, kNaN, kInfinity};
    Mask mask = all_of(values);
    mask[8] = 0;
    const Spread s = spread(values, mask);
    CHECK(s.count == 8);
    CHECK(s.mean == near(5, 1e-12));
    CHECK(s.median == 4.5);
    CHECK(s.deviation == near(std::sqrt(32.0 / 7), 1e-12));  // squares 9+1+1+1+0+0+4+16
    const Spread one = spread(std::vector<float>{3}, Mask{1});
    CHECK(one.mean == 3);
    CHECK(std::isnan(one.deviation));
    const Spread none = spread(values, Mask(values.size(), 0));
    CHECK(none.count == 0);
    CHECK(std::isnan(none.mean));
    CHECK(std::isnan(none.median));
}

TEST_CASE("Spread: angles on both sides of 0 have their mean there") {
    const std::vector<float> angles{170, 10};
    const Spread s = spread(angles, all_of(angles), 180);
    CHECK(std::abs(difference(s.mean, 0, 180)) < 1e-6);
    CHECK(s.mean >= 0);
    CHECK(s.mean < 180);
    CHECK(std::abs(difference(s.median, 0, 180)) < 1e-6);
    // R = cos 20° of the doubled angles.
    CHECK(
        s.deviation ==
        near(90 / std::acos(-1.0) * std::sqrt(-2 * std::log(std::cos(std::acos(-1.0) / 9))), 1e-6));
    const std::vector<float> three{175, 1, 2};
    CHECK(spread(three, all_of(three), 180).median == near(1, 1e-4));
    const std::vector<float> across{0, 90};
    CHECK(spread(across, all_of(across), 180).deviation > 200);  // no direction but R = 6e-17
    const std::vector<float> equal{30, 30, 30};
    CHECK(spread(equal, all_of(equal), 180).deviation == near(0, 1e-5));
}

// Each variance of n values is known to √(2/n) of it; 4 such: one in 16 000 right programs fails.
TEST_CASE("Spread: of a noisy Gaussian the width falls into truth and noise", "[statistical]") {
    constexpr int n = 200000;
    const Noisy all = noisy(1, n, 0.4, 0.03, 0.02, 0.05);
    const NoiseShare s = noise_share(all.values, all.errors, all_of(all.values));
    const double noise2 = (0.02 * 0.02 + 0.05 * 0.05) / 2, truth2 = 0.03 * 0.03;
    CHECK(s.count == n);
    CHECK(s.noise == near(std::sqrt(noise2), 1e-6));
    const double relative = 4 * std::sqrt(2.0 / n) * 1.25;  // two widths mixed: kurtosis above 3
    CHECK(s.observed * s.observed == near(truth2 + noise2, relative * (truth2 + noise2)));
    CHECK(s.truth * s.truth == near(truth2, relative * (truth2 + noise2)));
    CHECK(s.of_variance == near(noise2 / (truth2 + noise2), relative));
}

TEST_CASE("Spread: of noisy angles, too, across 0 and with errors that wrap", "[statistical]") {
    constexpr int n = 200000;
    const Noisy all = noisy(2, n, 179, 12, 10, 40);
    const NoiseShare s = noise_share(all.values, all.errors, all_of(all.values), 180, 90);
    const auto shrinks = [](double deg) {
        return std::exp(-2 * std::pow(deg * std::acos(-1.0) / 180, 2));
    };
    // R of wrapped normals multiplies; of a mixture it is the mean.
    const double noise =
        90 / std::acos(-1.0) * std::sqrt(-2 * std::log((shrinks(10) + shrinks(40)) / 2));
    CHECK(s.noise == near(noise, 1e-4));
    // R is known to 1/√(2n) = 0.0016, here of 0.6: σ to 0.0016/0.6 · 28.6°²/σ = 0.07°; 4 of those
    // in the truth, which is less than half of σ.
    CHECK(s.observed == near(std::sqrt(12 * 12 + noise * noise), 0.3));
    CHECK(s.truth == near(12, 0.7));
    const Spread whole = spread(all.values, all_of(all.values), 180);
    CHECK(std::abs(difference(whole.mean, 179, 180)) < 0.5);
}

TEST_CASE("Spread: values of unknown error stay out, and noise that explains more is said so") {
    const std::vector<float> values{0, 2, 50, 60, 70}, errors{3, 3, 90, kNaN, 95};
    const NoiseShare s = noise_share(values, errors, all_of(values), 0, 90);
    CHECK(s.count == 2);
    CHECK(s.observed == near(std::sqrt(2.0), 1e-12));
    CHECK(s.noise == near(3, 1e-12));
    CHECK(s.truth == 0);
    CHECK(s.of_variance == near(4.5, 1e-12));
    const NoiseShare none = noise_share(values, errors, Mask(5, 0));
    CHECK(none.count == 0);
    CHECK(std::isnan(none.truth));
    Quantity q{"AoLP", 440, {}, {}, 180};
    CHECK(unknown_error(q) == 90);
    q = {"DoLP", 440, {}, {}, 0};
    CHECK(unknown_error(q) == 1);
    q.name = "S0";
    CHECK(std::isinf(unknown_error(q)));
}
