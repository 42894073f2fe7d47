// sky_conventions.cpp — nodes renamed and sorted; nodes interpolated.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/sky_conventions.h"

#include <algorithm>
#include <numeric>

#include "malus/core/frame.h"

namespace malus {
namespace {

constexpr double kSameAngle = to_radians(1e-6);

// In [0, 2π); what is 2π but for rounding is 0.
double folded(double azimuth) {
    const double a = azimuth - 2 * kPi * std::floor(azimuth / (2 * kPi));
    return a > 2 * kPi - kSameAngle ? 0 : a;
}

// Exactly at the zenith and the horizon what is there but for rounding.
double snapped(double zenith) {
    if (std::abs(zenith - kPi / 2) < kSameAngle) return kPi / 2;
    return std::abs(zenith) < kSameAngle ? 0 : zenith;
}

// Places of the values in ascending order.
std::vector<std::size_t> order_of(const std::vector<double>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
    return order;
}

double spread(double from, double to, int steps, int i) {
    return from + (i + 0.5) * (to - from) / steps;
}

bool at_centres(const std::vector<double>& values, double to) {
    const int count = static_cast<int>(values.size());
    for (int i = 0; i < count; ++i)
        if (std::abs(values[static_cast<std::size_t>(i)] - spread(0, to, count, i)) > kSameAngle)
            return false;
    return true;
}

// The step of evenly spaced values, else 0.
double even_step(const std::vector<double>& values) {
    if (values.size() < 2) return 0;
    const double step = (values.back() - values.front()) / static_cast<double>(values.size() - 1);
    for (std::size_t i = 0; i + 1 < values.size(); ++i)
        if (std::abs(values[i + 1] - values[i] - step) > 1e-3 * step) return 0;
    return step;
}

}  // namespace

Sky in_our_conventions(const Sky& map, const SkyConventions& conventions) {
    const bool propagation = conventions.angles_of == AnglesOf::kPropagation;
    const double sense = conventions.azimuth_sense == AzimuthSense::kClockwise ? 1 : -1;
    std::vector<double> zeniths, azimuths;
    for (double z : map.zeniths) zeniths.push_back(snapped(propagation ? kPi - z : z));
    for (double a : map.azimuths)
        azimuths.push_back(folded(conventions.azimuth_zero + sense * a + (propagation ? kPi : 0)));
    const std::vector<std::size_t> columns = order_of(azimuths);
    std::vector<std::size_t> rows = order_of(zeniths);
    std::erase_if(rows, [&](std::size_t row) { return zeniths[row] > kPi / 2; });

    Sky ours = map;
    ours.zeniths.clear(), ours.azimuths.clear(), ours.nodes.clear();
    for (std::size_t row : rows) ours.zeniths.push_back(zeniths[row]);
    for (std::size_t column : columns) ours.azimuths.push_back(azimuths[column]);
    for (std::size_t w = 0; w < map.wavelengths_nm.size(); ++w)
        for (std::size_t row : rows)
            for (std::size_t column : columns) {
                const Stokes<double>& S = map.at(w, row, column);
                ours.nodes.push_back(
                    {S.s0, conventions.s1 * S.s1, conventions.s2 * S.s2, conventions.s3 * S.s3});
            }
    if (ours.sun) ours.sun->azimuth = folded(conventions.azimuth_zero + sense * ours.sun->azimuth);
    return ours;
}

Sky with_mirror_image(const Sky& half) {
    const std::size_t columns = half.azimuths.size();
    std::vector<std::size_t> mirrored;  // columns of the other side, by their own azimuth ascending
    for (std::size_t c = columns; c-- > 0;)
        if (half.azimuths[c] > kSameAngle && half.azimuths[c] < kPi - kSameAngle)
            mirrored.push_back(c);
    Sky whole = half;
    whole.nodes.clear();
    for (std::size_t c : mirrored) whole.azimuths.push_back(2 * kPi - half.azimuths[c]);
    for (std::size_t w = 0; w < half.wavelengths_nm.size(); ++w)
        for (std::size_t z = 0; z < half.zeniths.size(); ++z) {
            for (std::size_t c = 0; c < columns; ++c) whole.nodes.push_back(half.at(w, z, c));
            for (std::size_t c : mirrored) {
                const Stokes<double>& S = half.at(w, z, c);
                whole.nodes.push_back({S.s0, S.s1, -S.s2, -S.s3});
            }
        }
    return whole;
}

MapSize grid_like(const Sky& map) {
    constexpr MapSize kOneDegree{90, 360};
    const double zenith_step = even_step(map.zeniths), azimuth_step = even_step(map.azimuths);
    if (zenith_step == 0 || azimuth_step == 0) return kOneDegree;
    const double around = azimuth_step * static_cast<double>(map.azimuths.size());
    if (std::abs(around - 2 * kPi) > 1e-3 * azimuth_step) return kOneDegree;
    const double rows = std::ceil(kPi / 2 / zenith_step - 1e-3);
    // A few rows close together say nothing of the whole dome.
    if (rows > 4 * static_cast<double>(map.zeniths.size())) return kOneDegree;
    return {static_cast<int>(rows), static_cast<int>(map.azimuths.size())};
}

Sky at_pixel_centres(const Sky& map, const MapSize& grid) {
    if (std::ssize(map.zeniths) == grid.zeniths && std::ssize(map.azimuths) == grid.azimuths &&
        at_centres(map.zeniths, kPi / 2) && at_centres(map.azimuths, 2 * kPi))
        return map;
    Sky picture = map;
    picture.zeniths.clear(), picture.azimuths.clear(), picture.nodes.clear();
    for (int z = 0; z < grid.zeniths; ++z)
        picture.zeniths.push_back(spread(0, kPi / 2, grid.zeniths, z));
    for (int a = 0; a < grid.azimuths; ++a)
        picture.azimuths.push_back(spread(0, 2 * kPi, grid.azimuths, a));
    const SkyDome dome(map, map.wavelengths_nm);
    for (std::size_t w = 0; w < map.wavelengths_nm.size(); ++w)
        for (double z : picture.zeniths)
            for (double a : picture.azimuths)
                picture.nodes.push_back(dome.radiance_in(meridian_frame(direction(z, a)), w));
    return picture;
}

}  // namespace malus
