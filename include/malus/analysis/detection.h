// detection.h — how well the values of one quantity tell the pixels of a target from those of a background.
//
//   m, s²           mean and variance (n − 1) of the values over pixels; t target, b background
//   difference      m_t − m_b
//   Weber contrast  (m_t − m_b)/m_b
//   signal-to-clutter ratio  |m_t − m_b|/s_b
//   Fisher ratio    (m_t − m_b)²/(s_t² + s_b²)
//   Bhattacharyya   ¼ (m_t − m_b)²/(s_t² + s_b²) + ½ ln((s_t² + s_b²)/(2 s_t s_b))   of two Gaussians
//   ROC             share of target pixels above a threshold over that of background pixels above it
//   area            A = Σ_i Σ_j ψ(x_i, y_j)/(n_t n_b),  ψ = 1 if x_i > y_j, ½ if equal, 0 if below
//   its error       √(var_i V10(x_i)/n_t + var_j V01(y_j)/n_b),  V10(x_i) = Σ_j ψ(x_i, y_j)/n_b,
//                   V01(y_j) = Σ_i ψ(x_i, y_j)/n_t: as if pixels were independent
//
// An area below ½ says that the target is the lower of the two; both ½ + a and ½ − a tell them apart
// equally well. An area of 0 or 1 has the error 0: then the pixels are too few to show any overlap.
//
// Angles  m is the direction of Σ (cos 2πv/p, sin 2πv/p) for the period p, s² is of the shorter way from m,
//         m_t − m_b the shorter way, and the ROC that of |v − m_b|: how far from the background's direction.
// Source  R. A. Fisher, Ann. Eugenics 7, 179 (1936); A. Bhattacharyya, Bull. Calcutta Math. Soc. 35, 99
//         (1943), for Gaussians T. Kailath, IEEE Trans. Commun. Technol. 15, 52 (1967);
//         E. R. DeLong, D. M. DeLong, D. L. Clarke-Pearson, Biometrics 44, 837 (1988), by ranks as in
//         X. Sun, W. Xu, IEEE Signal Process. Lett. 21, 1389 (2014);
//         K. V. Mardia, P. E. Jupp, Directional Statistics (2000), §2.2 (mean direction).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "malus/analysis/mask.h"
#include "malus/analysis/quantity.h"

namespace malus {

/// m and s of the header, in the unit of the values; NaN of too few (none, fewer than two). Of a
/// `period` > 0 the mean lies in [0, period), and is NaN where directions cancel.
struct Moments {
    double mean, spread;
};
Moments moments(std::span<const double> values, double period = 0);

/// Of moments; where both spreads are 0, or one, what the formulas say: infinity or NaN.
struct Separation {
    double difference;     ///< target less background; of angles in [−period/2, period/2)
    double weber;          ///< of the means' ratio: of use where values are never negative
    double clutter_ratio;  ///< signal to clutter
    double fisher, bhattacharyya;
};
Separation separation(const Moments& target, const Moments& background, double period = 0);

/// The area under the ROC and its standard error, both NaN for fewer than two values of either.
struct RocArea {
    double area, error;
};
RocArea roc_area(std::span<const double> target, std::span<const double> background);

/// The curve from (0, 0) to (1, 1) as the threshold falls, a point for each value that occurs; the
/// area of the trapezia below it is roc_area(). Empty without target or background.
struct RocPoint {
    double false_alarms, detections;  ///< shares of background and of target, [0,1]
};
std::vector<RocPoint> roc_curve(std::span<const double> target, std::span<const double> background);

/// Points of the curve that lie `step` or more from the last one kept, along either axis, and its end.
std::vector<RocPoint> thinned(const std::vector<RocPoint>& curve, double step);

/// The pixels of a mask that one quantity is known of, in the unit of the quantity.
struct Population {
    std::size_t pixels = 0, unknown = 0;  ///< used; left out
    double mean = 0, spread = 0;
    double noise = 0;  ///< root mean square of the pixels' standard errors; NaN if none are known
};

struct Detection {
    Population target, background;
    Separation separation;
    RocArea roc_area;
    std::vector<RocPoint> roc;
};
/// Over the pixels that the masks mean and whose value is finite and, where `known` is not empty,
/// known. With fewer than two of either all that needs more is NaN.
Detection detect(const Quantity& quantity, const Mask& target, const Mask& background,
                 const Mask& known = {});

/// Pixels whose AoLP says something: DoLP is above 0 and at least 3 of its standard errors, and that
/// of AoLP is below 90°. Where the image has no errors, DoLP above 0 is enough. Throws Error (without
/// a file name) if there is no light at this wavelength.
Mask aolp_known(const Image& image, double wavelength_nm);

/// The mask without the pixels that have one outside it at most `border` pixels away, between the
/// middles. The edge of the picture is no border.
Mask inside(const Mask& mask, int width, int height, double border);

}  // namespace malus
