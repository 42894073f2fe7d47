// paths.cpp — the workspace of paths.
// SPDX-License-Identifier: Apache-2.0
#include "render/path_tracer.h"

#include <algorithm>

namespace malus {

void Paths::begin(std::span<const Sampler> samplers) {
    samplers_.assign(samplers.begin(), samplers.end());
    scrambles_.clear();
    blocks_.clear();
}

void Paths::start(std::uint32_t first, std::uint32_t count, std::size_t depths) {
    size_ = count * replicates();
    numbers_.clear();
    for (std::uint32_t sample = first; sample < first + count; ++sample)
        for (std::uint32_t replicate = 0; replicate < replicates(); ++replicate)
            numbers_.push_back({replicate, sample});
    first_vertex_.assign(size_, -1);
    first_instance_.assign(size_, -1);
    first_distance_.assign(size_, 0);
    views_.clear();
    spots_.clear();
    place_.resize(size_);
    levels_.resize(depths);
    for (Level& level : levels_) level.arrivals.clear(), level.vertices.clear();
}

// Lanes in `hit` go on at another depth; the places of their vertices, −1 for the others.
std::array<int, kSide> Paths::arrive(int depth, unsigned hit,
                                     const std::array<std::uint32_t, kSide>& path,
                                     const Vec3s& direction, const Vec3s& toward_x,
                                     const std::array<Met, kSide>& met) {
    std::array<int, kSide> place;
    place.fill(-1);
    if (!hit) return place;
    std::vector<Arrival>& arrivals = level(depth).arrivals;
    const auto directions = stored(direction), toward = stored(toward_x);
    for (std::size_t i = 0; i < kSide; ++i) {
        if (!(hit >> i & 1)) continue;
        place[i] = static_cast<int>(arrivals.size());
        arrivals.push_back({directions[i], toward[i], met[i], path[i]});
    }
    return place;
}

// The scrambles of a block, one a replicate.
const Scramble* Paths::scrambles(std::uint32_t block) {
    const auto known = std::find(blocks_.begin(), blocks_.end(), block);
    const auto at = static_cast<std::size_t>(known - blocks_.begin());
    if (known == blocks_.end()) {
        blocks_.push_back(block);
        for (const Sampler& sampler : samplers_) scrambles_.push_back(sampler.scramble(block));
    }
    return &scrambles_[at * replicates()];
}

PointPlaces Paths::places(const std::array<std::uint32_t, kSide>& path, std::uint32_t block) {
    const Scramble* own = scrambles(block);
    PointPlaces places;
    for (std::size_t i = 0; i < kSide; ++i) {
        const auto& [replicate, sample] = numbers_[path[i]];
        places.scramble[i] = own + replicate;
        places.sample[i] = sample;
    }
    return places;
}

void Paths::count(const Rays& traced, unsigned active, RayKind kind) {
    rays += static_cast<std::uint64_t>(std::popcount(active));
    if (!log) return;
    const auto origins = stored(traced.origin), directions = stored(traced.direction);
    for (std::size_t i = 0; i < kSide; ++i)
        if (active >> i & 1) log->push_back({{origins[i], directions[i]}, kind});
}

const float* Paths::light_of(int depth, int place, std::size_t wavelengths) const {
    const auto at = static_cast<std::size_t>(place);
    return &levels_[static_cast<std::size_t>(depth - 1)]
                .light[at / kSide * block_size(4 * wavelengths) + at % kSide];
}

// Do paths `first` to first + kSide − 1 stand in the registers of their first vertices in order?
bool Paths::in_order(std::size_t first) const {
    const int place = first_vertex_[first];
    if (place % static_cast<int>(kSide) != 0 || first + kSide > size_) return false;
    for (std::size_t i = 1; i < kSide; ++i)
        if (first_vertex_[first + i] != place + static_cast<int>(i)) return false;
    return true;
}

void Paths::light(std::size_t sample, std::size_t wavelengths, float* S) const {
    const std::size_t R = replicates(), first = sample * R, rows = 4 * wavelengths;
    for (std::size_t r = 0; r < R;) {
        const std::size_t i = first + r;
        const bool surface = first_vertex_[i] >= 0;
        const bool together = surface && r + kSide <= R && in_order(i);
        const float* from = surface ? light_of(1, first_vertex_[i], wavelengths)
                                    : &view_light_[i / kSide * block_size(rows) + i % kSide];
        if (together)
            for (std::size_t j = 0; j < rows; ++j)
                std::copy_n(from + j * kSide, kSide, S + j * R + r);
        else
            for (std::size_t j = 0; j < rows; ++j) S[j * R + r] = from[j * kSide];
        r += together ? kSide : 1;
    }
}

float* Paths::arriving(std::size_t block) {
    arriving_.resize(std::max(arriving_.size(), 3 * block));
    return arriving_.data();
}

// Is the open sky known of one of these first vertices?
bool Paths::knows_sky(std::size_t vertices) const {
    return std::any_of(spots_[vertices].begin(), spots_[vertices].end(),
                       [](const SkySpot& spot) { return spot.cell >= 0; });
}

Paths::Open Paths::open(std::size_t i, std::size_t wavelengths) const {
    if (spots_.empty() || first_vertex_[i] < 0) return {};
    const auto place = static_cast<std::size_t>(first_vertex_[i]);
    const SkySpot& spot = spots_[place / kSide][place % kSide];
    if (spot.cell < 0) return {};
    return {&spot, &open_light_[place / kSide * block_size(5 * wavelengths) + place % kSide]};
}

}  // namespace malus
