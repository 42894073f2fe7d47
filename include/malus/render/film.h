// film.h — what a render leaves: per pixel and wavelength the Stokes vector and its covariance.
//
//   S = mean over R replicates of their means S_r,   C = Σ_r (S_r − S)(S_r − S)ᵀ / (R(R−1))
//   var p    = [(S1²C11 + S2²C22 + 2S1S2C12)/P² + p²C00 − 2p(S1C01 + S2C02)/P] / S0²
//   var AoLP = (S1²C22 + S2²C11 − 2S1S2C12)/(4P⁴)              P = √(S1²+S2²), p = P/S0 = DoLP
//   p̂        = p − b² (1 − e^{−p²/b²})/(2p),   b² = (S1²C22 + S2²C11 − 2S1S2C12)/(P²S0²)
//   C where the sky table is used: plus what that may be off by (exposure.h), and raised toward that of
//   neighbours (render/shared_errors.h)
//   variances times (R−1)/R · m/(m−1), m = R/(1 + (R−1)C00/S0²) the number of replicates that carry
//   the light; below m = 2 nothing is known, nor of AoLP where p is below 3 of its errors
//
// Frame   the camera's image frame of each pixel's beam (camera.h). Units W m⁻² sr⁻¹ nm⁻¹, m, rad.
// Source  propagation of errors to first order; Plaszczynski et al., MNRAS 439, 4048 (2014).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "malus/optics/stokes.h"

namespace malus {

/// Independent scrambles a pixel, whose spread is the error bar, unless the settings say otherwise.
inline constexpr std::uint32_t kReplicates = 8;

/// One wavelength of one pixel.
struct PixelStokes {
    Stokes<double> mean;
    /// Of the mean: C00, C01, C02, C11, C12, C22, C33.
    std::array<float, 7> covariance{};
    /// R. In a mean over pictures with N samples each, (ΣN)²/Σ(N²/R).
    float replicates = kReplicates;
};

/// Standard errors of a pixel's DoLP and AoLP (rad); 1 and π/2 where nothing is known, since all
/// light came from one replicate, whose spread nobody saw, or noise left none, or S0 is below 1e-18, whose
/// covariance no float holds. Without any light DoLP is 0 for certain.
double stderr_dolp(const PixelStokes& pixel);
double stderr_aolp(const PixelStokes& pixel);

/// SE(S0)/S0; 0 without light, 1 where noise left none.
double relative_stderr_s0(const PixelStokes& pixel);

/// DoLP less what noise adds to it on average (it makes light look polarized): p̂, the modified
/// asymptotic (MAS) estimate of Plaszczynski et al., in [0, 1]. Of finished pixels only: a mean of
/// several is the DoLP of their mean Stokes vector.
double debiased_dolp(const PixelStokes& pixel);

/// A mean of light is light, but its terms are floats, and |(S1,S2,S3)| may exceed S0 by some of
/// their roundings, now or when stored as floats: that is taken back. So is what `noise` may have put
/// above, for means with differences in them, of which S0 may even be negative: then nothing is left.
/// What exceeds S0 by more is left for all to see.
Stokes<double> held_physical(const Stokes<double>& mean, double noise = 0);

struct Film {
    int width = 0, height = 0;
    std::vector<double> wavelengths_nm;
    std::vector<PixelStokes> stokes;     ///< [pixel][wavelength]; pixels by rows from the top
    std::vector<float> coverage;         ///< [pixel] share of samples that met a surface, [0,1]
    std::vector<float> distance;         ///< [pixel] mean distance of those surfaces, m; 0 if none
    std::vector<std::int32_t> instance;  ///< [pixel] the instance seen most, −1 for the sky
    std::vector<std::uint32_t> samples;  ///< [pixel] samples kept

    Film() = default;
    Film(int width, int height, std::vector<double> wavelengths_nm);

    std::size_t pixel_count() const { return samples.size(); }
    const PixelStokes& at(std::size_t pixel, std::size_t wavelength) const {
        return stokes[pixel * wavelengths_nm.size() + wavelength];
    }
};

/// AoLP in degrees, [0, 180) also when rounded to a float.
double aolp_degrees(const Stokes<double>& S);

/// What follows from the light of a pixel at one wavelength. AoLP is aolp_degrees(), its error in degrees, too;
/// DoLP is at most 1.
enum FilmQuantity : std::size_t {
    kS0,
    kS1,
    kS2,
    kS3,
    kDolp,
    kAolp,
    kErrorS0,
    kErrorS1,
    kErrorS2,
    kErrorS3,
    kCovS0S1,
    kCovS0S2,
    kCovS1S2,
    kErrorDolp,
    kErrorAolp,
    kFilmQuantities
};

/// All of them for pixels [from, to): that of pixel i goes to rows[quantity][i − from].
void derive(const Film& film, std::size_t wavelength, std::size_t from, std::size_t to,
            float* const* rows);

/// The larger of SE(DoLP) and SE(S0)/S0 at the wavelength where it is largest; nothing where no
/// surface shows.
std::optional<double> pixel_error(const Film& film, std::size_t pixel);

/// The number that this share of `values` has at most; 0 of none.
double quantile(std::vector<double> values, double share);

/// What 95 % of the pixels that show a surface have at most as their pixel_error().
double error_of_most(const Film& film);

}  // namespace malus
