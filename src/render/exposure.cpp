// exposure.cpp — sums of samples, and their development into means and covariances.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/exposure.h"

#include <algorithm>
#include <cmath>

#include "malus/core/contract.h"
#include "render/lanes.h"

namespace malus {
namespace {

// Far above any radiance and far below where sums overflow. NaN compares as false.
constexpr float kMost = 1e30f;

// Of a mean off by `error` of S0. S1 and S2 are off by no more, nor by more than a hundred times that of
// what they are together (`Sky table: between nodes T is the quadrature …`); S3, by a quarter of it, is left out.
std::array<double, 7> variances(const Stokes<double>& S, double error) {
    const double linear = std::min(S.s0, 100 * std::hypot(S.s1, S.s2));
    std::array<double, 7> variances{};
    variances[0] = sqr(error * S.s0);
    variances[3] = variances[5] = sqr(error * linear);
    return variances;
}

// Up to whole registers.
std::size_t padded(std::size_t numbers) {
    return (numbers + kSide - 1) / kSide * kSide;
}

double rounded(double x) {
    return static_cast<double>(static_cast<float>(x));
}

}  // namespace

Exposure::Exposure(int w, int h, std::vector<double> wavelengths, std::uint32_t replicate_count)
    : width(w), height(h), replicates(replicate_count), wavelengths_nm(std::move(wavelengths)) {
    const std::size_t pixels = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    stokes.resize(pixels * pixel_stride());
    open.resize(pixels * replicates * wavelengths_nm.size());
    kept.resize(pixels * replicates);
    taken.resize(pixels);
    wanted.resize(pixels);
    covered.resize(pixels);
    distance.resize(pixels);
    instance.resize(pixels, -1);
    votes.resize(pixels);
}

PixelExposure::PixelExposure(const Exposure& exposure)
    : wavelengths_(exposure.wavelengths_nm.size()),
      replicates_(exposure.replicates),
      stride_(exposure.pixel_stride()),
      sums_(stride_ + kSide),
      open_(replicates_ * wavelengths_),
      kept_(replicates_) {}

void PixelExposure::load(const Exposure& exposure, std::size_t pixel) {
    taken_ = exposure.taken[pixel];
    const float* sums = exposure.stokes.data() + pixel * stride_;
    if (taken_ > 0)
        std::copy_n(sums, stride_, sums_.begin());
    else
        std::fill(sums_.begin(), sums_.end(),
                  0.0);  // as they are, but their memory stays untouched
    std::copy_n(exposure.open.data() + pixel * open_.size(), open_.size(), open_.begin());
    const std::uint32_t* kept = exposure.kept.data() + pixel * replicates_;
    std::copy(kept, kept + replicates_, kept_.begin());
    covered_ = exposure.covered[pixel];
    distance_ = static_cast<double>(exposure.distance[pixel]);
    leader_ = exposure.instance[pixel];
    votes_ = exposure.votes[pixel];
}

void PixelExposure::store(Exposure& exposure, std::size_t pixel) const {
    EXPECT(taken_ == checkpoint(taken_));
    float* sums = exposure.stokes.data() + pixel * stride_;
    std::transform(sums_.begin(), sums_.begin() + static_cast<std::ptrdiff_t>(stride_), sums,
                   [](double x) { return static_cast<float>(x); });
    std::copy(open_.begin(), open_.end(), exposure.open.data() + pixel * open_.size());
    std::copy(kept_.begin(), kept_.end(), exposure.kept.data() + pixel * replicates_);
    exposure.taken[pixel] = taken_;
    exposure.covered[pixel] = covered_;
    exposure.distance[pixel] = static_cast<float>(distance_);
    exposure.instance[pixel] = leader_;
    exposure.votes[pixel] = votes_;
}

bool PixelExposure::add(std::uint32_t replicate, const float* S, std::size_t stride,
                        const float* open) {
    bool fit = true;
    for (std::size_t w = 0; w < wavelengths_; ++w) fit &= S[w] >= 0;
    for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t w = 0; w < wavelengths_; ++w) fit &= std::abs(S[c * stride + w]) < kMost;
    if (!fit) return false;
    double* sums = sums_.data() + replicate;
    for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t w = 0; w < wavelengths_; ++w)
            sums[(c * wavelengths_ + w) * replicates_] += static_cast<double>(S[c * stride + w]);
    ++kept_[replicate];
    if (!open) return true;
    const std::uint8_t* shares = open_.data() + replicate * wavelengths_;
    for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t w = 0; w < wavelengths_; ++w)
            sums[(c * wavelengths_ + w) * replicates_] +=
                (shares[w] / 255.0) * static_cast<double>(open[c * stride + w]);
    return true;
}

bool PixelExposure::add_all(const float* S, const float* open) {
    // As integers, whose largest the compiler finds in vector registers: the sign is the top bit, NaN
    // and infinity are above all numbers.
    constexpr auto kSign = std::uint32_t{1} << 31;
    const std::size_t s0 = wavelengths_ * replicates_;
    std::uint32_t most_s0 = 0, most = 0;
    for (std::size_t i = 0; i < s0; ++i)
        most_s0 = std::max(most_s0, std::bit_cast<std::uint32_t>(S[i]));
    for (std::size_t i = 0; i < stride_; ++i)
        most = std::max(most, std::bit_cast<std::uint32_t>(S[i]) & ~kSign);
    if (most_s0 > kSign || most >= std::bit_cast<std::uint32_t>(kMost)) return false;  // −0 is 0
    for (std::size_t i = 0; i < stride_; ++i) sums_[i] += static_cast<double>(S[i]);
    for (std::uint32_t& kept : kept_) ++kept;
    if (!open) return true;
    for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t w = 0; w < wavelengths_; ++w)
            for (std::size_t r = 0; r < replicates_; ++r) {
                const std::size_t i = (c * wavelengths_ + w) * replicates_ + r;
                sums_[i] += (open_[r * wavelengths_ + w] / 255.0) * static_cast<double>(open[i]);
            }
    return true;
}

