// film.cpp — means, covariances and their propagation to DoLP and AoLP.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/film.h"

#include <algorithm>

namespace malus {
namespace {

enum Entry { k00, k01, k02, k11, k12, k22, k33 };

// How much more the error of a ratio is than first-order propagation says when few replicates carry
// the light: DoLP is then a weighted mean of few, and pulled toward the very ones that are to tell
// its spread. Kish's effective number m of replicates; 1 when all weigh the same, infinite below
// m = 2.
double widening(const PixelStokes& pixel) {
    const double R = kReplicates;
    const double spread = static_cast<double>(pixel.covariance[k00]) / sqr(pixel.mean.s0);
    const double m = R / (1 + (R - 1) * spread);
    return m < 2 ? HUGE_VAL : std::sqrt((R - 1) / R * m / (m - 1));
}

// A mean of light is light, but samples are floats, and |(S1,S2,S3)| may exceed S0 by some of their
// roundings; so may what is stored in floats. What exceeds S0 by more is left for all to see.
Stokes<double> held_physical(const Stokes<double>& S) {
    constexpr double kRoundings = 1e-5, kFloat = 0x1p-22;
    const double polarized = std::hypot(S.s1, S.s2, S.s3), most = (1 - kFloat) * S.s0;
    if (polarized <= most || polarized > (1 + kRoundings) * S.s0) return S;
    const double shrink = most / polarized;
    return {S.s0, shrink * S.s1, shrink * S.s2, shrink * S.s3};
}

}  // namespace

double stderr_dolp(const PixelStokes& pixel) {
    const Stokes<double>& S = pixel.mean;
    if (!(S.s0 > 0)) return 0;
    const double wider = widening(pixel);
    if (wider == HUGE_VAL) return 1;
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

PixelAccumulator::PixelAccumulator(std::size_t wavelengths)
    : wavelengths_(wavelengths), sum_(wavelengths) {}

void PixelAccumulator::start_pixel() {
    replicate_count_ = 0;
    samples_ = seen_ = covered_ = votes_ = 0;
    distance_sum_ = 0;
    leader_ = -1;
}

void PixelAccumulator::start_replicate() {
    std::fill(sum_.begin(), sum_.end(), Stokes<double>{});
    in_replicate_ = 0;
}

bool PixelAccumulator::add(const float* S, std::size_t stride) {
    // Finite numbers keep the sum of x − x at 0; NaN and infinity do not.
    float finite = 0, least = 0;
    for (std::size_t w = 0; w < wavelengths_; ++w) {
        least = std::min(least, S[w]);
        for (std::size_t c = 0; c < 4; ++c) finite += S[c * stride + w] - S[c * stride + w];
    }
    if (!(finite == 0) || least < 0) return false;
    for (std::size_t w = 0; w < wavelengths_; ++w)
        sum_[w] =
            sum_[w] + Stokes<double>{static_cast<double>(S[w]), static_cast<double>(S[stride + w]),
                                     static_cast<double>(S[2 * stride + w]),
                                     static_cast<double>(S[3 * stride + w])};
    ++in_replicate_;
    return true;
}

void PixelAccumulator::add_surface(int instance, double distance) {
    ++seen_, ++covered_;
    distance_sum_ += distance;
    vote(instance);
}

void PixelAccumulator::add_sky() {
    ++seen_;
    vote(-1);
}

void PixelAccumulator::vote(std::int32_t instance) {
    if (votes_ == 0) leader_ = instance;
    votes_ = instance == leader_ ? votes_ + 1 : votes_ - 1;
}

void PixelAccumulator::end_replicate() {
    if (in_replicate_ == 0) return;  // all refused: no mean to take part
    if (replicates_.size() == replicate_count_) replicates_.emplace_back(wavelengths_);
    for (std::size_t w = 0; w < wavelengths_; ++w)
        replicates_[replicate_count_][w] = (1.0 / in_replicate_) * sum_[w];
    ++replicate_count_;
    samples_ += in_replicate_;
}

void PixelAccumulator::develop(Film& film, std::size_t pixel) const {
    film.samples[pixel] = samples_;
    film.instance[pixel] = leader_;
    film.coverage[pixel] = seen_ ? static_cast<float>(covered_) / static_cast<float>(seen_) : 0;
    film.distance[pixel] = covered_ ? static_cast<float>(distance_sum_ / covered_) : 0;
    if (replicate_count_ == 0) return;
    const auto R = static_cast<double>(replicate_count_);
    for (std::size_t w = 0; w < wavelengths_; ++w) {
        PixelStokes& out = film.stokes[pixel * wavelengths_ + w];
        out = {};
        for (std::size_t r = 0; r < replicate_count_; ++r)
            out.mean = out.mean + (1 / R) * replicates_[r][w];
        std::array<double, 7> C{};
        for (std::size_t r = 0; r < replicate_count_; ++r) {
            const Stokes<double> d = replicates_[r][w] + -1.0 * out.mean;
            const std::array<double, 7> products{d.s0 * d.s0, d.s0 * d.s1, d.s0 * d.s2, d.s1 * d.s1,
                                                 d.s1 * d.s2, d.s2 * d.s2, d.s3 * d.s3};
            for (std::size_t e = 0; e < C.size(); ++e) C[e] += products[e];
        }
        const double norm = R > 1 ? 1 / (R * (R - 1)) : 0;
        for (std::size_t e = 0; e < C.size(); ++e)
            out.covariance[e] = static_cast<float>(norm * C[e]);
        out.mean = held_physical(out.mean);
    }
}

}  // namespace malus
