// reference.cpp — Priest-Germer reflection of a polarized sky by deterministic cubature.
//
// Every integral here is over a convex region of the unit sphere, the directions w with w·m > 0
// for a few vectors m: the surface's hemisphere, the sky, the cone of a rectangle seen from a
// point. A region is swept from an apex a inside it, placed at the lobe's peak where that is in it,
//
//   w = a cos t + e(φ) sin t,  0 < t < T(φ),  dω = sin t dt dφ,  T(φ) = min over m of
//   atan2(a·m, −e(φ)·m),
//
// with φ cut at the region's corners, so that each piece is smooth and needs no masking. Around
// the specular peak these polar coordinates also turn the cone of SO at θ = 0 into a smooth
// function. Pieces are first cut small beside the lobe, then integrated by globally adaptive
// bisection of 15×15 Gauss-Kronrod cells.
//
// Error   |KK − GK| + |KK − KG| summed over the cells, K the 15- and G the 7-point rule: that is
//         the error of the poorer rule, so the value is usually several digits better.
// Source  reference.h.
// SPDX-License-Identifier: Apache-2.0
#include "support/reference.h"

#include <algorithm>
#include <cstddef>
#include <queue>
#include <utility>
#include <vector>

namespace malus::reference {
namespace {

constexpr Vec3 kUp{0, 1, 0};

Stokes operator+(const Stokes& a, const Stokes& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]};
}
Stokes operator-(const Stokes& a, const Stokes& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]};
}
Stokes operator*(double f, const Stokes& s) {
    return {f * s[0], f * s[1], f * s[2], f * s[3]};
}

Stokes abs(const Stokes& s) {
    return {std::abs(s[0]), std::abs(s[1]), std::abs(s[2]), std::abs(s[3])};
}
double largest(const Stokes& s) {
    return *std::max_element(s.begin(), s.end());
}

Vec3 any_perpendicular(Vec3 w) {
    return normalize(cross(w, std::abs(w.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 0, 1}));
}

}  // namespace

// ---- Stokes vectors and matrices ----------------------------------------------------------------

Stokes multiply(const Mueller& m, const Stokes& s) {
    Stokes r{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j) r[i] += m[i][j] * s[j];
    return r;
}

Mueller product(const Mueller& a, const Mueller& b) {
    Mueller r{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t j = 0; j < 4; ++j) r[i][j] += a[i][k] * b[k][j];
    return r;
}

Mueller rotation(Vec3 k, Vec3 x_from, Vec3 x_to) {
    const double c = dot(x_to, x_from);
    const double s = dot(x_to, cross(k, x_from));
    const double cos_2a = (c * c - s * s) / (c * c + s * s);
    const double sin_2a = 2 * c * s / (c * c + s * s);
    return {{{1, 0, 0, 0}, {0, cos_2a, sin_2a, 0}, {0, -sin_2a, cos_2a, 0}, {0, 0, 0, 1}}};
}

Vec3 meridian_axis(Vec3 w) {
    const Vec3 east = cross(w, kUp);
    const double sin_zenith = length(east);
    if (sin_zenith == 0) return {0, 0, std::copysign(1.0, w.y)};
    return cross(east, w) / sin_zenith;
}

// ---- The reflection model -----------------------------------------------------------------------

FresnelAmplitudes fresnel(std::complex<double> index, double cos_beta) {
    // N² − sin²β without cancelling at grazing, and with the imaginary part +0 for k = 0, so that a
    // totally reflecting facet gets the decaying wave; 1 − sin²β/N² has −0 and the other branch.
    const std::complex<double> radicand = (index - 1.0) * (index + 1.0) + cos_beta * cos_beta;
    const std::complex<double> cos_t = std::sqrt(radicand) / index;
    return {(cos_beta - index * cos_t) / (cos_beta + index * cos_t),
            (index * cos_beta - cos_t) / (index * cos_beta + cos_t)};
}

Mueller facet(const Paint& paint, double cos_beta) {
    const auto [rs, rp] = fresnel({paint.n, paint.k}, cos_beta);
    const double a = (std::norm(rs) + std::norm(rp)) / 2;
    const double b = (std::norm(rs) - std::norm(rp)) / 2;
    const std::complex<double> c = rs * std::conj(rp);
    return {{{a, b, 0, 0}, {b, a, 0, 0}, {0, 0, c.real(), -c.imag()}, {0, 0, c.imag(), c.real()}}};
}

