// exposure.h — what a film is developed from: per pixel and replicate the sums of its samples.
//
// A render can go on from an exposure as if it had never stopped: sample n of a replicate is a
// function of (seed, pixel, replicate, n) alone, and sums are rounded to floats at checkpoints that
// depend on n alone, wherever a render stops.
//
// Memory  17 bytes per pixel, wavelength and replicate.
// Range   sums are good to 2e-6 of themselves at any number of samples: between the 32 checkpoints
//         of each doubling they are doubles, and before 64 samples each sample is one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "malus/core/zeroed.h"
#include "malus/render/film.h"

namespace malus {

/// Samples of a replicate from one checkpoint to the next.
constexpr std::uint32_t checkpoint_step(std::uint32_t samples) {
    return samples < 64 ? 1 : std::bit_floor(samples) / 32;
}

/// The first checkpoint at or after `samples`.
constexpr std::uint32_t checkpoint(std::uint32_t samples) {
    const std::uint32_t step = checkpoint_step(samples);
    return (samples + step - 1) / step * step;
}

struct Exposure {
    int width = 0, height = 0;
    std::uint32_t replicates = 0;
    std::vector<double> wavelengths_nm;
    ZeroedVector<float> stokes;  ///< [pixel][S0..S3][wavelength][replicate] sums
    /// [pixel][replicate][wavelength] α of the sky table × 255: odd where the pixel's first sample found it,
    /// even where a later one did.
    std::vector<std::uint8_t> open;
    std::vector<std::uint32_t> kept;     ///< [pixel][replicate] samples in the sums
    std::vector<std::uint32_t> taken;    ///< [pixel] samples of each replicate, refused ones too
    std::vector<std::uint32_t> wanted;   ///< [pixel] what the round under way brings `taken` to
    std::vector<std::uint32_t> covered;  ///< [pixel] samples that met a surface
    std::vector<float> distance;         ///< [pixel] sum of their distances, m
    std::vector<std::int32_t> instance;  ///< [pixel] leader of the vote for what is seen most
    std::vector<std::uint32_t> votes;    ///< [pixel] its lead

    Exposure() = default;
    Exposure(int width, int height, std::vector<double> wavelengths_nm, std::uint32_t replicates);

    std::size_t pixel_count() const { return taken.size(); }
    /// Floats of `stokes` that belong to one pixel.
    std::size_t pixel_stride() const { return 4 * wavelengths_nm.size() * replicates; }
};

/// One pixel under exposure: sums in double, samples added one after the other.
class PixelExposure {
  public:
    explicit PixelExposure(const Exposure& exposure);

    void load(const Exposure& exposure, std::size_t pixel);
    /// At a checkpoint only, or numbers would depend on where a render stopped.
    void store(Exposure& exposure, std::size_t pixel) const;

    /// `S`: components by rows of `stride` floats, wavelength innermost. False, and nothing is
    /// added, when a number is not finite (or beyond 1e30) or an S0 negative. `open`, of the same
    /// form, is what the light of the open sky has beyond that of the sample's own directions:
    /// α of it is added.
    bool add(std::uint32_t replicate, const float* S, std::size_t stride,
             const float* open = nullptr);
    /// A sample of every replicate, [S0..S3][wavelength][replicate], and the same of `open`. False,
    /// and nothing is added, where one of them would be refused.
    bool add_all(const float* S, const float* open = nullptr);
    /// α, [0,1], to 2/255: the last bit says whether a sample was there before.
    void set_open(std::uint32_t replicate, std::size_t wavelength, double share);
    bool is_open() const;                        ///< is α > 0 for any replicate at any wavelength?
    bool is_open(std::size_t wavelength) const;  ///< is it at this one?
    bool is_open(std::size_t replicate, std::size_t wavelength) const;
    void add_surface(int instance, double distance);  ///< of a sample that met a surface
    void add_sky();                                   ///< of a sample that did not
    /// After one sample of each replicate.
    void end_sample();

    std::uint32_t taken() const { return taken_; }
    /// Mean and covariance over the replicates. What rounding put above |(S1,S2,S3)| = S0 is taken
    /// back, so that it holds also when stored as floats. `open_error`: what the sky table may be off by in
    /// all replicates alike, as a part of S0; added to the variances where α > 0.
    void develop(Film& film, std::size_t pixel, double open_error = 0) const;

  private:
    std::size_t wavelengths_, replicates_, stride_;
    std::vector<double> sums_;        // [S0..S3][wavelength][replicate], padded
    std::vector<std::uint8_t> open_;  // [replicate][wavelength]
    std::vector<std::uint32_t> kept_;
    std::uint32_t taken_ = 0, covered_ = 0;
    double distance_ = 0;
    // The instance seen most, by Boyer and Moore's majority vote (1981): exact for a majority.
    std::int32_t leader_ = -1;
    std::uint32_t votes_ = 0;

    void vote(std::int32_t instance);
    double noise_of_differences(std::size_t wavelength, const std::array<double, 7>& C,
                                double norm) const;
};

}  // namespace malus
