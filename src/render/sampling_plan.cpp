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
// Where the true error is E everywhere, 97.5 % of its estimates (7 degrees of freedom) are below
// 1.5 E.
constexpr double kSpread = 1.5;
// What the neighbours say of a pixel counts more than what it says itself: where few samples carry
// the light, most pixels take their error for too small. Toward small targets, where work goes to
// few pixels of rare bright samples, 1.2 left 1.07 of a target of 0.001 on target B, 1.35 leaves 0.89.
constexpr double kNeighbours = 1.35;
constexpr double kMost = 3;     // times its own error: one outlier must not spoil eight others
constexpr double kSlope = 0.6;  // error ~ samples^-slope, to foresee what a pixel needs

// Half of an octave on: 1, 2, 3, 4, 6, 8, 12, …
std::uint32_t next_level(std::uint32_t samples) {
    const std::uint32_t level = std::bit_floor(std::max(1u, samples));
    if (level > samples) return level;
    const std::uint32_t middle = level + level / 2;
    return middle > samples ? middle : 2 * level;
}

}  // namespace

SamplingPlan::SamplingPlan(const RenderSettings& settings, const Exposure& exposure)
    : settings_(settings),
      width_(settings.width),
      height_(settings.height),
      cap_(whole_spp(settings.spp, exposure.replicates) / exposure.replicates) {
    for (int y = 0; y < height_; y += kTileSide)
        for (int x = 0; x < width_; x += kTileSide)
            tiles_.push_back(
                {x, y, std::min(x + kTileSide, width_), std::min(y + kTileSide, height_)});
    if (adaptive()) error_.resize(exposure.pixel_count(), -1.0f);
}

void SamplingPlan::measure(const Film& film, std::size_t pixel) {
    constexpr double kHuge = 1e6;  // keeps what overflowed finite
    if (adaptive())
        error_[pixel] = static_cast<float>(std::min(kHuge, pixel_error(film, pixel).value_or(-1)));
}

std::vector<std::size_t> SamplingPlan::round(const Exposure& exposure) const {
    const auto wants = [&](const Tile& tile) {
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x) {
                const std::size_t i = index(x, y);
                if (exposure.taken[i] < exposure.wanted[i]) return true;
            }
        return false;
    };
    std::vector<std::size_t> tiles;
    for (std::size_t t = 0; t < tiles_.size(); ++t)
        if (wants(tiles_[t])) tiles.push_back(t);
    return tiles;
}

std::optional<StoppedBy> SamplingPlan::plan_round(Exposure& exposure) const {
    // A render that goes on first ends the round in which it was stopped.
    bool unfinished = false;
    for (std::size_t i = 0; i < exposure.pixel_count(); ++i) {
        exposure.wanted[i] = std::max(exposure.taken[i], std::min(exposure.wanted[i], cap_));
        unfinished |= exposure.taken[i] < exposure.wanted[i];
    }
    if (unfinished) return std::nullopt;
    const std::uint32_t least = *std::min_element(exposure.taken.begin(), exposure.taken.end());
    if (!adaptive() || least < std::min(kPilot, cap_)) return plan_evenly(exposure, least);
    return plan_adaptively(exposure, least);
}

// One sample of each replicate, then four, eight, … in all pixels.
std::optional<StoppedBy> SamplingPlan::plan_evenly(Exposure& exposure, std::uint32_t least) const {
    if (least >= cap_) return StoppedBy::kSamples;
    const std::uint32_t level =
        std::min(cap_, least == 0 ? 1 : std::max(4u, 2 * std::bit_floor(least)));
    for (std::size_t i = 0; i < exposure.pixel_count(); ++i)
        exposure.wanted[i] = std::max(exposure.taken[i], level);
    return std::nullopt;
}

std::optional<StoppedBy> SamplingPlan::plan_adaptively(Exposure& exposure,
                                                       std::uint32_t least) const {
    const std::vector<double> smoothed = smoothed_errors();
    const double error = error_of_most(smoothed);
    if (error <= settings_.target_error && settings_.target_error > 0)
        return StoppedBy::kTargetError;
    if (error == 0) return plan_evenly(exposure, least);
    if (beyond_help(exposure)) return StoppedBy::kSamples;
    // Scattered bad pixels in good places may keep the target from being met: then the goal falls
    // to what is worst among the others.
    double worst = 0;
    for (std::size_t i = 0; i < smoothed.size(); ++i)
        if (exposure.taken[i] < cap_) worst = std::max(worst, smoothed[i]);
    const double goal =
        std::min(0.9 * worst, std::max(settings_.target_error, kFall * error) / kSpread);
    for (std::size_t i : above(goal, smoothed, exposure))
        exposure.wanted[i] = std::min(cap_, next_level(exposure.taken[i]));
    keep_pace(exposure);
    return std::nullopt;
}

