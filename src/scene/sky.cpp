// sky.cpp — a sky map made ready for interpolation.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/sky.h"

#include <algorithm>

#include "malus/core/contract.h"
#include "malus/core/error.h"
#include "malus/core/frame.h"
#include "malus/optics/wavelengths.h"

namespace malus {
std::vector<std::size_t> wavelength_indices(const Sky& sky,
                                            std::span<const double> wavelengths_nm) {
    std::vector<std::size_t> which;
    for (double nm : wavelengths_nm) {
        const auto index = find_wavelength(sky.wavelengths_nm, nm);
        if (!index)
            throw Error("sky: no wavelength " + to_text(nm) + " nm; it has " +
                        to_text(sky.wavelengths_nm) + " nm");
        which.push_back(*index);
    }
    return which;
}

BeamFrame meridian_frame(const Vec3& w) {
    const double h = std::sqrt(w.x * w.x + w.z * w.z);
    const Vec3 x = h == 0 ? (w.y > 0 ? -kNorth : kNorth) : Vec3{-w.x * w.y / h, h, -w.z * w.y / h};
    ENSURE(std::abs(length(x) - 1) < 1e-6 && std::abs(dot(x, w)) < 1e-6);
    return {-w, x};
}

// cos a · x_meridian − sin a · y_meridian, written without angles: the frame of the zenith carried
// along the great circle to w.
BeamFrame fixed_frame(const Vec3& w) {
    if (w.y < 0) return meridian_frame(w);  // black there; this form ends at the nadir
    return fixed_frame_above(w);
}

SkyDome::SkyDome(const Sky& sky, std::span<const double> wavelengths_nm)
    : wavelength_count_(wavelengths_nm.size()) {
    const std::vector<std::size_t> which = wavelength_indices(sky, wavelengths_nm);
    // The zenith and the horizon become nodes, so that no direction lies outside the grid, and the
    // first azimuth stands once more behind the last.
    std::vector<double> zeniths = sky.zeniths, azimuths;
    if (zeniths.front() > 0) zeniths.insert(zeniths.begin(), 0.0);
    if (zeniths.back() < kPi / 2) zeniths.push_back(kPi / 2);
    const std::vector<Column> columns = columns_of(sky);
    for (const Column& column : columns) azimuths.push_back(column.azimuth);
    zenith_ = GuidedAxis(std::move(zeniths));
    azimuth_ = GuidedAxis(std::move(azimuths));
    fill_nodes(sky, columns, which);
}

// The map's columns, with others between where they are more than 1.5° apart.
std::vector<SkyDome::Column> SkyDome::columns_of(const Sky& sky) {
    constexpr double kWidest = to_radians(1.5);
    const std::size_t count = sky.azimuths.size();
    std::vector<Column> columns;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t next = (i + 1) % count;
        const double gap = sky.azimuths[next] - sky.azimuths[i] + (next == 0 ? 2 * kPi : 0);
        const double steps = std::max(1.0, std::ceil(gap / kWidest - 1e-9));
        for (double step = 0; step < steps; ++step) {
            const double t = step / steps;
            columns.push_back({sky.azimuths[i] + t * gap, i, next, t, t * gap, (t - 1) * gap});
        }
    }
    columns.push_back({sky.azimuths[0] + 2 * kPi, 0, 0, 0, 0, 0});
    return columns;
}

// In the meridian frame of the column. A direction carried along a circle of zenith angle z by Δa
// turns against the meridians by Δa cos z: wholly at the zenith, where they spin, not at all at the
// horizon. A map of one azimuth means a sky that is the same all around.
Stokes<double> SkyDome::interpolated(const Sky& sky, std::size_t w, std::size_t row,
                                     const Column& column) {
    const Stokes<double>& left = sky.at(w, row, column.left);
    if (column.t == 0 || sky.azimuths.size() == 1) return left;
    const double cos_z = std::cos(sky.zeniths[row]);
    const auto carried = [&](const Stokes<double>& S, double away) {
        return turned(S, Turn{std::cos(2 * away * cos_z), std::sin(2 * away * cos_z)});
    };
    return (1 - column.t) * carried(left, column.from_left) +
           column.t * carried(sky.at(w, row, column.right), column.from_right);
}

