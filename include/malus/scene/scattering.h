// scattering.h — how particles in the air turn light into new directions.
//
//   S_out = F(Θ) S_in,   F = [[F11, F12, 0], [F12, F22, 0], [0, 0, F33]] on (I, Q, U)
//
// Frame   the plane of scattering on both beams: S1 > 0 is polarized in it (F12 < 0 for molecules).
// Norm    ½ ∫ F11 dcosΘ = 1.
// Left    circular polarization (F34, F44): from an unpolarized sun it arises in the second order
//         only, and changes I, Q and U in the third.
// Source  Hansen & Travis, Space Sci. Rev. 16, 527 (1974), eq. 2.14-2.16.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

namespace malus {

/// The matrix at one angle of scattering.
struct ScatteringElements {
    double F11, F12, F22, F33;

    friend ScatteringElements operator+(const ScatteringElements& a, const ScatteringElements& b) {
        return {a.F11 + b.F11, a.F12 + b.F12, a.F22 + b.F22, a.F33 + b.F33};
    }
    friend ScatteringElements operator*(double w, const ScatteringElements& a) {
        return {w * a.F11, w * a.F12, w * a.F22, w * a.F33};
    }
};

/// The matrix as a function of cos Θ.
using ScatteringMatrix = std::function<ScatteringElements(double cos_angle)>;

/// Molecules; `depolarization` ρ of natural light scattered by 90°, [0, 6/7].
ScatteringMatrix rayleigh_matrix(double depolarization);

/// F11 = F22 = (1−g²)/(1+g²−2gc)^{3/2},  F12 = −p F11 (1−c²)/(1+c²),  F33 = 2c F11/(1+c²): Henyey and
/// Greenstein's function with the polarization of molecules, p times as strong. |g| < 1, p in [0, 1].
ScatteringMatrix henyey_greenstein_matrix(double asymmetry, double polarization);

/// One row of a table of a scattering matrix.
struct ScatteringRow {
    double angle;  ///< rad
    ScatteringElements F;
};

/// From a table over angles that ascend from 0 to π, F11 > 0 in any unit: brought to the norm; between
/// rows ln F11 and the ratios to F11 are linear in the angle.
ScatteringMatrix tabulated_matrix(std::vector<ScatteringRow> rows);

}  // namespace malus
