// sky_density.cpp — tables of chances.
// SPDX-License-Identifier: Apache-2.0
#include "scene/sky_density.h"

namespace malus {
namespace {

// Weights as an axis of their sums, from 0 to 1. Empty where all are 0.
GuidedAxis summed(const std::vector<double>& weights) {
    std::vector<double> sums{0};
    for (double w : weights) sums.push_back(sums.back() + w);
    if (!(sums.back() > 0)) return {};
    const double total = sums.back();
    for (double& x : sums) x /= total;
    return GuidedAxis(std::move(sums));
}

}  // namespace

DomeCells DomeCells::equal_area(std::size_t rings) {
    DomeCells cells;
    for (std::size_t k = 0; k <= rings; ++k) {
        const double r = static_cast<double>(k) / static_cast<double>(rings);
        cells.t.push_back(r * r);
        if (k < rings) cells.parts.push_back(4 * (2 * k + 1));
    }
    return cells;
}

SkyDensity::SkyDensity(const DomeCells& cells,
                       const std::function<double(const DomePoint&)>& brightness)
    : t_(cells.t) {
    std::vector<double> chance_of_ring;
    for (std::size_t ring = 0; ring < t_.cells(); ++ring) {
        const double part = 2 * kPi / static_cast<double>(cells.parts[ring]);
        std::vector<double> chance_of_part(cells.parts[ring], 0.0);
        double sum = 0;
        for (std::size_t i = 0; i < chance_of_part.size(); ++i) {
            for (double v : {0.25, 0.75})
                for (double u : {0.25, 0.75})
                    chance_of_part[i] += brightness(
                        {t_.node(ring) + v * t_.width(ring), (static_cast<double>(i) + u) * part});
            sum += chance_of_part[i];
        }
        parts_.push_back(summed(chance_of_part));
        chance_of_ring.push_back(sum * part * t_.width(ring));
    }
    rings_ = summed(chance_of_ring);
    if (rings_.cells() == 0) parts_.clear();
}

SkyDensity::Draw SkyDensity::draw(double u1, double u2) const {
    const std::size_t ring = rings_.cell(u1);
    const GuidedAxis& parts = parts_[ring];
    const std::size_t part = parts.cell(u2);
    const double width = 2 * kPi / static_cast<double>(parts.cells());
    const DomePoint point{t_.node(ring) + rings_.fraction(ring, u1) * t_.width(ring),
                          (static_cast<double>(part) + parts.fraction(part, u2)) * width};
    return {point, rings_.width(ring) * parts.width(part) / (t_.width(ring) * width)};
}

double SkyDensity::pdf(const DomePoint& p) const {
    if (dark()) return 0;
    const std::size_t ring = t_.cell(p.t);
    if (!(rings_.width(ring) > 0)) return 0;
    const GuidedAxis& parts = parts_[ring];
    const double per_part = static_cast<double>(parts.cells()) / (2 * kPi);
    const std::size_t part =
        std::min(parts.cells() - 1, static_cast<std::size_t>(p.azimuth * per_part));
    return rings_.width(ring) * parts.width(part) * per_part / t_.width(ring);
}

}  // namespace malus
