// histogram.h — counts of values in equal bins, and how far two such lie apart.
//
//   H1, H2: counts of N bins, H̄ their mean over bins; p1, p2 the same divided by their sums
//   correlation      Σ(H1−H̄1)(H2−H̄2) / √(Σ(H1−H̄1)² Σ(H2−H̄2)²)             1 if alike
//   chi-square       Σ (H1−H2)²/H1  over bins with H1 ≠ 0                    0 if alike
//   intersection     Σ min(H1, H2)                                           Σ H1 if alike
//   Hellinger        √(1 − Σ√(H1 H2)/√(ΣH1 ΣH2))                             0 if alike, [0,1]
//   Kullback-Leibler Σ H1 ln(H1/H2), H2 = 0 counting as 1e-10, H1 = 0 left out  0 if alike
//   earth mover's    ∫ |F1 − F2| of the cumulative p1, p2, in the unit of the values; on the circle
//                    with the best start, which is the median of F1 − F2
//
// Source  OpenCV's compareHist: HISTCMP_CORREL, _CHISQR, _INTERSECT, _BHATTACHARYYA (Hellinger), _KL_DIV;
//         the circle: J. Rabin, J. Delon, Y. Gousseau, J. Math. Imaging Vis. 41, 147 (2011).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "malus/analysis/mask.h"

namespace malus {

/// `count` equal bins of [low, high); the last takes high itself, too.
struct Bins {
    double low = 0, high = 1;
    std::size_t count = 100;
    double width() const { return (high - low) / static_cast<double>(count); }
    friend bool operator==(const Bins&, const Bins&) = default;
};

struct Histogram {
    Bins bins;
    std::vector<double> counts;                     ///< [bin]; may be shares when normalized
    std::size_t below = 0, above = 0, unknown = 0;  ///< outside the bins; NaN

    double total() const;  ///< in the bins
};

/// Of the values that the mask means. `period` > 0: values are brought into [low, low + period) first.
Histogram histogram(std::span<const float> values, const Mask& mask, const Bins& bins,
                    double period = 0);

/// The same with counts that add up to 1; an empty one stays empty.
Histogram normalized(Histogram h);

/// How far apart; both must have the same bins (a contract). With nothing in one of them, what is
/// undefined is NaN.
struct HistogramDistances {
    double correlation, chi_square, intersection, hellinger, kullback_leibler, earth_movers;
};
/// Of counts as they are: normalize first to compare histograms of different sizes. `circular`: the
/// bins go once round a circle.
HistogramDistances distances(const Histogram& a, const Histogram& b, bool circular = false);

}  // namespace malus
