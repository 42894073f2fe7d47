// sky_emitter.cpp — which grid will do, and directions drawn from it.
// SPDX-License-Identifier: Apache-2.0
#include "scene/sky_emitter.h"

#include <algorithm>

namespace malus {
namespace {

// Cells along a side.
constexpr std::size_t kFinest = 1024, kCoarsest = 8, kCoarsestHats = 64;

double cell_width(std::size_t cells) {
    return std::sqrt(2 * kPi) / static_cast<double>(cells);
}

// Cells along a side that are at most `width` rad wide: a power of two.
std::size_t cells_for(double width) {
    std::size_t cells = kCoarsestHats;
    while (cells < kFinest && cell_width(cells) > width) cells *= 2;
    return cells;
}

// The largest difference of two grids of the same cells, of S0 (in places far darker than the sky's
// mean, of a thousandth of that).
double difference(const EqualAreaSky& a, const EqualAreaSky& b) {
    double largest = 0;
    for (std::size_t w = 0; w < a.wavelength_count(); ++w) {
        double mean = 0;
        for (std::size_t node = 0; node < b.nodes(); ++node)
            mean += static_cast<double>(b.row(node, 0)[w]) / static_cast<double>(b.nodes());
        if (mean == 0) continue;
        for (std::size_t node = 0; node < b.nodes(); ++node) {
            const double s0 = std::max(1e-3 * mean, static_cast<double>(b.row(node, 0)[w]));
            for (int c = 0; c < 4; ++c)
                largest = std::max(
                    largest,
                    std::abs(static_cast<double>(a.row(node, c)[w] - b.row(node, c)[w])) / s0);
        }
    }
    return largest;
}

// A grid with half as many cells, again and again, that stands for `means`, and its error. Means
// whose bilinear light would be unphysical, beside what is sharp, are taken for values themselves.
struct Candidate {
    EqualAreaSky values;
    double error;
};
Candidate candidate(const EqualAreaSky& means, std::size_t cells) {
    EqualAreaSky coarse = means;
    while (coarse.cells() > cells) coarse = coarse.coarser_means();
    EqualAreaSky values = coarse.values_of_means();
    if (!values.physical()) values = std::move(coarse);
    EqualAreaSky seen = values;
    while (seen.cells() < means.cells()) seen = seen.finer();
    return {std::move(values), difference(seen.means_of_values(), means)};
}

// Calls visit(place, lookup) at four places of each cell, each of the same solid angle.
template <class Visit>
void for_each_quarter(const EqualAreaSky& grid, const Visit& visit) {
    const std::size_t places = 2 * grid.cells();
    const auto coordinate = [&](std::size_t i) {
        return (static_cast<double>(i) + 0.5) / static_cast<double>(places);
    };
    for (std::size_t y = 0; y < places; ++y)
        for (std::size_t x = 0; x < places; ++x) {
            const SquarePoint p{coordinate(x), coordinate(y)};
            visit(from_square(p), grid.lookup(place_on_grid(p, grid.cells())));
        }
}

// Of level ground and, without the cosine, the mean over the dome: [wavelength].
struct Irradiance {
    std::vector<Stokes<double>> level, mean;

