// scattering_expansion.h — a scattering matrix as a sum of generalized spherical functions.
//
//   F11 = Σ α1_l P_l,  F22 ± F33 = Σ (α2 ± α3)_l d^l_{2,±2},  F12 = Σ β1_l d^l_{02},   l < degrees
//   peak f = α1_L/(2L+1), L = degrees: the share that degrees beyond count as scattered straight on;
//   smooth(c) = the sum less f (2l+1) in α1, α2 and α3, so ½ ∫ F11 dc = 1 − f
//
// Source  Hovenier & van der Mee, A&A 128, 1 (1983); recurrences: Varshalovich et al., Quantum
//         Theory of Angular Momentum (1988), §4.8. The sign of d^l_{02} cancels.
// Norm    brought to what the quadrature finds of it, so that no light is lost.
// Error   rounding, where F varies little over 0.2°. Throws Error where 1 % and more are missed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "malus/scene/scattering.h"

namespace malus {

struct GaussNodes {
    std::vector<double> x, weight;
};
/// Gauss-Legendre nodes on (0, 1).
GaussNodes gauss_nodes(int n);

class ScatteringExpansion {
  public:
    ScatteringExpansion(const ScatteringMatrix& F, int degrees);

    /// The highest degree that is not nothing.
    int degree() const { return static_cast<int>(terms_.size()) - 1; }
    double peak() const { return peak_; }
    ScatteringElements smooth(double cos_angle) const;

  private:
    struct Term {
        double F11, F12, plus, minus;  // plus and minus: of F22 ± F33
    };
    std::vector<Term> terms_;  // by degree
    double peak_;
};

}  // namespace malus
