// equal_area_sky.cpp — light dealt out to the nodes of a grid.
// SPDX-License-Identifier: Apache-2.0
#include "scene/equal_area_sky.h"

#include "malus/core/frame.h"

namespace malus {
namespace {

// Share of the square that belongs to node i of a line, in cells.
double extent(std::size_t i, std::size_t cells) {
    return i == 0 || i == cells ? 0.5 : 1;
}

// ∫ h_i h_j / ∫ h_i along a line: with itself, and with each neighbour.
constexpr double kOwn = 2.0 / 3;
double shared(std::size_t i, std::size_t cells) {
    return i == 0 || i == cells ? 1.0 / 3 : 1.0 / 6;
}

void scale(std::span<float> S, double factor) {
    for (float& x : S) x *= static_cast<float>(factor);
}
void add(std::span<float> S, double weight, std::span<const float> other) {
    for (std::size_t i = 0; i < S.size(); ++i) S[i] += static_cast<float>(weight) * other[i];
}

}  // namespace

EqualAreaSky::EqualAreaSky(std::size_t cells, std::size_t wavelength_count)
    : cells_(cells),
      wavelength_count_(wavelength_count),
      data_(nodes() * floats_a_node() + SkyDome::kPadding, 0.0f) {}

SkyLookup EqualAreaSky::lookup(const GridPlace& at) const {
    SkyLookup found{nodes_from(first_node(at)), {}};
    const std::array<double, 4> weight = bilinear_weights(at);
    for (std::size_t k = 0; k < 4; ++k) found.weight[k] = static_cast<float>(weight[k]);
    return found;
}

EqualAreaSky::EqualAreaSky(const SkyDome& dome, std::size_t cells)
    : EqualAreaSky(cells, dome.wavelength_count()) {
    const double cell = std::sqrt(2 * kPi) / static_cast<double>(cells);
    std::vector<double> solid_angle(nodes(), 0.0), light(floats_a_node());
    std::vector<double> sum(nodes() * floats_a_node(), 0.0), total(wavelength_count_, 0.0);
    dome.for_each_part(cell / 3, [&](const Vec3& w, double part, const SkyLookup& from) {
        std::fill(light.begin(), light.end(), 0.0);
        for (std::size_t k = 0; k < 4; ++k) {
            const float* S = dome.row(from.node[k], 0);
            for (std::size_t i = 0; i < light.size(); ++i)
                light[i] += part * static_cast<double>(from.weight[k] * S[i]);
        }
        for (std::size_t i = 0; i < wavelength_count_; ++i) total[i] += light[i];
        const SkyLookup to =
            lookup(place_on_grid(to_square(dome_point(w, dome.first_azimuth())), cells_));
        for (std::size_t k = 0; k < 4; ++k) {
            const auto weight = static_cast<double>(to.weight[k]);
            solid_angle[to.node[k]] += weight * part;
            double* S = &sum[to.node[k] * light.size()];
            for (std::size_t i = 0; i < light.size(); ++i) S[i] += weight * light[i];
        }
    });
    // Means under the hats, which parts of the dome fill a little unevenly: what that does to the
    // total is put right.
    std::vector<double> found(wavelength_count_, 0.0);
    for (std::size_t node = 0; node < nodes(); ++node) {
        const double area =
            sqr(cell) * extent(node % (cells + 1), cells) * extent(node / (cells + 1), cells);
        for (std::size_t i = 0; i < light.size(); ++i)
            sum[node * light.size() + i] /= solid_angle[node];
        for (std::size_t i = 0; i < wavelength_count_; ++i)
            found[i] += area * sum[node * light.size() + i];
    }
    for (std::size_t i = 0; i < sum.size(); ++i) {
        const std::size_t w = i % wavelength_count_;
        data_[i] = static_cast<float>(found[w] > 0 ? sum[i] * total[w] / found[w] : 0);
    }
}

EqualAreaSky EqualAreaSky::coarser_means() const {
    EqualAreaSky result(cells_ / 2, wavelength_count_);
    const std::size_t n = result.cells_;
    for (std::size_t y = 0; y <= n; ++y)
        for (std::size_t x = 0; x <= n; ++x)
            for (std::size_t v = y == 0 ? 1 : 0; v <= (y == n ? 1u : 2u); ++v)
                for (std::size_t u = x == 0 ? 1 : 0; u <= (x == n ? 1u : 2u); ++u) {
                    const std::size_t fine_x = 2 * x + u - 1, fine_y = 2 * y + v - 1;
                    const double weight = (u == 1 ? 1 : 0.5) * (v == 1 ? 1 : 0.5) *
                                          extent(fine_x, cells_) * extent(fine_y, cells_) /
                                          (4 * extent(x, n) * extent(y, n));
                    add(result.at(y * (n + 1) + x), weight, at(fine_y * (cells_ + 1) + fine_x));
                }
    return result;
}

EqualAreaSky EqualAreaSky::finer() const {
    EqualAreaSky result(2 * cells_, wavelength_count_);
    const std::size_t n = result.cells_;
    for (std::size_t y = 0; y <= n; ++y)
        for (std::size_t x = 0; x <= n; ++x)
            for (std::size_t from_y : {y / 2, (y + 1) / 2})
                for (std::size_t from_x : {x / 2, (x + 1) / 2})
                    add(result.at(y * (n + 1) + x), 0.25, at(from_y * (cells_ + 1) + from_x));
    return result;
}

// Calls on_line(first node, step to the next) for each line of nodes, of both directions.
template <class OnLine>
void EqualAreaSky::for_each_line(const OnLine& on_line) {
    for (std::size_t i = 0; i <= cells_; ++i) on_line(i * (cells_ + 1), std::size_t{1});
    for (std::size_t i = 0; i <= cells_; ++i) on_line(i, cells_ + 1);
}

EqualAreaSky EqualAreaSky::means_of_values() const {
    EqualAreaSky result = *this;
    std::vector<float> before(floats_a_node()), here(floats_a_node());
    result.for_each_line([&](std::size_t first, std::size_t step) {
        for (std::size_t i = 0; i <= cells_; ++i) {
            const std::span<float> m = result.at(first + i * step);
            std::copy(m.begin(), m.end(), here.begin());
            scale(m, kOwn);
            if (i > 0) add(m, shared(i, cells_), before);
            if (i < cells_) add(m, shared(i, cells_), result.at(first + (i + 1) * step));
            std::swap(before, here);
        }
    });
    return result;
}

// The three-term equations of each line, solved by elimination.
EqualAreaSky EqualAreaSky::values_of_means() const {
    EqualAreaSky result = *this;
    std::vector<double> next_share(cells_ + 1);
    result.for_each_line([&](std::size_t first, std::size_t step) {
        for (std::size_t i = 0; i <= cells_; ++i) {
            const std::span<float> v = result.at(first + i * step);
            const double before = i > 0 ? shared(i, cells_) : 0;
            const double pivot = kOwn - before * (i > 0 ? next_share[i - 1] : 0);
            next_share[i] = shared(i, cells_) / pivot;
            if (i > 0) add(v, -before, result.at(first + (i - 1) * step));
            scale(v, 1 / pivot);
        }
        for (std::size_t i = cells_; i-- > 0;)
            add(result.at(first + i * step), -next_share[i], result.at(first + (i + 1) * step));
    });
    return result;
}

bool EqualAreaSky::physical() const {
    for (std::size_t node = 0; node < nodes(); ++node)
        for (std::size_t w = 0; w < wavelength_count_; ++w) {
            const auto S = [&](int c) { return row(node, c)[w]; };
            if (!(S(0) >= 0) || std::hypot(S(1), S(2), S(3)) > S(0) * (1 + 1e-6f)) return false;
        }
    return true;
}

}  // namespace malus