    explicit Irradiance(std::size_t wavelengths) : level(wavelengths), mean(wavelengths) {}
    template <class Rows>
    void add(const Rows& rows, const SkyLookup& at, double cos_z, double solid_angle) {
        for (std::size_t w = 0; w < level.size(); ++w) {
            const Stokes<double> S = solid_angle * light_at(rows, at, w);
            level[w] = level[w] + cos_z * S;
            mean[w] = mean[w] + (1 / (2 * kPi)) * S;
        }
    }
};

Irradiance irradiance(const SkyDome& dome) {
    Irradiance sum(dome.wavelength_count());
    dome.for_each_part(to_radians(1), [&](const Vec3& w, double part, const SkyLookup& at) {
        sum.add(dome, at, w.y, part);
    });
    return sum;
}

Irradiance irradiance(const EqualAreaSky& grid) {
    Irradiance sum(grid.wavelength_count());
    const double part = 2 * kPi / (4 * sqr(static_cast<double>(grid.cells())));
    for_each_quarter(
        grid, [&](const DomePoint& p, const SkyLookup& at) { sum.add(grid, at, 1 - p.t, part); });
    return sum;
}

// The largest difference over wavelengths, of S0.
double difference(const std::vector<Stokes<double>>& a, const std::vector<Stokes<double>>& b) {
    double largest = 0;
    for (std::size_t w = 0; w < a.size(); ++w) {
        const Stokes<double> d = a[w] + -1 * b[w];
        if (b[w].s0 > 0)
            largest = std::max(
                {largest, std::abs(d.s0) / b[w].s0, std::hypot(d.s1, d.s2, d.s3) / b[w].s0});
    }
    return largest;
}

SkyResampling compare(const EqualAreaSky& grid, const SkyDome& dome) {
    SkyResampling change{grid.cells()};
    double count = 0;
    for_each_quarter(grid, [&](const DomePoint& p, const SkyLookup& here) {
        const SkyLookup there = dome.locate(direction_of(p, dome.first_azimuth()));
        for (std::size_t w = 0; w < grid.wavelength_count(); ++w) {
            const Stokes<double> a = light_at(grid, here, w), b = light_at(dome, there, w);
            if (!(b.s0 > 0)) continue;
            const double s0 = std::abs(a.s0 / b.s0 - 1), degree = std::abs(dolp(a) - dolp(b));
            change.rms_s0 += sqr(s0), change.rms_dolp += sqr(degree), ++count;
            change.largest_s0 = std::max(change.largest_s0, s0);
            change.largest_dolp = std::max(change.largest_dolp, degree);
        }
    });
    change.rms_s0 = std::sqrt(change.rms_s0 / std::max(1.0, count));
    change.rms_dolp = std::sqrt(change.rms_dolp / std::max(1.0, count));
    return change;
}

// The coarsest grid that will do, if any: from the paint's own down, until one is too coarse; or, where
// that will not do, from there up.
std::optional<EqualAreaSky> choose_grid(const SkyDome& dome, const Irradiance& light,
                                        double sharpest_slope) {
    const double finest = std::max(dome.spacing(), cell_width(kFinest));
    if (sharpest_slope / 3 < finest) return {};
    const auto will_do = [&](const Candidate& found) {
        return found.error < SkyEmitter::kTolerance &&
               difference(irradiance(found.values).level, light.level) < SkyEmitter::kTolerance;
    };
    for (std::size_t start = cells_for(sharpest_slope / 3); start <= cells_for(finest);
         start *= 2) {
        const EqualAreaSky means(dome, start);
        std::optional<EqualAreaSky> chosen;
        for (std::size_t cells = start; cells >= kCoarsest; cells /= 2) {
            Candidate found = candidate(means, cells);
            if (!will_do(found)) break;
            chosen = std::move(found.values);
        }
        if (chosen) return chosen;
    }
    return {};
}

// The map's own cells, for a distribution as sharp as the map.
DomeCells cells_of(const SkyDome& dome) {
    constexpr std::size_t kMostParts = 8192;
    const auto parts = static_cast<std::size_t>(std::ceil(2 * kPi / dome.azimuth_spacing() - 1e-9));
    DomeCells cells;
    for (std::size_t i = 0; i <= dome.zenith_axis().cells(); ++i) {
        cells.t.push_back(2 * sqr(std::sin(dome.zenith_axis().node(i) / 2)));
        if (i > 0) cells.parts.push_back(std::min(parts, kMostParts));
    }
    return cells;
}

}  // namespace

SkyEmitter::SkyEmitter(const Sky& sky, std::span<const double> wavelengths_nm,
                       double sharpest_slope)
    : dome_(sky, wavelengths_nm) {
    const Irradiance light = irradiance(dome_);
    grid_ = choose_grid(dome_, light, sharpest_slope);
    if (grid_) resampling_ = compare(*grid_, dome_);
    std::vector<double> mean_s0;
    for (const Stokes<double>& S : light.mean) mean_s0.push_back(S.s0);
    density_ = SkyDensity(grid_ ? DomeCells::equal_area(grid_->cells() / 2) : cells_of(dome_),
                          [&](const DomePoint& p) { return brightness(p, mean_s0); });
}

// Sum over the wavelengths, each of mean 1.
double SkyEmitter::brightness(const DomePoint& p, std::span<const double> mean_s0) const {
    const SkyLookup at = lookup(p);
    double sum = 0;
    for (std::size_t w = 0; w < mean_s0.size(); ++w)
        for (std::size_t i = 0; i < 4; ++i)
            if (mean_s0[w] > 0)
                sum += static_cast<double>(at.weight[i] * row(at.node[i], 0)[w]) / mean_s0[w];
    return sum;
}

SkyLookup SkyEmitter::lookup(const DomePoint& p) const {
    return grid_ ? grid_->lookup(place_on_grid(to_square(p), grid_->cells()))
                 : dome_.locate(direction_of(p, dome_.first_azimuth()));
}

LightLookup SkyEmitter::locate(const Vec3& w) const {
    if (w.y < 0) return {};
    const DomePoint p = dome_point(w, dome_.first_azimuth());
    return {lookup(p), density_.pdf(p)};
}

LightSample SkyEmitter::sample(double u1, double u2) const {
    if (density_.dark()) return {};
    const SkyDensity::Draw draw = density_.draw(u1, u2);
    return {direction_of(draw.point, dome_.first_azimuth()), {lookup(draw.point), draw.pdf}};
}

}  // namespace malus