// A pixel that has not met a surface yet may show a little of one beside it: it gets as many samples
// as the least sampled of these, or edges would look thinner than they are.
void SamplingPlan::keep_pace(Exposure& exposure) const {
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const std::size_t i = index(x, y);
            if (error_[i] >= 0) continue;
            std::uint32_t least = cap_ + 1;
            for_neighbours(x, y, [&](int u, int v) {
                if (error_[index(u, v)] >= 0) least = std::min(least, exposure.wanted[index(u, v)]);
            });
            if (least <= cap_) exposure.wanted[i] = std::max(exposure.wanted[i], least);
        }
}

// The pixel itself and those around it.
template <class Visit>
void SamplingPlan::for_neighbours(int x, int y, Visit visit) const {
    for (int v = std::max(0, y - 1); v <= std::min(height_ - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(width_ - 1, x + 1); ++u) visit(u, v);
}

// Have more pixels than may miss the target had all the samples they can get?
bool SamplingPlan::beyond_help(const Exposure& exposure) const {
    double surface = 0, lost = 0, open = 0;
    for (std::size_t i = 0; i < error_.size(); ++i) {
        if (error_[i] < 0) continue;
        const bool capped = exposure.taken[i] >= cap_;
        surface += 1;
        open += !capped && error_[i] > 0;
        lost += capped && static_cast<double>(error_[i]) > settings_.target_error;
    }
    return open == 0 || lost > (1 - kShare) * surface;
}

double SamplingPlan::error_of_most(const std::vector<double>& smoothed) const {
    std::vector<double> errors;
    for (std::size_t i = 0; i < error_.size(); ++i)
        if (error_[i] >= 0)
            errors.push_back(std::max(static_cast<double>(error_[i]), kNeighbours * smoothed[i]));
    return quantile(std::move(errors), kShare);
}

std::vector<double> SamplingPlan::smoothed_errors() const {
    std::vector<double> smoothed(error_.size(), -1.0);
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const double own = static_cast<double>(error_[index(x, y)]);
            if (own < 0) continue;
            double squares = 0, weights = 0;
            for_neighbours(x, y, [&](int u, int v) {
                const double e = static_cast<double>(error_[index(u, v)]);
                if (e < 0) return;
                const double weight = (u == x ? 2 : 1) * (v == y ? 2 : 1);
                squares += weight * sqr(std::min(e, kMost * own)), weights += weight;
            });
            smoothed[index(x, y)] = std::sqrt(squares / weights);
        }
    return smoothed;
}

std::vector<std::size_t> SamplingPlan::above(double goal, const std::vector<double>& smoothed,
                                             const Exposure& exposure) const {
    struct Candidate {
        std::size_t pixel;
        double need;  // samples a replicate
    };
    std::vector<Candidate> candidates;
    double surface = 0, samples = 0;
    for (std::size_t i = 0; i < smoothed.size(); ++i) {
        if (smoothed[i] < 0) continue;
        const double n = exposure.taken[i];
        surface += 1, samples += n;
        if (smoothed[i] > goal && exposure.taken[i] < cap_)
            candidates.push_back({i, n * std::pow(smoothed[i] / goal, 1 / kSlope)});
    }
    const auto hard = static_cast<std::ptrdiff_t>(
        std::min(kGiveUp * surface, static_cast<double>(candidates.size())));
    std::nth_element(candidates.begin(), candidates.begin() + hard, candidates.end(),
                     [](const Candidate& a, const Candidate& b) {
                         return std::tie(a.need, a.pixel) > std::tie(b.need, b.pixel);
                     });
    std::vector<std::size_t> pixels;
    for (auto c = candidates.begin(); c != candidates.end(); ++c)
        if (c - candidates.begin() >= hard || exposure.taken[c->pixel] * surface < samples)
            pixels.push_back(c->pixel);
    if (pixels.empty())  // none but hard ones are left
        for (const Candidate& c : candidates) pixels.push_back(c.pixel);
    return pixels;
}

double SamplingPlan::left_after_round(const Exposure& exposure) const {
    const double goal = settings_.target_error / kSpread;
    double left = 0;
    for (std::size_t i = 0; i < exposure.pixel_count(); ++i) {
        double need = cap_;
        if (adaptive() && goal > 0 && error_[i] < goal)
            need = 0;
        else if (adaptive() && goal > 0)
            need = exposure.taken[i] * std::pow(static_cast<double>(error_[i]) / goal, 1 / kSlope);
        left += std::max(0.0, std::min<double>(need, cap_) - exposure.wanted[i]);
    }
    return left * exposure.replicates;
}

}  // namespace malus
