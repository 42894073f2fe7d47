// open_light.cpp — nodes weighed, cell by cell.
// SPDX-License-Identifier: Apache-2.0
#include "render/open_light.h"

#include <algorithm>

namespace malus {

void OpenLight::begin(const SkyTable& table, int pixel_x, int pixel_y) {
    table_ = &table;
    pixel_x_ = pixel_x, pixel_y_ = pixel_y;
    used_ = 0;
}

bool OpenLight::find(const Paths& paths, std::size_t sample) {
    const std::size_t R = spots_.size();
    bool any = false;
    for (std::size_t r = 0; r < R; ++r) {
        spots_[r] = paths.open(sample * R + r, wavelengths_).spot;
        any |= spots_[r] != nullptr;
    }
    if (!any) return false;
    std::fill(light_.begin(), light_.end(), 0.f);
    for (std::size_t r = 0; r < R; ++r) {
        const auto same = [&](const SkySpot* s) { return s && s->cell == spots_[r]->cell; };
        if (!spots_[r] || std::any_of(spots_.begin(), spots_.begin() + std::ptrdiff_t(r), same))
            continue;
        std::fill(weights_.begin(), weights_.end(), 0.f);
        for (std::size_t i = r; i < R; ++i)
            if (same(spots_[i]))
                for (std::size_t k = 0; k < kCorners; ++k)
                    weights_[k * R + i] = spots_[i]->weight[k];
        add_weighted(corners(spots_[r]->cell));
    }
    return true;
}

void OpenLight::subtract(const Paths& paths, std::size_t sample) {
    const std::size_t R = spots_.size();
    for (std::size_t r = 0; r < R; ++r)
        if (const Paths::Open open = paths.open(sample * R + r, wavelengths_); open.spot)
            for (std::size_t j = 0; j < 4 * wavelengths_; ++j)
                light_[j * R + r] -= open.light[j * kSide];
}

const SkyTable::Corners& OpenLight::corners(int cell) {
    for (std::size_t i = 0; i < used_; ++i)
        if (cells_[i].index == cell) return cells_[i].corners;
    if (cells_.size() == used_) cells_.emplace_back();
    Cell& seen = cells_[used_++];
    seen.index = cell;
    seen.corners = table_->corners(cell, pixel_x_, pixel_y_, seen.space);
    return seen.corners;
}

// light[j][r] += Σ weights[k][r] corners[k][j][r]
void OpenLight::add_weighted(const SkyTable::Corners& corners) {
    const std::size_t R = spots_.size();
    std::size_t r = 0;
    for (; r + kSide <= R; r += kSide) {
        std::array<Reals, kCorners> weight;
        for (std::size_t k = 0; k < kCorners; ++k) weight[k] = load_floats(&weights_[k * R + r]);
        for (std::size_t i = r; i < light_.size(); i += R) {
            Reals sum = load_floats(&light_[i]);
            for (std::size_t k = 0; k < kCorners; ++k)
                sum = sum + weight[k] * load_floats(corners[k] + i);
            store_floats(sum, &light_[i]);
        }
    }
    for (; r < R; ++r)
        for (std::size_t i = r; i < light_.size(); i += R)
            for (std::size_t k = 0; k < kCorners; ++k)
                light_[i] += weights_[k * R + r] * corners[k][i];
}

}  // namespace malus