namespace {

double density(const Paint& p, double cos_theta, double tan2_theta) {
    const double sigma2 = p.sigma * p.sigma;
    if (p.slopes == Slopes::cauchy) return p.B / (cos_theta * (sigma2 + tan2_theta));
    const double cos3 = cos_theta * cos_theta * cos_theta;
    return p.B * std::exp(-tan2_theta / (2 * sigma2)) / (2 * kPi * sigma2 * cos3);
}

double shadowing(const Shadowing& s, double theta, double beta) {
    const double ratio = theta / s.omega;
    return (1 + ratio * std::exp(-2 * beta / s.tau)) / (1 + ratio);
}

double volume(const Paint& p, double cos_i, double cos_o) {
    return std::max(0.0, p.rho_d + 2 * p.rho_v / (cos_i + cos_o));
}

/// P SO G / (4 cosθi cosθo) and the facet's cosβ.
struct FacetTerm {
    double weight, cos_beta;
};

FacetTerm facet_term(const Paint& p, Vec3 n, Vec3 wi, Vec3 wo) {
    const Vec3 sum = wi + wo;
    const double sum_length = length(sum);
    const Vec3 h = sum / sum_length;
    const double cos_i = dot(n, wi), cos_o = dot(n, wo);
    const double cos_theta = dot(n, h), sin_theta = length(cross(n, h));
    const double cos_beta = std::min(1.0, sum_length / 2);

    double weight = density(p, cos_theta, sqr(sin_theta / cos_theta)) / (4 * cos_i * cos_o);
    if (p.shadowing) {
        const double beta = std::atan2(length(wi - wo), sum_length);
        weight *= shadowing(*p.shadowing, std::atan2(sin_theta, cos_theta), beta);
    }
    if (p.torrance_sparrow)
        weight *= std::min(1.0, 2 * cos_theta * std::min(cos_i, cos_o) / cos_beta);
    return {weight, cos_beta};
}

}  // namespace

double facet_density(const Paint& paint, double cos_theta) {
    return density(paint, cos_theta, (1 - cos_theta) * (1 + cos_theta) / sqr(cos_theta));
}

Mueller brdf(const Paint& paint, Vec3 n, Vec3 wi, Vec3 wo, Vec3 x_in, Vec3 x_out) {
    const double cos_i = dot(n, wi), cos_o = dot(n, wo);
    if (cos_i <= 0 || cos_o <= 0) return {};

    Mueller m{};
    if (paint.B != 0) {
        const Vec3 k_in = -wi, k_out = wo;
        const Vec3 normal_to_plane = cross(k_in, k_out);
        const double sine = length(normal_to_plane);
        const Vec3 s = sine > 1e-14 ? normal_to_plane / sine : x_in;  // retro: any s will do
        const FacetTerm term = facet_term(paint, n, wi, wo);
        m = product(product(rotation(k_out, s, x_out), facet(paint, term.cos_beta)),
                    rotation(k_in, x_in, s));
        for (auto& row : m)
            for (double& entry : row) entry *= term.weight;
    }
    m[0][0] += volume(paint, cos_i, cos_o);
    return m;
}

// ---- Skies --------------------------------------------------------------------------------------

SkyFunction uniform_sky(double radiance) {
    return [radiance](Vec3 w) { return Stokes{w.y > 0 ? radiance : 0, 0, 0, 0}; };
}

SkyFunction rayleigh_sky(Vec3 sun_direction, double radiance, double max_dolp, double docp) {
    return [=](Vec3 w) -> Stokes {
        if (w.y <= 0) return {};
        const double cos_sun = dot(sun_direction, w);
        const Vec3 e = cross(sun_direction, w);  // |e| = sinΘ, along the electric field
        const Vec3 x = meridian_axis(w), y = cross(-w, x);
        const double ex = dot(e, x), ey = dot(e, y);
        const double s0 = 0.75 * radiance * (1 + sqr(cos_sun));
        const double linear = 0.75 * radiance * max_dolp;
        return {s0, linear * (ex * ex - ey * ey), linear * 2 * ex * ey, docp * cos_sun * s0};
    };
}