// What the two lowest rows of the map say of the horizon below them: the line through them, where it
// stays light and within a factor of 2 of the last row (rows may end beside a cloud), else the last.
Stokes<double> SkyDome::at_horizon(const Sky& sky, std::size_t w, const Column& column) {
    const std::size_t last = sky.zeniths.size() - 1;
    const Stokes<double> S = interpolated(sky, w, last, column);
    if (last == 0) return S;
    const double step = sky.zeniths[last] - sky.zeniths[last - 1];
    const double t = (kPi / 2 - sky.zeniths[last]) / step;
    const Stokes<double> above = interpolated(sky, w, last - 1, column);
    const Stokes<double> line = (1 + t) * S + -t * above;
    const bool near = t <= 1 && line.s0 >= 0.5 * S.s0 && line.s0 <= 2 * S.s0;
    return near && std::hypot(line.s1, line.s2, line.s3) <= line.s0 ? line : S;
}

void SkyDome::store(std::size_t row, std::size_t column, std::size_t w, const Stokes<double>& S) {
    float* at = &data_[(row * (azimuth_.cells() + 1) + column) * 4 * wavelength_count_ + w];
    at[0] = static_cast<float>(S.s0);
    at[wavelength_count_] = static_cast<float>(S.s1);
    at[2 * wavelength_count_] = static_cast<float>(S.s2);
    at[3 * wavelength_count_] = static_cast<float>(S.s3);
    circular_ |= S.s3 != 0;
}

void SkyDome::fill_nodes(const Sky& sky, const std::vector<Column>& columns,
                         std::span<const std::size_t> which) {
    const std::size_t rows = zenith_.cells() + 1;
    const bool pole_added = sky.zeniths.front() > 0;
    const bool horizon_added = sky.zeniths.back() < kPi / 2;
    data_.assign(rows * columns.size() * 4 * wavelength_count_ + kPadding, 0.0f);
    for (std::size_t w = 0; w < which.size(); ++w) {
        Stokes<double> pole;
        for (std::size_t row = 0; row < rows; ++row) {
            const std::size_t file_row =
                std::min(row - (pole_added && row > 0 ? 1 : 0), sky.zeniths.size() - 1);
            for (std::size_t c = 0; c < columns.size(); ++c) {
                // Axis turned by α = −a from the meridian.
                const double a = columns[c].azimuth;
                const Turn turn{std::cos(2 * a), -std::sin(2 * a)};
                const Stokes<double> S =
                    turned(horizon_added && row + 1 == rows
                               ? at_horizon(sky, which[w], columns[c])
                               : interpolated(sky, which[w], file_row, columns[c]),
                           turn);
                store(row, c, w, S);
                if (row > 0 || c + 1 == columns.size()) continue;
                // In the fixed frame all azimuths of the zenith are one direction: their mean.
                pole = pole + ((columns[c + 1].azimuth - a) / (2 * kPi)) * S;
            }
        }
        for (std::size_t c = 0; c < columns.size(); ++c) store(0, c, w, pole);
    }
}

double SkyDome::spacing() const {
    double least = azimuth_spacing();
    // Not the steps to pole and horizon, which may be half ones.
    for (std::size_t i = 1; i + 1 < zenith_.cells(); ++i) least = std::min(least, zenith_.width(i));
    return least;
}

double SkyDome::azimuth_spacing() const {
    double least = kPi / 2;
    for (std::size_t i = 0; i < azimuth_.cells(); ++i) least = std::min(least, azimuth_.width(i));
    return least;
}

// The azimuth brought into the range of the axis, which starts at the map's first column.
double SkyDome::wrapped(double azimuth) const {
    return azimuth < azimuth_.node(0) ? azimuth + 2 * kPi : azimuth;
}

SkyLookup SkyDome::locate(const Vec3& w) const {
    if (w.y < 0) return {};
    const double z = zenith_of(w), a = wrapped(azimuth_of(w));
    const std::size_t r = zenith_.cell(z), c = azimuth_.cell(a);
    return lookup(r, c, zenith_.fraction(r, z), azimuth_.fraction(c, a));
}

// v and u: place within cell (r, c), from its upper left node, [0,1].
SkyLookup SkyDome::lookup(std::size_t r, std::size_t c, double v, double u) const {
    const auto node = static_cast<std::uint32_t>(r * (azimuth_.cells() + 1) + c);
    const auto below = static_cast<std::uint32_t>(node + azimuth_.cells() + 1);
    return {{node, node + 1, below, below + 1},
            {static_cast<float>((1 - v) * (1 - u)), static_cast<float>((1 - v) * u),
             static_cast<float>(v * (1 - u)), static_cast<float>(v * u)}};
}

Stokes<double> SkyDome::radiance(const Vec3& w, std::size_t wavelength) const {
    return light_at(*this, locate(w), wavelength);
}

Stokes<double> SkyDome::radiance_in(const BeamFrame& frame, std::size_t wavelength) const {
    const Vec3 w = -frame.k;
    return turned(radiance(w, wavelength), turn_between(fixed_frame(w), frame));
}

}  // namespace malus
