// sampling_plan.cpp — rounds of samples, even or where the error is.
// SPDX-License-Identifier: Apache-2.0
#include "render/sampling_plan.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace malus {
namespace {

constexpr int kTileSide = 4;         // pixels
constexpr std::uint32_t kPilot = 4;  // samples a replicate before errors are believed
constexpr double kShare = 0.95;      // of the pixels that must meet the target
constexpr double kGiveUp = 0.025;    // of the pixels: the hardest, left at the mean of all
constexpr double kFall = 0.7;        // of the goal from round to round
// Where a tile's true error is E, 97.5 % of the estimates (7 degrees of freedom) are below 1.5 E.
constexpr double kSpread = 1.5;
constexpr double kSlope = 0.6;  // error ~ samples^-slope, to foresee what a tile needs

// Half of an octave on: 1, 2, 3, 4, 6, 8, 12, …
std::uint32_t next_level(std::uint32_t samples) {
    std::uint32_t level = std::bit_floor(std::max(1u, samples));
    if (level > samples) return level;
    const std::uint32_t middle = level + level / 2;
    return middle > samples ? middle : 2 * level;
}

}  // namespace

SamplingPlan::SamplingPlan(const RenderSettings& settings, const Exposure& exposure)
    : settings_(settings),
      width_(static_cast<std::size_t>(settings.width)),
      cap_(whole_spp(settings.spp, exposure.replicates) / exposure.replicates) {
    for (int y = 0; y < settings.height; y += kTileSide)
        for (int x = 0; x < settings.width; x += kTileSide)
            tiles_.push_back({x, y, std::min(x + kTileSide, settings.width),
                              std::min(y + kTileSide, settings.height)});
    tile_error_.resize(tiles_.size());
    surface_.resize(tiles_.size());
    if (adaptive()) pixel_error_.resize(exposure.pixel_count(), -1.0f);
}

template <class Visit>
void SamplingPlan::for_each_pixel(std::size_t t, Visit visit) const {
    const Tile& tile = tiles_[t];
    for (int y = tile.y0; y < tile.y1; ++y)
        for (int x = tile.x0; x < tile.x1; ++x)
            visit(static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x));
}

void SamplingPlan::measure(const Film& film, std::size_t t) {
    if (!adaptive()) return;
    const std::size_t wavelengths = film.wavelengths_nm.size();
    std::vector<double> s0(wavelengths), dolp(wavelengths);  // sums of squares
    surface_[t] = 0;
    for_each_pixel(t, [&](std::size_t i) {
        const std::optional<double> error = pixel_error(film, i);
        pixel_error_[i] = error ? static_cast<float>(*error) : -1.0f;
        if (!error) return;
        ++surface_[t];
        for (std::size_t w = 0; w < wavelengths; ++w) {
            s0[w] += sqr(relative_stderr_s0(film.at(i, w)));
            dolp[w] += sqr(stderr_dolp(film.at(i, w)));
        }
    });
    const double largest = std::max(*std::max_element(s0.begin(), s0.end()),
                                    *std::max_element(dolp.begin(), dolp.end()));
    tile_error_[t] = surface_[t] ? static_cast<float>(std::sqrt(largest / surface_[t])) : 0;
}

std::size_t SamplingPlan::first_pixel(std::size_t t) const {
    return static_cast<std::size_t>(tiles_[t].y0) * width_ + static_cast<std::size_t>(tiles_[t].x0);
}

std::vector<std::size_t> SamplingPlan::round(const Exposure& exposure) const {
    std::vector<std::size_t> tiles;
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
        bool wants = false;
        for_each_pixel(t, [&](std::size_t i) { wants |= exposure.taken[i] < exposure.wanted[i]; });
        if (wants) tiles.push_back(t);
    }
    return tiles;
}

std::optional<StoppedBy> SamplingPlan::plan_round(Exposure& exposure) const {
    // A render that goes on first ends the round in which it was stopped.
    for (std::size_t i = 0; i < exposure.pixel_count(); ++i)
        if (exposure.taken[i] < std::min(exposure.wanted[i], cap_)) return std::nullopt;
    const std::uint32_t least = *std::min_element(exposure.taken.begin(), exposure.taken.end());
    if (!adaptive() || least < std::min(kPilot, cap_)) return plan_evenly(exposure, least);
    return plan_adaptively(exposure);
}