// ---- Convex regions of the sphere ---------------------------------------------------------------

namespace {

/// The unit vectors w with w·m > 0 for every side m.
using Sides = std::vector<Vec3>;

/// Smaller regions than about this angle, in radians, count as empty.
constexpr double kThinnest = 1e-10;

double depth(const Sides& sides, Vec3 w) {
    double d = 1;
    for (const Vec3& m : sides) d = std::min(d, dot(w, m));
    return d;
}

/// The point of a region farthest from its sides. It is the centre of the smallest cap around the
/// m, so one, two or three of them are at equal distance from it: try them all.
struct Deepest {
    Vec3 w;
    double depth{-1};
};

Deepest deepest_point(const Sides& sides) {
    Deepest best;
    const auto consider = [&](Vec3 v) {
        const double l = length(v);
        if (l < kThinnest) return;
        const double d = depth(sides, v / l);
        if (d > best.depth) best = {v / l, d};
    };
    for (std::size_t i = 0; i < sides.size(); ++i) {
        consider(sides[i]);
        for (std::size_t j = 0; j < i; ++j) {
            consider(sides[i] + sides[j]);
            for (std::size_t k = 0; k < j; ++k) {
                const Vec3 v = cross(sides[i] - sides[j], sides[j] - sides[k]);
                consider(v);
                consider(-v);
            }
        }
    }
    return best;
}

/// The peak if it is well inside, else a point inside on the way to it, near the edge.
Vec3 choose_apex(const Sides& sides, const Deepest& deepest, Vec3 peak) {
    if (depth(sides, peak) > 1e-4 * deepest.depth) return peak;
    double inside = 0, outside = 1;
    const auto point = [&](double f) { return (1 - f) * deepest.w + f * peak; };
    for (int i = 0; i < 20; ++i) {
        const double middle = (inside + outside) / 2;
        const Vec3 w = point(middle);
        const bool deep = depth(sides, w) > 0.05 * deepest.depth * length(w);
        (deep ? inside : outside) = middle;
    }
    return normalize(point(inside));
}

/// A piece of a region between two azimuths about its apex.
struct Sector {
    Vec3 apex, e1, e2;
    Sides sides;
    double phi_0, phi_1;

    Vec3 toward(double phi) const { return std::cos(phi) * e1 + std::sin(phi) * e2; }
    /// T: how far the region reaches from the apex along the tangent e.
    double reach(Vec3 e) const {
        double t = kPi;
        for (const Vec3& m : sides) t = std::min(t, std::atan2(dot(apex, m), -dot(e, m)));
        return t;
    }
};

/// Halves a sector until T changes by less than a factor of 4 across each piece: from an apex in
/// a sliver, or beside an edge, T(φ) has narrow peaks that both rules could step over.
void add_graded(std::vector<Sector>& sectors, const Sector& s) {
    const double middle = (s.phi_0 + s.phi_1) / 2;
    const auto [least, most] = std::minmax(
        {s.reach(s.toward(s.phi_0)), s.reach(s.toward(middle)), s.reach(s.toward(s.phi_1))});
    if (most <= 4 * least || s.phi_1 - s.phi_0 < 1e-10) {
        sectors.push_back(s);
        return;
    }
    Sector left = s, right = s;
    left.phi_1 = right.phi_0 = middle;
    add_graded(sectors, left);
    add_graded(sectors, right);
}

/// Azimuths of the region's corners, and of the side's nearest points where there are no corners.
std::vector<double> azimuth_breaks(const Sides& sides, Vec3 e1, Vec3 e2) {
    std::vector<double> breaks;
    const auto add = [&](Vec3 v) { breaks.push_back(std::atan2(dot(v, e2), dot(v, e1))); };
    for (std::size_t i = 0; i < sides.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const Vec3 v = cross(sides[i], sides[j]);
            if (length(v) < kThinnest) continue;
            for (const Vec3 corner : {normalize(v), -normalize(v)})
                if (depth(sides, corner) > -1e-9) add(corner);
        }
    if (breaks.empty())
        for (const Vec3& m : sides) add(-m);
    std::sort(breaks.begin(), breaks.end());
    breaks.push_back(breaks.front() + 2 * kPi);
    return breaks;
}

void add_sectors(std::vector<Sector>& sectors, const Sides& sides, Vec3 peak) {
    const Deepest deepest = deepest_point(sides);
    if (deepest.depth < kThinnest) return;
    const Vec3 apex = choose_apex(sides, deepest, peak);
    const Vec3 e1 = any_perpendicular(apex), e2 = cross(apex, e1);
    const std::vector<double> breaks = azimuth_breaks(sides, e1, e2);
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        const double width = breaks[i + 1] - breaks[i];
        if (width < 1e-12) continue;
        const int parts = static_cast<int>(std::ceil(width / (0.67 * kPi)));
        for (int j = 0; j < parts; ++j)
            add_graded(sectors, {apex, e1, e2, sides, breaks[i] + width * j / parts,
                                 breaks[i] + width * (j + 1) / parts});
    }
}

