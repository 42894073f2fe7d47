// spread.h — the middle and the width of values, and how much of the width is noise.
//
//   x̄ = Σx/n,   σ² = Σ(x − x̄)²/(n − 1),   expected: σ² = σ_true² + Σe²/n     e: errors of the values
//   angles of period T, φ = 2πx/T:   R e^{iμ} = Σe^{iφ}/n,   σ = (T/2π) √(−2 ln R)
//   ε = 2πe/T:   R = R_true Σe^{−ε²/2}/n,   so that again σ² = σ_true² + σ_noise²
//
// Given   normal errors, each pixel's its own. An error that pixels have in common (the sky table's)
//         moves them together and widens nothing: of it, σ_noise says too much.
// Units   those of the values.
// Source  K. Mardia, P. Jupp, Directional Statistics (2000), §2.3 and §3.5.7 (wrapped normals add).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <span>

#include "malus/analysis/mask.h"
#include "malus/analysis/quantity.h"

namespace malus {

/// Of the finite values that the mask means. NaN where there are too few: none, or of the deviation
/// fewer than two.
struct Spread {
    std::size_t count = 0;
    double mean = 0;       ///< of angles their mean direction, [0, period)
    double median = 0;     ///< of angles by their distance to the mean direction
    double deviation = 0;  ///< σ; of angles infinite where they have no direction
};
Spread spread(std::span<const float> values, const Mask& mask, double period = 0);

/// What the errors explain of σ, over the values whose error is known.
struct NoiseShare {
    std::size_t count = 0;   ///< of these
    double observed = 0;     ///< their σ
    double noise = 0;        ///< σ_noise
    double truth = 0;        ///< √max(0, observed² − noise²)
    double of_variance = 0;  ///< noise²/observed²; beyond 1 the errors are too large, or shared
};
/// Errors of `unknown` and more say that nothing is known.
NoiseShare noise_share(std::span<const float> values, std::span<const float> errors,
                       const Mask& mask, double period = 0,
                       double unknown = std::numeric_limits<double>::infinity());

/// The error by which an image says that it knows nothing: 1 of DoLP, 90° of AoLP, else infinite.
double unknown_error(const Quantity& quantity);

}  // namespace malus
