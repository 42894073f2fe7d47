// sky.cpp — a sky map made ready for interpolation and importance sampling.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/sky.h"

#include <algorithm>

#include "malus/core/contract.h"
#include "malus/core/error.h"
#include "malus/core/frame.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

// Index of the last entry of the ascending cdf (first 0, last 1) that is ≤ u, of a cell that is
// not empty.
std::size_t find_cell(const double* cdf, std::size_t cells, double u) {
    const double* found = std::upper_bound(cdf, cdf + cells, u);
    std::size_t i = static_cast<std::size_t>(found - cdf);
    i = i > 0 ? i - 1 : 0;
    while (i + 1 < cells && cdf[i + 1] == cdf[i]) ++i;
    while (i > 0 && cdf[i + 1] == cdf[i]) --i;
    return i;
}

// Turns weights[0..cells) into a cdf in place, weights[cells] becoming 1; returns their sum.
double make_cdf(double* weights, std::size_t cells) {
    double sum = 0;
    for (std::size_t i = 0; i < cells; ++i) {
        const double w = weights[i];
        weights[i] = sum;
        sum += w;
    }
    weights[cells] = sum;
    if (sum > 0)
        for (std::size_t i = 0; i <= cells; ++i) weights[i] /= sum;
    if (sum > 0) weights[cells] = 1;
    return sum;
}

}  // namespace

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
    const double q = w.z / (1 + w.y);
    return {-w, {-w.x * q, -w.z, 1 - w.z * q}};
}

SkyDome::Axis::Axis(std::vector<double> nodes) : nodes_(std::move(nodes)) {
    const std::size_t guides = 2 * nodes_.size();
    scale_ = static_cast<double>(guides) / (nodes_.back() - nodes_.front());
    guide_.resize(guides + 1);
    for (std::size_t g = 0; g <= guides; ++g) {
        const double x = nodes_.front() + static_cast<double>(g) / scale_;
        const auto above = std::upper_bound(nodes_.begin(), nodes_.end() - 1, x);
        guide_[g] = static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(
            0, std::min<std::ptrdiff_t>(above - nodes_.begin() - 1, std::ssize(nodes_) - 2)));
    }
}

std::size_t SkyDome::Axis::cell(double x) const {
    const double g = (x - nodes_.front()) * scale_;
    const double last = static_cast<double>(guide_.size() - 1);
    std::size_t i = guide_[static_cast<std::size_t>(std::clamp(g, 0.0, last))];
    while (i > 0 && nodes_[i] > x) --i;
    while (i + 2 < nodes_.size() && nodes_[i + 1] <= x) ++i;
    return i;
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
    zenith_ = Axis(std::move(zeniths));
    azimuth_ = Axis(std::move(azimuths));
    fill_nodes(sky, columns, which);
    build_distribution();
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
        return turned(S, {std::cos(2 * away * cos_z), std::sin(2 * away * cos_z)});
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

void SkyDome::build_distribution() {
    const std::size_t rows = zenith_.cells(), columns = azimuth_.cells();
    std::vector<double> mean(wavelength_count_, 0.0);
    for (std::size_t node = 0; node < (rows + 1) * (columns + 1); ++node)
        for (std::size_t w = 0; w < wavelength_count_; ++w)
            mean[w] += static_cast<double>(row(static_cast<std::uint32_t>(node), 0)[w]);
    const auto brightness = [&](std::size_t node) {
        double sum = 0;
        for (std::size_t w = 0; w < wavelength_count_; ++w)
            if (mean[w] > 0)
                sum += static_cast<double>(row(static_cast<std::uint32_t>(node), 0)[w]) / mean[w];
        return sum;
    };
    cos_zenith_.clear();
    for (std::size_t r = 0; r <= rows; ++r) cos_zenith_.push_back(std::cos(zenith_.node(r)));
    row_cdf_.assign(rows + 1, 0.0);
    column_cdf_.assign(rows * (columns + 1), 0.0);
    for (std::size_t r = 0; r < rows; ++r) {
        double* cells = &column_cdf_[r * (columns + 1)];
        const double band = cos_zenith_[r] - cos_zenith_[r + 1];
        for (std::size_t c = 0; c < columns; ++c) {
            const std::size_t node = r * (columns + 1) + c;
            const double solid_angle = band * (azimuth_.node(c + 1) - azimuth_.node(c));
            cells[c] =
                solid_angle * (brightness(node) + brightness(node + 1) +
                               brightness(node + columns + 1) + brightness(node + columns + 2));
        }
        row_cdf_[r] = make_cdf(cells, columns);
    }
    make_cdf(row_cdf_.data(), rows);
    density_.assign(rows * columns, 0.0);
    for (std::size_t r = 0; r < rows; ++r)
        for (std::size_t c = 0; c < columns; ++c) {
            const double* cdf = &column_cdf_[r * (columns + 1)];
            const double solid_angle =
                (cos_zenith_[r] - cos_zenith_[r + 1]) * (azimuth_.node(c + 1) - azimuth_.node(c));
            density_[r * columns + c] =
                (row_cdf_[r + 1] - row_cdf_[r]) * (cdf[c + 1] - cdf[c]) / solid_angle;
        }
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
             static_cast<float>(v * (1 - u)), static_cast<float>(v * u)},
            density_[r * azimuth_.cells() + c]};
}

Stokes<double> SkyDome::radiance(const Vec3& w, std::size_t wavelength) const {
    const SkyLookup at = locate(w);
    std::array<double, 4> S{};
    for (std::size_t i = 0; i < 4; ++i)
        for (int c = 0; c < 4; ++c)
            S[static_cast<std::size_t>(c)] += static_cast<double>(at.weight[i]) *
                                              static_cast<double>(row(at.node[i], c)[wavelength]);
    return {S[0], S[1], S[2], S[3]};
}

SkySample SkyDome::sample(double u1, double u2) const {
    const std::size_t rows = zenith_.cells(), columns = azimuth_.cells();
    if (row_cdf_[rows] == 0) return {};
    const std::size_t r = find_cell(row_cdf_.data(), rows, u1);
    const double* cdf = &column_cdf_[r * (columns + 1)];
    const std::size_t c = find_cell(cdf, columns, u2);
    const double v = std::clamp((u1 - row_cdf_[r]) / (row_cdf_[r + 1] - row_cdf_[r]), 0.0, 1.0);
    const double u = std::clamp((u2 - cdf[c]) / (cdf[c + 1] - cdf[c]), 0.0, 1.0);
    // Uniform in solid angle within the cell.
    const double top = cos_zenith_[r], bottom = cos_zenith_[r + 1];
    const double cos_z = std::max(0.0, top + v * (bottom - top));
    const double sin_z = std::sqrt((1 - cos_z) * (1 + cos_z));
    const double a = azimuth_.node(c) + u * (azimuth_.node(c + 1) - azimuth_.node(c));
    const double z = std::atan2(sin_z, cos_z);
    return {{sin_z * std::sin(a), cos_z, -sin_z * std::cos(a)},
            lookup(r, c, zenith_.fraction(r, z), u)};
}

}  // namespace malus
