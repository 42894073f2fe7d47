// scattering_expansion.cpp — expansion by quadrature, sum by recurrence.
// SPDX-License-Identifier: Apache-2.0
#include "scene/scattering_expansion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "malus/core/error.h"
#include "malus/core/vec.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

constexpr int kQuadratureNodes = 1000;
constexpr double kNothing = 1e-13;
constexpr double kMostMissed = 0.01;  // by which the light of a matrix may be off

// P_l, d^l_{02}, d^l_{22} and d^l_{2,−2} at one angle, degree after degree.
class SphericalFunctions {
  public:
    explicit SphericalFunctions(double cos_angle) : c_(cos_angle) {}

    double P = 1, d02 = 0, d22 = 0, d2m2 = 0;

    void next() {
        const double l = l_;
        P_before_ = std::exchange(P, ((2 * l + 1) * c_ * P - l * P_before_) / (l + 1));
        ++l_;
        if (l_ < 2) return;
        if (l_ == 2) {
            d02 = std::sqrt(6.0) / 4 * (1 - c_ * c_);
            d22 = sqr((1 + c_) / 2);
            d2m2 = sqr((1 - c_) / 2);
            return;
        }
        // l (√((l+1)²−m²) √((l+1)²−n²)) d^{l+1} =
        //   (2l+1)(l(l+1) c − mn) d^l − (l+1) √(l²−m²) √(l²−n²) d^{l−1}
        const double below = l * l - 4, above = (l + 1) * (l + 1) - 4;
        const auto step = [&](double& d, double& before, double mn, double s0, double s1) {
            const double up =
                ((2 * l + 1) * (l * (l + 1) * c_ - mn) * d - (l + 1) * s0 * before) / (l * s1);
            before = std::exchange(d, up);
        };
        step(d02, d02_before_, 0, l * std::sqrt(below), (l + 1) * std::sqrt(above));
        step(d22, d22_before_, 4, below, above);
        step(d2m2, d2m2_before_, -4, below, above);
    }

  private:
    double c_;
    int l_ = 0;
    double P_before_ = 0, d02_before_ = 0, d22_before_ = 0, d2m2_before_ = 0;
};

}  // namespace

// By Newton's method on the Legendre polynomial.
GaussNodes gauss_nodes(int n) {
    GaussNodes nodes;
    for (int i = 0; i < n; ++i) {
        double z = std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int iteration = 0; iteration < 20; ++iteration) {
            double p = 1, before = 0;
            for (int j = 0; j < n; ++j)
                before = std::exchange(p, ((2 * j + 1) * z * p - j * before) / (j + 1));
            slope = n * (z * p - before) / (z * z - 1);
            const double change = p / slope;
            z -= change;
            if (std::abs(change) < 1e-15) break;
        }
        nodes.x.push_back(0.5 * (1 - z));
        nodes.weight.push_back(1 / ((1 - z * z) * slope * slope));
    }
    return nodes;
}

ScatteringExpansion::ScatteringExpansion(const ScatteringMatrix& F, int degrees) {
    static const GaussNodes nodes = gauss_nodes(kQuadratureNodes);
    terms_.assign(static_cast<std::size_t>(degrees) + 1, Term{});
    for (std::size_t i = 0; i < nodes.x.size(); ++i) {
        const double c = 2 * nodes.x[i] - 1;
        const ScatteringElements at = F(c);
        SphericalFunctions d(c);
        double scale = nodes.weight[i];  // (2l+1)/2 dc
        for (Term& term : terms_) {
            term.F11 += scale * at.F11 * d.P;
            term.F12 += scale * at.F12 * d.d02;
            term.plus += scale * (at.F22 + at.F33) * d.d22;
            term.minus += scale * (at.F22 - at.F33) * d.d2m2;
            scale += 2 * nodes.weight[i];
            d.next();
        }
    }
    // What the quadrature misses of a sharp table must not be light that is lost.
    const double norm = terms_[0].F11;
    if (norm == 0) {  // nothing scatters
        peak_ = 0;
        terms_.resize(1);
        return;
    }
    if (!(std::abs(norm - 1) < kMostMissed))
        throw Error("the scattering matrix changes too fast with the angle to be integrated (" +
                    to_text(std::round(1e4 * norm) / 1e2) +
                    " % of its light found); leave out the peak narrower than about 0.2 degrees");
    for (Term& term : terms_)
        term = {term.F11 / norm, term.F12 / norm, term.plus / norm, term.minus / norm};
    peak_ = terms_.back().F11 / (2 * degrees + 1);
    if (std::abs(peak_) < kNothing) peak_ = 0;
    terms_.pop_back();
    for (std::size_t l = 0; l < terms_.size(); ++l) {
        const double straight_on = peak_ * (2 * static_cast<double>(l) + 1);
        terms_[l].F11 -= straight_on;
        if (l >= 2) terms_[l].plus -= 2 * straight_on;
    }
    const auto nothing = [](const Term& t) {
        return std::max({std::abs(t.F11), std::abs(t.F12), std::abs(t.plus), std::abs(t.minus)}) <
               1e2 * kNothing;
    };
    while (terms_.size() > 3 && nothing(terms_.back())) terms_.pop_back();
}

ScatteringElements ScatteringExpansion::smooth(double cos_angle) const {
    SphericalFunctions d(cos_angle);
    ScatteringElements F{};
    double plus = 0, minus = 0;
    for (const Term& term : terms_) {
        F.F11 += term.F11 * d.P;
        F.F12 += term.F12 * d.d02;
        plus += term.plus * d.d22;
        minus += term.minus * d.d2m2;
        d.next();
    }
    F.F22 = 0.5 * (plus + minus);
    F.F33 = 0.5 * (plus - minus);
    return F;
}

}  // namespace malus
