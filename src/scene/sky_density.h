// sky_density.h — draws directions of the dome by brightness.
//
// Cells   rings between ascending t = 1 − cos z, each cut in equal parts by azimuth; the density is
//         constant in each. One random number draws the ring and the zenith angle in it, the other
//         the azimuth: what lies close together in them stays close together, which keeps
//         quasi-Monte Carlo points even (an alias table would shuffle them), and light on level
//         ground depends mostly on the first.
// Time    constant on average, of drawing and of looking up.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>

#include "malus/scene/guided_axis.h"
#include "scene/equal_area.h"

namespace malus {

/// The rings and parts of a distribution: ring i lies between t[i] and t[i + 1] and has parts[i].
struct DomeCells {
    std::vector<double> t;  ///< ascending from 0 to 1
    std::vector<std::size_t> parts;

    /// 4 (2k + 1) parts in ring k of `rings`: all of the same solid angle.
    static DomeCells equal_area(std::size_t rings);
};

class SkyDensity {
  public:
    SkyDensity() = default;
    /// brightness(p): of a point, ≥ 0; taken at four points of each cell.
    SkyDensity(const DomeCells& cells, const std::function<double(const DomePoint&)>& brightness);

    /// Is everything dark? Then nothing can be drawn.
    bool dark() const { return parts_.empty(); }
    struct Draw {
        DomePoint point;
        double pdf;  ///< sr⁻¹
    };
    /// From two numbers in (0,1).
    Draw draw(double u1, double u2) const { return draws<1>({u1}, {u2})[0]; }
    template <std::size_t N>
    std::array<Draw, N> draws(const std::array<double, N>& u1,
                              const std::array<double, N>& u2) const;
    /// Density of draw(), sr⁻¹.
    double pdf(const DomePoint& p) const;

  private:
    GuidedAxis r_;                    // √t of the rings, which are nearly even in it
    GuidedAxis rings_;                // chances summed over rings, from 0 to 1
    std::vector<GuidedAxis> parts_;   // and over the parts of each; none in dark rings
    std::vector<std::size_t> first_;  // of each ring's parts among all, and their number
    std::vector<float> density_;      // of all parts, sr⁻¹
};

template <std::size_t N>
std::array<SkyDensity::Draw, N> SkyDensity::draws(const std::array<double, N>& u1,
                                                  const std::array<double, N>& u2) const {
    std::array<std::size_t, N> ring, part;
    for (std::size_t i = 0; i < N; ++i) ring[i] = rings_.cell(u1[i]);
    for (std::size_t i = 0; i < N; ++i) part[i] = parts_[ring[i]].near(u2[i]);
    std::array<Draw, N> draws;
    for (std::size_t i = 0; i < N; ++i) {
        const GuidedAxis& parts = parts_[ring[i]];
        part[i] = parts.cell(u2[i], part[i]);
        const double t0 = sqr(r_.node(ring[i])), t1 = sqr(r_.node(ring[i] + 1));
        const double width = 2 * kPi / static_cast<double>(parts.cells());
        draws[i] = {{t0 + rings_.fraction(ring[i], u1[i]) * (t1 - t0),
                     (static_cast<double>(part[i]) + parts.fraction(part[i], u2[i])) * width},
                    static_cast<double>(density_[first_[ring[i]] + part[i]])};
    }
    return draws;
}

}  // namespace malus