// ---- Cubature -----------------------------------------------------------------------------------

/// Gauss-Kronrod 7-15 on [−1, 1], nodes from the end to the middle; QUADPACK, QK15.
constexpr std::array<double, 8> kNode{
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
    0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
    0.586087235467691130294144691838259, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0.0};
constexpr std::array<double, 8> kKronrod{
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
    0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
    0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
constexpr std::array<double, 8> kGauss{
    0.0, 0.129484966168869693270611432679082, 0.0, 0.279705391489276667901467771423780,
    0.0, 0.381830050505118944950369775488975, 0.0, 0.417959183673469387755102040816327};

/// The i-th of 15 nodes on [0, 1] with both weights.
struct Node {
    double x, kronrod, gauss;
};
Node node(int i) {
    const auto j = static_cast<std::size_t>(i < 8 ? i : 14 - i);
    const double x = i < 8 ? -kNode[j] : kNode[j];
    return {(1 + x) / 2, kKronrod[j] / 2, kGauss[j] / 2};
}

using Integrand = std::function<Stokes(Vec3 w)>;

/// A box of (u, v) in a sector: φ from u, t/T(φ) from v.
struct Cell {
    std::size_t sector;
    double u0, u1, v0, v1;
    Stokes value{}, error{};
    bool split_u{true};

    friend bool operator<(const Cell& a, const Cell& b) {
        return largest(a.error) < largest(b.error);
    }
};

std::pair<Cell, Cell> halves(const Cell& cell, bool split_u) {
    Cell left = cell, right = cell;
    if (split_u)
        left.u1 = right.u0 = (cell.u0 + cell.u1) / 2;
    else
        left.v1 = right.v0 = (cell.v0 + cell.v1) / 2;
    return {left, right};
}

void integrate_cell(Cell& cell, const Sector& sector, const Integrand& f) {
    Stokes kk{}, gk{}, kg{};
    const double du = cell.u1 - cell.u0, dv = cell.v1 - cell.v0;
    const double dphi = sector.phi_1 - sector.phi_0;
    for (int i = 0; i < 15; ++i) {
        const Node u = node(i);
        const double phi = sector.phi_0 + dphi * (cell.u0 + du * u.x);
        const Vec3 e = sector.toward(phi);
        const double reach = sector.reach(e);
        Stokes k{}, g{};
        for (int j = 0; j < 15; ++j) {
            const Node v = node(j);
            const double t = reach * (cell.v0 + dv * v.x);
            const Stokes value = std::sin(t) * f(std::cos(t) * sector.apex + std::sin(t) * e);
            k = k + v.kronrod * value;
            if (v.gauss > 0) g = g + v.gauss * value;
        }
        const double scale = reach * dphi * du * dv;
        kk = kk + (scale * u.kronrod) * k;
        kg = kg + (scale * u.kronrod) * g;
        gk = gk + (scale * u.gauss) * k;
    }
    const Stokes error_u = abs(kk - gk), error_v = abs(kk - kg);
    cell.value = kk;
    cell.error = error_u + error_v;
    cell.split_u = largest(error_u) > largest(error_v);
}

/// The lobe that the cells must not step over: facet slopes of wi, and their RMS value.
struct Lobe {
    Vec3 n, wo;
    double sigma;

    /// The facet that sends wi to wo, as its slopes: a vector in the surface's plane.
    Vec3 slopes(Vec3 wi) const {
        const Vec3 h = wi + wo;
        return h / dot(n, h) - n;
    }
};

/// Halves a cell until it is small beside the lobe, in the plane of slopes where the lobe is round:
/// at grazing views it is a sliver of the sphere that no error estimate would notice.
void add_resolved(std::vector<Cell>& cells, const Cell& cell, const Sector& sector,
                  const Lobe& lobe, int depth_left) {
    std::array<std::array<Vec3, 3>, 3> slopes;
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < 3; ++i) {
        const double u = cell.u0 + (cell.u1 - cell.u0) * 0.5 * static_cast<double>(i);
        const Vec3 e = sector.toward(sector.phi_0 + (sector.phi_1 - sector.phi_0) * u);
        const double reach = (1 - 1e-9) * sector.reach(e);
        for (std::size_t j = 0; j < 3; ++j) {
            const double v = cell.v0 + (cell.v1 - cell.v0) * 0.5 * static_cast<double>(j);
            const Vec3 wi = std::cos(reach * v) * sector.apex + std::sin(reach * v) * e;
            slopes[i][j] = lobe.slopes(wi);
            least = std::min(least, length(slopes[i][j]));
        }
    }
    double extent_u = 0, extent_v = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 2; ++j) {
            extent_u = std::max(extent_u, 2 * length(slopes[j + 1][i] - slopes[j][i]));
            extent_v = std::max(extent_v, 2 * length(slopes[i][j + 1] - slopes[i][j]));
        }
    if (depth_left == 0 || std::max(extent_u, extent_v) <= 6 * lobe.sigma + 0.7 * least) {
        cells.push_back(cell);
        return;
    }
    const auto [left, right] = halves(cell, extent_u > extent_v);
    add_resolved(cells, left, sector, lobe, depth_left - 1);
    add_resolved(cells, right, sector, lobe, depth_left - 1);
}

