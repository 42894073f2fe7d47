// equal_area_sky.h — a sky on an equal-area grid (equal_area.h), and how it is made coarser and finer.
//
// Nodes   (cells + 1)², each with rows of wavelengths in fixed_frame; light between them is bilinear in
//         the square.
// Turned  azimuths count from where the map's begin, so that the grid turns with the map.
// Hats    node i stands for the hat h_i: 1 there, 0 at its neighbours. A grid holds either means
//         m_i = ∫ h_i L / ∫ h_i, or the values v_i of the bilinear light Σ v_i h_i. Σ_j (∫ h_i h_j) v_j =
//         m_i ∫ h_i leads from one to the other: the bilinear light nearest to L in the square mean.
// Units   as the sky's.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/scene/sky.h"
#include "scene/equal_area.h"

namespace malus {

/// Of a direction above the horizon; azimuths from `first`.
template <class R>
DomePointOf<R> dome_point(const Vector3<R>& w, double first_azimuth) {
    using std::min;
    // 1 − cos z, exact near the zenith, too.
    const R t = (w.x * w.x + w.z * w.z) / (real<R>(1) + w.y);
    const R azimuth = azimuth_of(w) - real<R>(first_azimuth);
    return {min(real<R>(1), t), select(azimuth < real<R>(0), azimuth + real<R>(2 * kPi), azimuth)};
}
template <class R>
Vector3<R> direction_of(const DomePointOf<R>& p, double first_azimuth) {
    using std::sqrt;
    const R one = real<R>(1), sin_z = sqrt(p.t * (one + one - p.t));
    const CosSin<R> a = cos_sin(p.azimuth + real<R>(first_azimuth));
    return {sin_z * a.sin, one - p.t, -sin_z * a.cos};
}

/// Where a point lies on a grid.
template <class R>
struct GridPlaceOf {
    R column, line;  ///< of the cell
    R u, v;          ///< in it, [0,1]
};
using GridPlace = GridPlaceOf<double>;
template <class R>
GridPlaceOf<R> place_on_grid(const SquarePointOf<R>& p, std::size_t cells) {
    using std::floor, std::min;
    const R n = real<R>(static_cast<double>(cells)), last = n - real<R>(1);
    const R x = p.x * n, y = p.y * n;
    const R column = min(floor(x), last), line = min(floor(y), last);
    return {column, line, x - column, y - line};
}

/// Of the four nodes around a place: two on its line, two on the next.
template <class R>
std::array<R, 4> bilinear_weights(const GridPlaceOf<R>& at) {
    const R one = real<R>(1);
    return {(one - at.v) * (one - at.u), (one - at.v) * at.u, at.v * (one - at.u), at.v * at.u};
}

class EqualAreaSky {
  public:
    /// The means of a dome.
    EqualAreaSky(const SkyDome& dome, std::size_t cells);

    /// The means on half as many cells a side, from means.
    EqualAreaSky coarser_means() const;
    /// The same light on twice as many cells a side, from values.
    EqualAreaSky finer() const;
    EqualAreaSky values_of_means() const;
    EqualAreaSky means_of_values() const;
    /// No node is darker than black or more than fully polarized (by more than rounding).
    bool physical() const;

    std::size_t cells() const { return cells_; }
    std::size_t wavelength_count() const { return wavelength_count_; }
    std::size_t nodes() const { return (cells_ + 1) * (cells_ + 1); }
    const float* row(std::size_t node, int c) const {
        return &data_[(node * 4 + static_cast<std::size_t>(c)) * wavelength_count_];
    }

    /// The first of the four nodes around a place, and all of them.
    template <class R>
    R first_node(const GridPlaceOf<R>& at) const {
        return at.line * real<R>(static_cast<double>(cells_ + 1)) + at.column;
    }
    std::array<std::uint32_t, 4> nodes_from(double first) const {
        const auto node = static_cast<std::uint32_t>(first),
                   below = static_cast<std::uint32_t>(node + cells_ + 1);
        return {node, node + 1, below, below + 1};
    }
    /// The nodes around a place and their weights.
    SkyLookup lookup(const GridPlace& at) const;

  private:
    EqualAreaSky(std::size_t cells, std::size_t wavelength_count);
    std::size_t floats_a_node() const { return 4 * wavelength_count_; }
    std::span<float> at(std::size_t node) {
        return {&data_[node * floats_a_node()], floats_a_node()};
    }
    std::span<const float> at(std::size_t node) const {
        return {&data_[node * floats_a_node()], floats_a_node()};
    }
    template <class OnLine>
    void for_each_line(const OnLine& on_line);

    std::size_t cells_, wavelength_count_;
    std::vector<float> data_;  // [node][component][wavelength]
};

}  // namespace malus
