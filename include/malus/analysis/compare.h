// compare.h — do two images differ by more than their error bars say?
//
//   pixel   t = d/e,  d = a − b,  e² = max(v, mean of v over its 3 × 3 pixels) + r²,  v = e_a² + e_b²
//   region  t = Σ w d/√(Σ w² d²), made Student's by its n ≥ 64 pixels, where pixels have errors of their own
//           t = Σ w d/Σ w e      of fewer pixels, and where they may share errors (sky table)
//           w = 1/√(mean of v over the other pixels of its 5 × 5); S0 to S3 only, which are unbiased
//   regions: each material of 16 pixels or more, and its part in each tile of 8 × 8 and of 16 × 16 pixels
//            of which it has a quarter or more; all surfaces, too, if the images name other materials
//   t of noise alone follows Student's t with Welch's degrees of freedom, 7 to 14 for 8 replicates.
//
// A share of half the false-alarm rate falls to all pixels together, half to all regions (Bonferroni).
// Neighbours count because few replicates take a rare event that none of them met for none. For the
// same reason errors of DoLP and AoLP count 8/s-fold in pixels of s < 8 samples a replicate. With the
// sky table all errors count 16/s-fold where s < 16: a pixel that cannot use it stands among quiet ones
// that do.
// Σ w e bounds the error of Σ w d for errors that are shared in any way.
// r        2e-6 S0: floats; 1e-5 S0 is what images may differ by that should be identical. S0 is at least
//          a thousandth of the picture's mean: light of 1e-30 is nobody's difference.
// DoLP     e = (√(e1² + e2²) + p e0)/S0, AoLP e = √(e1² + e2²)/2P: bounds of the errors that
//          the file gives, whose cancellations few replicates do not know.
//
// Units   W m⁻² sr⁻¹ nm⁻¹ (S0 to S3), 1 (DoLP), degrees (AoLP). Pixels by rows from the top.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "malus/analysis/histogram.h"
#include "malus/io/exr.h"

namespace malus {

struct CompareSettings {
    std::vector<double> wavelengths_nm;  ///< none: all
    double false_alarm_rate = 0.01;      ///< of one comparison of honest images; 0: no such tests
    std::optional<double> most_relative;  ///< of S0 to S3 in a pixel: |a − b|/S0, S0 the larger one, see above
    std::optional<double> most_dolp;      ///< |a − b| in a pixel
    std::optional<double> most_aolp_deg;   ///< in a pixel, the shorter way round, where it is known
    std::optional<double> most_hellinger;  ///< between the histograms of any quantity
};

/// What differences are judged by.
enum class Errors {
    kNone,         ///< an image has no error channels: by limits, or float rounding
    kSameNumbers,  ///< same seed, samples and options: by limits, or float rounding
    kShared,       ///< pixels may share errors: the sky table, or nobody knows
    kIndependent,  ///< each pixel has random numbers of its own
};

struct RegionDifference {
    std::string material;                     ///< empty for all surfaces
    int x = 0, y = 0, width = 0, height = 0;  ///< of the tile, or the whole picture
    std::size_t pixels = 0;
    double relative = 0;  ///< Σ w (a − b)/Σ w S0
    double t = 0, limit = 0;
};

/// One quantity at one wavelength.
struct QuantityComparison {
    std::string name;
    double wavelength_nm = 0;
    std::size_t pixels = 0;  ///< that both images know
    double largest = 0;      ///< |a − b|
    std::size_t largest_at = 0;
    double rms = 0;
    double beyond_three = 0;  ///< share of pixels with |a − b| > 3√(e_a² + e_b²); NaN without errors
    double z_rms = 0;         ///< of (a − b)/√(e_a² + e_b²); NaN without errors
    double t = 0, limit = 0;  ///< of the pixel with the largest t/limit; 0 if not tested
    std::size_t t_at = 0;
    std::optional<RegionDifference> region;  ///< the one with the largest t/limit
    HistogramDistances histograms{};         ///< of shares of pixels that show a surface, or of all, 100 bins
    std::vector<std::string> problems;       ///< why it differs; none if it does not
};

struct Comparison {
    Errors errors = Errors::kNone;
    std::size_t tests = 0;
    std::vector<QuantityComparison> quantities;
    std::vector<std::string> notes;  ///< what a reader should know of both images
    bool alike() const;
    /// The first and worst problem; empty if alike.
    std::string problem() const;
};

/// Throws Error (without a file name) when the images cannot be compared: another size, other
/// wavelengths, frame, units or view, or numbers that no image has.
Comparison compare(const Image& a, const Image& b, const CompareSettings& settings = {});

}  // namespace malus
