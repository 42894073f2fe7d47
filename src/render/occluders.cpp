// occluders.cpp — hidden directions of the dome, square by square.
// SPDX-License-Identifier: Apache-2.0
#include "render/occluders.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "render/points.h"
#include "scene/equal_area.h"

namespace malus {
namespace {

constexpr std::size_t kCells = 16;     // along a side of the dome's square
constexpr std::uint32_t kRays = 2048;  // of a square of the picture
static_assert(kRays % kSide == 0);
constexpr double kDefence = 0.5;
// Share of the sky's hemisphere, by cosθ, that may be hidden: beyond, what is hidden is no small part to
// be found, and light that the sky's brightness would find is missed.
constexpr double kMostHidden = 0.15;

// Mean cosθ of hidden directions in cells of the dome.
class HiddenSky {
  public:
    void add(const SquarePoint& p, double cos_theta, bool hidden) {
        Cell& at = cells_[cell(p.y) * kCells + cell(p.x)];
        at.rays += 1;
        whole_ += cos_theta;
        if (!hidden) return;
        at.sum += cos_theta;
        hidden_ += cos_theta;
    }
    // Of all directions added, by cosθ.
    double share() const { return hidden_ / std::max(whole_, 1e-300); }
    double mean() const {
        double sum = 0;
        for (const Cell& cell : cells_) sum += cell.mean() / (kCells * kCells);
        return sum;
    }
    // Bilinear between the middles of cells.
    double operator()(const SquarePoint& p) const {
        const double x = p.x * kCells - 0.5, y = p.y * kCells - 0.5;
        const double i = std::floor(x), j = std::floor(y), u = x - i, v = y - j;
        return (1 - v) * ((1 - u) * mean(i, j) + u * mean(i + 1, j)) +
               v * ((1 - u) * mean(i, j + 1) + u * mean(i + 1, j + 1));
    }

  private:
    struct Cell {
        double sum = 0, rays = 0;
        double mean() const { return sum / std::max(rays, 1.0); }
    };
    static std::size_t cell(double x) {
        return static_cast<std::size_t>(std::clamp(x, 0.0, 1 - 1e-9) * kCells);
    }
    double mean(double i, double j) const {
        return cells_[cell((j + 0.5) / kCells) * kCells + cell((i + 0.5) / kCells)].mean();
    }
    std::array<Cell, kCells * kCells> cells_;
    double whole_ = 0, hidden_ = 0;
};

Hits side_by_side(const std::array<const Hit*, kSide>& at) {
    Hits hits;
    hits.position = vectors([&](std::size_t i) { return at[i]->position; });
    hits.ng = vectors([&](std::size_t i) { return at[i]->ng; });
    hits.n = vectors([&](std::size_t i) { return at[i]->n; });
    hits.offset = lanewise<Reals>([&](std::size_t i) { return at[i]->offset; });
    return hits;
}

}  // namespace

Occluders::Occluders(const PreparedScene::Impl& scene, int width, int height)
    : scene_(scene), columns_((width + kSquare - 1) / kSquare) {
    const int rows = (height + kSquare - 1) / kSquare;
    toward_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows));
}

std::uint64_t Occluders::look(int square_x, int square_y,
                              std::span<const std::optional<Hit>> seen) {
    std::vector<const Hit*> hits;
    for (const std::optional<Hit>& hit : seen) {
        if (!hit) continue;
        if (scene_.surface_of(hit->instance).sharp())
            return 0;  // its lobes know better where to look
        hits.push_back(&*hit);
    }
    if (hits.empty() || scene_.sky.density().dark()) return 0;
    // Neighbours in the square look in different directions: points of one sequence are dealt out.
    const Sampler sampler(0, index(square_x, square_y), 0);
    const Scramble scramble = sampler.scramble(0);
    HiddenSky hidden;
    std::uint64_t rays = 0;
    for (std::uint32_t first = 0; first < kRays; first += kSide) {
        PointPlaces places;
        places.scramble.fill(&scramble);
        std::iota(places.sample.begin(), places.sample.end(), first);
        const auto u = points<0, 3>(places);
        const auto x = stored(u[0]), y = stored(u[1]), dealt = stored(u[2]);
        std::array<const Hit*, kSide> at;
        for (std::size_t i = 0; i < kSide; ++i)
            at[i] = hits[static_cast<std::size_t>(dealt[i] * static_cast<double>(hits.size()))];
        const Hits from = side_by_side(at);
        std::array<DomePoint, kSide> dome;
        for (std::size_t i = 0; i < kSide; ++i) dome[i] = from_square({x[i], y[i]});
        const Vec3s w = direction_of(
            DomePointOf<Reals>{lanewise<Reals>([&](std::size_t i) { return dome[i].t; }),
                               lanewise<Reals>([&](std::size_t i) { return dome[i].azimuth; })},
            scene_.sky.dome().first_azimuth());
        const Reals cos_theta = dot(w, from.n);
        const unsigned reflected = bits(cos_theta > Reals(0.0));  // nothing is, from elsewhere
        const unsigned above = reflected & bits(dot(w, from.ng) > Reals(0.0));
        rays += static_cast<std::uint64_t>(std::popcount(above));
        const unsigned free = above & ~scene_.accel.occluded({from.leave(w), w}, above);
        const auto cosines = stored(cos_theta);
        for (std::size_t i = 0; i < kSide; ++i)
            if (reflected >> i & 1) hidden.add({x[i], y[i]}, cosines[i], !(free >> i & 1));
    }
    if (hidden.share() == 0 || hidden.share() > kMostHidden) return rays;
    const double defence = kDefence * hidden.mean();
    toward_[index(square_x, square_y)] =
        SkyDensity(DomeCells::equal_area(kCells / 2),
                   [&](const DomePoint& p) { return hidden(to_square(p)) + defence; });
    return rays;
}

const SkyDensity* Occluders::find(int pixel_x, int pixel_y) const {
    const SkyDensity& toward = toward_[index(pixel_x / kSquare, pixel_y / kSquare)];
    return toward.dark() ? nullptr : &toward;
}

}  // namespace malus
