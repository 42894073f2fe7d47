// film.cpp — means, covariances and their propagation to DoLP and AoLP.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/film.h"

#include <algorithm>

namespace malus {
namespace {

// W m⁻² sr⁻¹ nm⁻¹; the covariance of fainter light is lost in floats, whose least is 1e-45.
constexpr double kFaintest = 1e-18;

enum Entry { k00, k01, k02, k11, k12, k22, k33 };

// How much more the error of a ratio is than first-order propagation says when few replicates carry
// the light: DoLP is then a weighted mean of few, and pulled toward the very ones that are to tell
// its spread. Kish's effective number m of replicates; 1 when all weigh the same, infinite below
// m = 2.
double widening(const PixelStokes& pixel) {
    const double R = static_cast<double>(pixel.replicates);
    const double spread = static_cast<double>(pixel.covariance[k00]) / sqr(pixel.mean.s0);
    const double m = R / (1 + (R - 1) * spread);
    return m < 2 ? HUGE_VAL : std::sqrt((R - 1) / R * m / (m - 1));
}

}  // namespace

Stokes<double> held_physical(const Stokes<double>& S, double noise) {
    constexpr double kRoundings = 1e-5, kFloat = 0x1p-22;
    const double polarized = std::hypot(S.s1, S.s2, S.s3), most = (1 - kFloat) * S.s0;
    if (polarized <= most || polarized > (1 + kRoundings) * S.s0 + noise) return S;
    if (S.s0 <= 0) return {};
    const double shrink = most / polarized;
    return {S.s0, shrink * S.s1, shrink * S.s2, shrink * S.s3};
}

double relative_stderr_s0(const PixelStokes& pixel) {
    if (!(pixel.mean.s0 > 0)) return pixel.covariance[k00] > 0 ? 1 : 0;
    return std::sqrt(static_cast<double>(pixel.covariance[k00])) / pixel.mean.s0;
}

double stderr_dolp(const PixelStokes& pixel) {
    const Stokes<double>& S = pixel.mean;
    if (!(S.s0 > 0)) return pixel.covariance[k00] > 0 ? 1 : 0;
    const double wider = widening(pixel);
    if (wider == HUGE_VAL || S.s0 < kFaintest) return 1;
    const auto c = [&](Entry e) { return static_cast<double>(pixel.covariance[e]); };
    const double P = std::hypot(S.s1, S.s2), p = P / S.s0;
    // Unpolarized: the gradient has no direction; the larger axis of the error ellipse bounds it.
    if (P == 0) return std::min(1.0, wider * std::sqrt(std::max(c(k11), c(k22))) / S.s0);
    const double q = S.s1 / P, u = S.s2 / P;
    const double variance = q * q * c(k11) + u * u * c(k22) + 2 * q * u * c(k12) + p * p * c(k00) -
                            2 * p * (q * c(k01) + u * c(k02));
    return std::min(1.0, wider * std::sqrt(std::max(0.0, variance)) / S.s0);
}

double stderr_aolp(const PixelStokes& pixel) {
    const Stokes<double>& S = pixel.mean;
    const auto c = [&](Entry e) { return static_cast<double>(pixel.covariance[e]); };
    const double P = std::hypot(S.s1, S.s2);
    // An axis of light that may well be unpolarized can point anywhere.
    if (P == 0 || dolp(S) < 3 * stderr_dolp(pixel)) return kPi / 2;
    const double q = S.s1 / P, u = S.s2 / P;
    const double variance = q * q * c(k22) + u * u * c(k11) - 2 * q * u * c(k12);
    return std::min(kPi / 2, widening(pixel) * std::sqrt(std::max(0.0, variance)) / (2 * P));
}

double debiased_dolp(const PixelStokes& pixel) {
    const Stokes<double>& S = pixel.mean;
    const auto c = [&](Entry e) { return static_cast<double>(pixel.covariance[e]); };
    const double p = std::min(1.0, dolp(S)), P = std::hypot(S.s1, S.s2);
    if (p == 0) return 0;
    const double q = S.s1 / P, u = S.s2 / P;
    const double b2 = (q * q * c(k22) + u * u * c(k11) - 2 * q * u * c(k12)) / sqr(S.s0);
    if (!(b2 > 0)) return p;
    return std::max(0.0, p + b2 * std::expm1(-p * p / b2) / (2 * p));
}

Film::Film(int w, int h, std::vector<double> wavelengths)
    : width(w), height(h), wavelengths_nm(std::move(wavelengths)) {
    const std::size_t pixels = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    stokes.resize(pixels * wavelengths_nm.size());
    coverage.resize(pixels);
    distance.resize(pixels);
    instance.resize(pixels, -1);
    samples.resize(pixels);
}

std::optional<double> pixel_error(const Film& film, std::size_t pixel) {
    if (!(film.coverage[pixel] > 0)) return std::nullopt;
    double largest = 0;
    for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w) {
        const PixelStokes& p = film.at(pixel, w);
        largest = std::max({largest, stderr_dolp(p), relative_stderr_s0(p)});
    }
    return largest;
}

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    const auto count = static_cast<double>(values.size());
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>(std::max(0.0, std::ceil(share * count) - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

double error_of_most(const Film& film) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < film.pixel_count(); ++i)
        if (const auto error = pixel_error(film, i)) errors.push_back(*error);
    return quantile(std::move(errors), 0.95);
}

}  // namespace malus