void PixelExposure::set_open(std::uint32_t replicate, std::size_t wavelength, double share) {
    auto parts = static_cast<std::uint8_t>(std::lround(255 * share));
    const bool odd = taken_ == 0;
    if (parts > 1 && (parts % 2 == 1) != odd) --parts;
    open_[replicate * wavelengths_ + wavelength] = parts;
}

bool PixelExposure::is_open() const {
    return std::any_of(open_.begin(), open_.end(), [](std::uint8_t share) { return share > 0; });
}

bool PixelExposure::is_open(std::size_t replicate, std::size_t wavelength) const {
    return open_[replicate * wavelengths_ + wavelength] > 0;
}

bool PixelExposure::is_open(std::size_t wavelength) const {
    for (std::size_t r = 0; r < replicates_; ++r)
        if (is_open(r, wavelength)) return true;
    return false;
}

void PixelExposure::add_surface(int instance, double distance) {
    ++covered_;
    distance_ += distance;
    vote(instance);
}

void PixelExposure::add_sky() {
    vote(-1);
}

void PixelExposure::vote(std::int32_t instance) {
    if (votes_ == 0) leader_ = instance;
    votes_ = instance == leader_ ? votes_ + 1 : votes_ - 1;
}

void PixelExposure::end_sample() {
    ++taken_;
    if (taken_ != checkpoint(taken_)) return;
    for (double& sum : sums_) sum = rounded(sum);
    distance_ = rounded(distance_);
}

// What chance may have put above |(S1,S2,S3)| = S0 where the sky table's differences are in the
// means; 0 where they are not. `C`: products of deviations, as develop() has them.
double PixelExposure::noise_of_differences(std::size_t wavelength, const std::array<double, 7>& C,
                                           double norm) const {
    constexpr double kErrors = 6;
    return is_open(wavelength) ? kErrors * std::sqrt(norm * (C[0] + C[3] + C[5] + C[6])) : 0;
}

void PixelExposure::develop(Film& film, std::size_t pixel, double open_error) const {
    const double seen = static_cast<double>(taken_) * static_cast<double>(replicates_);
    film.instance[pixel] = leader_;
    film.coverage[pixel] = taken_ ? static_cast<float>(covered_ / seen) : 0;
    film.distance[pixel] = covered_ ? static_cast<float>(distance_ / covered_) : 0;
    film.samples[pixel] = 0;
    // A replicate of which all samples were refused has no mean to take part.
    std::vector<double> sample(padded(replicates_));  // what each counts in the mean
    std::vector<double> takes_part(padded(replicates_));
    double R = 0;
    for (std::size_t r = 0; r < replicates_; ++r) {
        film.samples[pixel] += kept_[r];
        if (kept_[r] == 0) continue;
        sample[r] = 1.0 / kept_[r], takes_part[r] = 1;
        ++R;
    }
    if (R == 0) return;
    const double norm = R > 1 ? 1 / (R * (R - 1)) : 0;
    const std::size_t next = wavelengths_ * replicates_;
    for (std::size_t w = 0; w < wavelengths_; ++w) {
        // Replicates side by side; beyond the last one stand numbers that count as nothing.
        const auto means = [&, w](std::size_t r) {
            const double* sums = sums_.data() + w * replicates_ + r;
            const Reals of = Reals::load_unaligned(&sample[r]);
            return Stokes<Reals>{of * Reals::load_unaligned(sums),
                                 of * Reals::load_unaligned(sums + next),
                                 of * Reals::load_unaligned(sums + 2 * next),
                                 of * Reals::load_unaligned(sums + 3 * next)};
        };
        Stokes<Reals> sum{Reals(0.0), Reals(0.0), Reals(0.0), Reals(0.0)};
        for (std::size_t r = 0; r < replicates_; r += kSide) sum = sum + means(r);
        PixelStokes& out = film.stokes[pixel * wavelengths_ + w];
        out = {};
        out.replicates = static_cast<float>(R);
        out.mean =
            (1 / R) * Stokes<double>{total(sum.s0), total(sum.s1), total(sum.s2), total(sum.s3)};
        std::array<Reals, 7> products;
        products.fill(Reals(0.0));
        for (std::size_t r = 0; r < replicates_; r += kSide) {
            const Reals here = Reals::load_unaligned(&takes_part[r]);
            const Stokes<Reals> m = means(r);
            const Reals d0 = here * (m.s0 - Reals(out.mean.s0)),
                        d1 = here * (m.s1 - Reals(out.mean.s1)),
                        d2 = here * (m.s2 - Reals(out.mean.s2)),
                        d3 = here * (m.s3 - Reals(out.mean.s3));
            const std::array<Reals, 7> more{d0 * d0, d0 * d1, d0 * d2, d1 * d1,
                                            d1 * d2, d2 * d2, d3 * d3};
            for (std::size_t e = 0; e < more.size(); ++e) products[e] = products[e] + more[e];
        }
        std::array<double, 7> C;
        for (std::size_t e = 0; e < C.size(); ++e) C[e] = total(products[e]);
        const std::array<double, 7> of_open =
            is_open(w) ? variances(out.mean, open_error) : std::array<double, 7>{};
        for (std::size_t e = 0; e < C.size(); ++e)
            out.covariance[e] = static_cast<float>(norm * C[e] + of_open[e]);
        out.mean = held_physical(out.mean, noise_of_differences(w, C, norm));
    }
}

}  // namespace malus