std::vector<Cell> first_cells(const std::vector<Sector>& sectors, const std::optional<Lobe>& lobe) {
    constexpr int kDeepest = 24;
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < sectors.size(); ++i) {
        const Cell whole{i, 0, 1, 0, 1};
        if (lobe)
            add_resolved(cells, whole, sectors[i], *lobe, kDeepest);
        else
            cells.push_back(whole);
    }
    return cells;
}

/// Splits the worst cell until the sum of errors is small enough in each component.
Integral integrate(const std::vector<Sector>& sectors, const std::optional<Lobe>& lobe,
                   const Integrand& f, double tolerance, std::size_t most_cells) {
    std::priority_queue<Cell> cells;
    Integral total;
    const auto add = [&](Cell cell) {
        integrate_cell(cell, sectors[cell.sector], f);
        total.value = total.value + cell.value;
        total.error = total.error + cell.error;
        cells.push(cell);
    };
    for (const Cell& cell : first_cells(sectors, lobe)) add(cell);
    while (!cells.empty() && cells.size() < most_cells &&
           largest(total.error) > tolerance * std::abs(total.value[0])) {
        const Cell worst = cells.top();
        cells.pop();
        total.value = total.value - worst.value;
        total.error = abs(total.error - worst.error);
        const auto [left, right] = halves(worst, worst.split_u);
        add(left);
        add(right);
    }
    return total;
}

// ---- Light --------------------------------------------------------------------------------------

Vec3 mirror(Vec3 w, Vec3 n) {
    return 2 * dot(n, w) * n - w;
}

std::optional<Lobe> lobe_of(const Paint& p, Vec3 n, Vec3 wo) {
    if (p.B == 0) return {};
    return Lobe{n, wo, p.sigma};
}

/// Sides of the cone that a rectangle fills seen from p; empty when p is in its plane.
Sides cone(const Rectangle& r, Vec3 p) {
    const Vec3 center = normalize(r.corner + 0.5 * (r.edge_u + r.edge_v) - p);
    const std::array<Vec3, 4> corners{r.corner - p, r.corner + r.edge_u - p,
                                      r.corner + r.edge_u + r.edge_v - p, r.corner + r.edge_v - p};
    Sides sides;
    for (std::size_t i = 0; i < 4; ++i) {
        const Vec3 m = cross(normalize(corners[i]), normalize(corners[(i + 1) % 4]));
        const double l = length(m);
        if (l < kThinnest || std::abs(dot(center, m)) < kThinnest * l) return {};
        sides.push_back(m / (dot(center, m) > 0 ? l : -l));
    }
    return sides;
}

