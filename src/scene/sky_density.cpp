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
                       const std::function<double(const DomePoint&)>& brightness) {
    std::vector<double> r;
    for (double t : cells.t) r.push_back(std::sqrt(t));
    r_ = GuidedAxis(std::move(r));
    first_.push_back(0);
    std::vector<double> chance_of_ring;
    for (std::size_t ring = 0; ring < r_.cells(); ++ring) {
        const double t = cells.t[ring], height = cells.t[ring + 1] - t;
        const double width = 2 * kPi / static_cast<double>(cells.parts[ring]);
        std::vector<double> chance_of_part(cells.parts[ring], 0.0);
        double sum = 0;
        for (std::size_t i = 0; i < chance_of_part.size(); ++i) {
            for (double v : {0.25, 0.75})
                for (double u : {0.25, 0.75})
                    chance_of_part[i] +=
                        brightness({t + v * height, (static_cast<double>(i) + u) * width});
            sum += chance_of_part[i];
        }
        parts_.push_back(summed(chance_of_part));
        first_.push_back(first_.back() + cells.parts[ring]);
        chance_of_ring.push_back(sum * width * height);
    }
    rings_ = summed(chance_of_ring);
    if (rings_.cells() == 0) parts_.clear();
    for (std::size_t ring = 0; ring < parts_.size(); ++ring) {
        const double solid_angle =
            2 * kPi / static_cast<double>(cells.parts[ring]) * (cells.t[ring + 1] - cells.t[ring]);
        for (std::size_t i = 0; i < cells.parts[ring]; ++i)
            density_.push_back(
                rings_.width(ring) > 0
                    ? static_cast<float>(rings_.width(ring) * parts_[ring].width(i) / solid_angle)
                    : 0.f);
    }
}

double SkyDensity::pdf(const DomePoint& p) const {
    if (dark()) return 0;
    const std::size_t ring = r_.cell(std::sqrt(p.t)), parts = first_[ring + 1] - first_[ring];
    const auto part =
        static_cast<std::size_t>(p.azimuth * (static_cast<double>(parts) / (2 * kPi)));
    return static_cast<double>(density_[first_[ring] + std::min(parts - 1, part)]);
}

}  // namespace malus
