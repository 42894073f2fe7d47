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

// SE(S0)²/S0² and SE(DoLP)².
struct Squares {
    double s0, dolp;
    double larger() const { return std::max(s0, dolp); }
};
Squares squares(const PixelStokes& pixel) {
    const double c00 = static_cast<double>(pixel.covariance[0]);
    return {pixel.mean.s0 > 0 ? c00 / sqr(pixel.mean.s0) : 0, sqr(stderr_dolp(pixel))};
}

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
    std::vector<Squares> sums(wavelengths, Squares{0, 0});
    std::uint32_t surface = 0;
    for_each_pixel(t, [&](std::size_t i) {
        if (!(film.coverage[i] > 0)) return;
        ++surface;
        double largest = 0;
        for (std::size_t w = 0; w < wavelengths; ++w) {
            const Squares e = squares(film.at(i, w));
            sums[w].s0 += e.s0, sums[w].dolp += e.dolp;
            largest = std::max(largest, e.larger());
        }
        pixel_error_[i] = static_cast<float>(std::sqrt(largest));
    });
    double largest = 0;
    for (const Squares& sum : sums) largest = std::max(largest, sum.larger());
    surface_[t] = surface;
    tile_error_[t] = surface ? static_cast<float>(std::sqrt(largest / surface)) : 0;
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

// The error that 95 % of the pixels have at most.
double SamplingPlan::error_of_most() const {
    std::vector<float> errors;
    for (float e : pixel_error_)
        if (e >= 0) errors.push_back(e);
    if (errors.empty()) return 0;
    const auto at =
        static_cast<std::ptrdiff_t>(std::ceil(kShare * static_cast<double>(errors.size())) - 1);
    std::nth_element(errors.begin(), errors.begin() + at, errors.end());
    return static_cast<double>(errors[static_cast<std::size_t>(at)]);
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