/// The part of the sky above a surface, less what a rectangle hides: the outside of a cone with
/// sides m1…m4 is the union of the disjoint convex sets (¬m1), (m1 ¬m2), (m1 m2 ¬m3), …
std::vector<Sector> visible_sky(Vec3 n, Vec3 peak, const Sides& hidden) {
    const Sides open{n, kUp};
    std::vector<Sector> sectors;
    Sides both = open;
    both.insert(both.end(), hidden.begin(), hidden.end());
    if (hidden.empty() || deepest_point(both).depth < kThinnest) {
        add_sectors(sectors, open, peak);
        return sectors;
    }
    Sides part = open;
    for (const Vec3& m : hidden) {
        part.push_back(-m);
        add_sectors(sectors, part, peak);
        part.back() = m;
    }
    return sectors;
}

Integral reflected_sky(const Paint& paint, Vec3 n, Vec3 wo, Vec3 x_out, const SkyFunction& sky,
                       const Sides& hidden, double tolerance, std::size_t most_cells) {
    if (dot(n, wo) <= 0) return {};
    const auto integrand = [&](Vec3 wi) {
        const Stokes incident = dot(n, wi) * sky(wi);
        return multiply(brdf(paint, n, wi, wo, meridian_axis(wi), x_out), incident);
    };
    return integrate(visible_sky(n, mirror(wo, n), hidden), lobe_of(paint, n, wo), integrand,
                     tolerance, most_cells);
}

constexpr std::size_t kCells = 40000;        // a stop for what does not converge: about 4 s
constexpr std::size_t kCellsOfCorner = 400;  // the same inside and outside a nested integral

}  // namespace

Integral panel(const Paint& paint, Vec3 n, Vec3 wo, Vec3 x_out, const SkyFunction& sky,
               double relative_tolerance) {
    return reflected_sky(paint, n, wo, x_out, sky, {}, relative_tolerance, kCells);
}

Integral corner_first_bounce(const Rectangle& a, const Rectangle& b, Vec3 p, Vec3 wo, Vec3 x_out,
                             const SkyFunction& sky, double relative_tolerance) {
    return reflected_sky(a.paint, a.normal, wo, x_out, sky, cone(b, p), relative_tolerance, kCells);
}

Integral corner_second_bounce(const Rectangle& a, const Rectangle& b, Vec3 p, Vec3 wo, Vec3 x_out,
                              const SkyFunction& sky, double relative_tolerance) {
    Sides seen = cone(b, p);
    const double height = dot(b.normal, p - b.corner);
    if (seen.empty() || height <= 0 || dot(a.normal, wo) <= 0) return {};
    seen.push_back(a.normal);
    std::vector<Sector> sectors;
    add_sectors(sectors, seen, mirror(wo, a.normal));

    const double inner_tolerance = 0.2 * relative_tolerance;
    const double outer_tolerance = 0.8 * relative_tolerance;
    double inner_error = 0;  // the largest of any inner integral, relative to its S0
    const auto integrand = [&](Vec3 wi) -> Stokes {
        const Vec3 q = p + (height / -dot(b.normal, wi)) * wi;
        const Vec3 x = any_perpendicular(wi);  // one axis for the beam q → p, on both its ends
        const Integral light = reflected_sky(b.paint, b.normal, -wi, x, sky, cone(a, q),
                                             inner_tolerance, kCellsOfCorner);
        if (light.value[0] > 0)
            inner_error = std::max(inner_error, largest(light.error) / light.value[0]);
        const Stokes incident = dot(a.normal, wi) * light.value;
        return multiply(brdf(a.paint, a.normal, wi, wo, x, x_out), incident);
    };
    Integral result = integrate(sectors, lobe_of(a.paint, a.normal, wo), integrand, outer_tolerance,
                                kCellsOfCorner);
    const double carried = inner_error * std::abs(result.value[0]);
    for (double& e : result.error) e += carried;
    return result;
}

}  // namespace malus::reference
