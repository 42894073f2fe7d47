// sky_grid.cpp — rows of a table to nodes of a map.
// SPDX-License-Identifier: Apache-2.0
#include "io/sky_grid.h"

#include <algorithm>
#include <cmath>

#include "io/csv.h"
#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

constexpr double kSameAngle = 1e-6;  // degrees

// The distinct values of a column, ascending; closer ones than `same` are one.
template <class Column>
std::vector<double> distinct(const std::vector<SkyRow>& rows, double same, Column column) {
    std::vector<double> values;
    for (const SkyRow& row : rows) values.push_back(row.*column);
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end(),
                             [same](double a, double b) { return b - a < same; }),
                 values.end());
    return values;
}

std::size_t index_of(const std::vector<double>& values, double x, double same) {
    const auto found = std::lower_bound(values.begin(), values.end(), x - same);
    return static_cast<std::size_t>(found - values.begin());
}

// 0° and 360° are one direction, −180° and 180° too. The larger goes out of the list, and rows that
// have it stand behind the others from the returned place on, with the smaller.
std::size_t close_circle(std::vector<SkyRow>& rows, std::vector<double>& azimuths,
                         const std::string& file) {
    const double turn = azimuths.front() + 360;
    if (azimuths.back() > turn + kSameAngle)
        throw Error(file + ": azimuths from " + to_text(azimuths.front()) + " to " +
                    to_text(azimuths.back()) + " degrees are more than a turn; give one");
    if (azimuths.back() < turn - kSameAngle) return rows.size();
    azimuths.pop_back();
    const auto again = std::stable_partition(rows.begin(), rows.end(), [&](const SkyRow& row) {
        return row.azimuth_deg <= turn - kSameAngle;
    });
    for (auto row = again; row != rows.end(); ++row) row->azimuth_deg = azimuths.front();
    return static_cast<std::size_t>(again - rows.begin());
}

}  // namespace

std::string fault_of(const Stokes<double>& S) {
    if (!std::isfinite(S.s0 + S.s1 + S.s2 + S.s3))
        return "a Stokes component is not finite; mend the map";
    if (S.s0 > kBrightest)
        return "S0 = " + to_text(S.s0) + " is brighter than anything; mend the map";
    if (S.s0 < 0) return "S0 = " + to_text(S.s0) + " is negative; mend the map";
    const double P = std::hypot(S.s1, S.s2, S.s3);
    if (P > S.s0 * (1 + 1e-5))
        return "|(S1,S2,S3)| = " + to_text(P) + " exceeds S0 = " + to_text(S.s0) +
               " (no light is polarized more than wholly); mend the map";
    return {};
}

Sky sky_from_rows(std::vector<SkyRow> rows, const std::string& file) {
    if (rows.empty()) throw Error(file + ": holds no rows; a sky map needs a full grid");
    Sky sky;
    sky.wavelengths_nm = distinct(rows, kSameWavelength_nm, &SkyRow::wavelength_nm);
    const std::vector<double> zeniths = distinct(rows, kSameAngle, &SkyRow::zenith_deg);
    std::vector<double> azimuths = distinct(rows, kSameAngle, &SkyRow::azimuth_deg);
    const std::size_t first_again = close_circle(rows, azimuths, file);
    const std::size_t count = sky.wavelengths_nm.size() * zeniths.size() * azimuths.size();
    if (count > 4 * rows.size() + 1000)
        throw Error(file + ": " + std::to_string(rows.size()) + " rows cannot fill the grid of " +
                    std::to_string(count) + " nodes that their angles span; give a full grid");
    std::vector<int> line_of(count, 0);
    sky.nodes.resize(count);
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const SkyRow& row = rows[r];
        const std::size_t i =
            (index_of(sky.wavelengths_nm, row.wavelength_nm, kSameWavelength_nm) * zeniths.size() +
             index_of(zeniths, row.zenith_deg, kSameAngle)) *
                azimuths.size() +
            index_of(azimuths, row.azimuth_deg, kSameAngle);
        if (line_of[i] != 0 && r >= first_again) continue;
        if (line_of[i] != 0)
            throw Error(csv_place(file, row.line) + ": same node as line " +
                        std::to_string(line_of[i]) + "; keep one");
        line_of[i] = row.line;
        sky.nodes[i] = row.S;
    }
    for (std::size_t i = 0; i < count; ++i)
        if (line_of[i] == 0)
            throw Error(file + ": a gap in the grid: no row for " +
                        to_text(sky.wavelengths_nm[i / (zeniths.size() * azimuths.size())]) +
                        " nm, zenith " + to_text(zeniths[i / azimuths.size() % zeniths.size()]) +
                        ", azimuth " + to_text(azimuths[i % azimuths.size()]) + "; add it");
    for (double z : zeniths) sky.zeniths.push_back(to_radians(z));
    for (double a : azimuths) sky.azimuths.push_back(to_radians(a));
    return sky;
}

std::vector<std::string> gaps_in(const Sky& sky, const std::string& file) {
    std::vector<std::string> found;
    const auto degrees = [](double x) { return to_text(std::round(to_degrees(x) * 100) / 100); };
    if (sky.zeniths.front() > to_radians(15) || sky.zeniths.back() < to_radians(75))
        found.push_back(file + ": zenith angles cover " + degrees(sky.zeniths.front()) + " to " +
                        degrees(sky.zeniths.back()) +
                        " of 0 to 90 degrees; beyond, the sky is taken as at their edge");
    for (std::size_t i = 0; i < sky.azimuths.size() && sky.azimuths.size() > 1; ++i) {
        const std::size_t next = (i + 1) % sky.azimuths.size();
        const double gap = sky.azimuths[next] - sky.azimuths[i] + (next == 0 ? 2 * kPi : 0);
        if (gap > to_radians(100))
            found.push_back(file + ": no azimuth between " + degrees(sky.azimuths[i]) + " and " +
                            degrees(sky.azimuths[next]) + " degrees; interpolated across");
    }
    return found;
}

}  // namespace malus