// One sample of each replicate, then two, four, … in all pixels.
std::optional<StoppedBy> SamplingPlan::plan_evenly(Exposure& exposure, std::uint32_t least) const {
    if (least >= cap_) return StoppedBy::kSamples;
    const std::uint32_t level = std::min(cap_, least == 0 ? 1 : 2 * std::bit_floor(least));
    for (std::size_t i = 0; i < exposure.pixel_count(); ++i)
        exposure.wanted[i] = std::max(exposure.taken[i], level);
    return std::nullopt;
}

std::optional<StoppedBy> SamplingPlan::plan_adaptively(Exposure& exposure) const {
    const double error = error_of_most();
    if (error <= settings_.target_error) return StoppedBy::kTargetError;
    double goal = std::max(settings_.target_error, kFall * error) / kSpread;
    // Scattered bad pixels in good tiles may keep the target from being met: then lower the goal.
    for (;; goal *= 0.9) {
        if (beyond_help(exposure)) return StoppedBy::kSamples;
        const std::vector<std::size_t> tiles = above(goal, exposure);
        if (tiles.empty()) continue;
        for (std::size_t t : tiles)
            for_each_pixel(t, [&](std::size_t i) {
                exposure.wanted[i] = std::min(cap_, next_level(exposure.taken[i]));
            });
        return std::nullopt;
    }
}

// Have more pixels than may miss the target had all the samples they can get?
bool SamplingPlan::beyond_help(const Exposure& exposure) const {
    double surface = 0, lost = 0, open = 0;
    for (std::size_t i = 0; i < exposure.pixel_count(); ++i) {
        if (pixel_error_[i] < 0) continue;
        const bool capped = exposure.taken[i] >= cap_;
        surface += 1;
        open += !capped;
        lost += capped && static_cast<double>(pixel_error_[i]) > settings_.target_error;
    }
    return open == 0 || lost > (1 - kShare) * surface;
}

double SamplingPlan::error_of_most() const {
    std::vector<double> errors;
    for (float e : pixel_error_)
        if (e >= 0) errors.push_back(static_cast<double>(e));
    return quantile(std::move(errors), kShare);
}

std::vector<std::size_t> SamplingPlan::above(double goal, const Exposure& exposure) const {
    struct Candidate {
        std::size_t tile;
        double need;  // samples a replicate
    };
    std::vector<Candidate> candidates;
    double surface = 0, samples = 0;
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
        const double n = exposure.taken[first_pixel(t)],
                     error = static_cast<double>(tile_error_[t]);
        surface += surface_[t];
        samples += surface_[t] * n;
        if (error > goal && exposure.taken[first_pixel(t)] < cap_)
            candidates.push_back({t, n * std::pow(error / goal, 1 / kSlope)});
    }
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
        return std::tie(a.need, a.tile) > std::tie(b.need, b.tile);
    });
    std::vector<std::size_t> tiles;
    double given_up = 0;
    for (const Candidate& c : candidates) {
        given_up += surface_[c.tile];
        const bool hard = given_up <= kGiveUp * surface;
        if (!hard || exposure.taken[first_pixel(c.tile)] * surface < samples)
            tiles.push_back(c.tile);
    }
    return tiles;
}

double SamplingPlan::left_after_round(const Exposure& exposure) const {
    double left = 0;
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
        const double n = exposure.wanted[first_pixel(t)];
        const double ratio =
            settings_.target_error > 0
                ? kSpread * static_cast<double>(tile_error_[t]) / settings_.target_error
                : HUGE_VAL;
        const double need =
            adaptive() ? exposure.taken[first_pixel(t)] * std::pow(ratio, 1 / kSlope) : HUGE_VAL;
        const Tile& tile = tiles_[t];
        left += (tile.x1 - tile.x0) * (tile.y1 - tile.y0) *
                std::max(0.0, std::min<double>(cap_, need) - n);
    }
    return left * exposure.replicates;
}

}  // namespace malus
