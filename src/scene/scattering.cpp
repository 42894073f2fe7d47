// scattering.cpp — scattering matrices, closed and tabulated.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/scattering.h"

#include <algorithm>
#include <cmath>

#include "malus/core/contract.h"
#include "malus/core/vec.h"

namespace malus {
namespace {

// ½ ∫ F11 dcosΘ of F11 whose logarithm is linear in the angle between rows: 32 steps a row.
double half_integral(const std::vector<ScatteringRow>& rows) {
    constexpr int kSteps = 32;
    double sum = 0;
    for (std::size_t i = 1; i < rows.size(); ++i) {
        const double step = (rows[i].angle - rows[i - 1].angle) / kSteps;
        const double ratio = rows[i].F.F11 / rows[i - 1].F.F11;
        for (int k = 0; k < kSteps; ++k) {
            const double t = (k + 0.5) / kSteps;
            sum += 0.5 * step * std::sin(rows[i - 1].angle + t * step * kSteps) *
                   rows[i - 1].F.F11 * std::pow(ratio, t);
        }
    }
    return sum;
}

}  // namespace

ScatteringMatrix rayleigh_matrix(double depolarization) {
    const double D = (1 - depolarization) / (1 + depolarization / 2);
    return [D](double c) {
        const double a = 0.75 * D * (1 + c * c);
        return ScatteringElements{a + 1 - D, -0.75 * D * (1 - c * c), a, 1.5 * D * c};
    };
}

ScatteringMatrix henyey_greenstein_matrix(double asymmetry, double polarization) {
    return [g = asymmetry, p = polarization](double c) {
        const double x = 1 + g * g - 2 * g * c;
        const double F11 = (1 - g * g) / (x * std::sqrt(x));
        const double d = 1 + c * c;
        return ScatteringElements{F11, -p * F11 * (1 - c * c) / d, F11, 2 * c * F11 / d};
    };
}

ScatteringMatrix tabulated_matrix(std::vector<ScatteringRow> rows) {
    EXPECT(rows.size() >= 2 && rows.front().angle == 0);
    const double norm = half_integral(rows);
    for (ScatteringRow& row : rows)
        row.F = {row.F.F11 / norm, row.F.F12 / norm, row.F.F22 / norm, row.F.F33 / norm};
    return [rows = std::move(rows)](double c) {
        const double angle = std::acos(std::clamp(c, -1.0, 1.0));
        const auto above =
            std::upper_bound(rows.begin() + 1, rows.end() - 1, angle,
                             [](double x, const ScatteringRow& row) { return x < row.angle; });
        const ScatteringRow &a = *(above - 1), &b = *above;
        const double t = std::clamp((angle - a.angle) / (b.angle - a.angle), 0.0, 1.0);
        const double F11 = a.F.F11 * std::pow(b.F.F11 / a.F.F11, t);
        const auto times_ratio = [&](double ScatteringElements::*F) {
            return F11 * ((1 - t) * a.F.*F / a.F.F11 + t * b.F.*F / b.F.F11);
        };
        return ScatteringElements{F11, times_ratio(&ScatteringElements::F12),
                                  times_ratio(&ScatteringElements::F22),
                                  times_ratio(&ScatteringElements::F33)};
    };
}

}  // namespace malus
