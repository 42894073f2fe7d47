// reference_test.cpp — the reference itself against closed forms, tables and brute force.
//
// Nothing of the renderer is used. Closed forms: Fresnel numbers, form factors of rectangles, the
// lobe's integral seen from the normal. Tables: NIST SCATMECH 7. Brute force: midpoint sums.
//
// Frame   the world's: +Y up, north = −Z, east = +X; reference.h for beams.
// Source  at each number.
// SPDX-License-Identifier: Apache-2.0
#include "support/reference.h"

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "support/catch.h"

#ifndef MALUS_SHARED_DATA
#define MALUS_SHARED_DATA ""
#endif

using namespace malus;
using namespace malus::reference;

namespace {

const Vec3 kNormal{0, 1, 0};  // of a floor

Paint green_550() {  // Table 1 of the study; angles there in degrees
    Paint p;
    p.n = 1.366, p.k = 0.2746, p.B = 0.0235, p.sigma = 0.1288;
    p.shadowing = Shadowing{to_radians(87.89), to_radians(149.9)};
    p.rho_d = -9.450e-4, p.rho_v = -1.285e-3;
    return p;
}

Paint black_440() {  // Table 1, angles in degrees
    Paint p;
    p.n = 1.4330, p.k = 0.0102, p.B = 0.5742, p.sigma = 0.8524;
    p.shadowing = Shadowing{to_radians(47.56), to_radians(0.0741)};
    p.rho_d = 2.290e-2, p.rho_v = 3.100e-2;
    return p;
}

Paint smooth_paint() {
    Paint p;
    p.n = 1.5, p.k = 0.3, p.B = 0.6, p.sigma = 0.4, p.rho_d = 0.02, p.rho_v = 0.01;
    return p;
}

Paint lambertian(double rho_d) {
    Paint p;
    p.rho_d = rho_d;
    return p;
}

/// Facets that reflect everything, B = 1.
Paint perfect_facets(double sigma, Slopes slopes = Slopes::gaussian) {
    Paint p;
    p.n = 0, p.k = 1e9, p.B = 1, p.sigma = sigma, p.slopes = slopes;
    return p;
}

Vec3 direction(double zenith_deg, double azimuth_deg) {
    const double z = to_radians(zenith_deg), a = to_radians(azimuth_deg);
    return {std::sin(z) * std::sin(a), std::cos(z), -std::sin(z) * std::cos(a)};
}

Vec3 turned_about_vertical(Vec3 v, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * v.x + s * v.z, v.y, -s * v.x + c * v.z};
}

/// Some axis ⟂ w, turned by an angle.
Vec3 some_axis(Vec3 w, double angle = 0) {
    const Vec3 x = normalize(cross(w, Vec3{0.36, 0.48, -0.8}));
    return std::cos(angle) * x + std::sin(angle) * cross(w, x);
}

void check_close(const Stokes& a, const Stokes& b, double tolerance) {
    for (std::size_t i = 0; i < 4; ++i) {
        CAPTURE(i, a[i], b[i], a[0]);
        CHECK(std::abs(a[i] - b[i]) <= tolerance * std::abs(b[0]));
    }
}

double largest_error(const Integral& r) {
    double e = 0;
    for (double x : r.error) e = std::max(e, x);
    return e / r.value[0];
}

double largest_entry(const Mueller& m) {
    double e = 0;
    for (const auto& row : m)
        for (double x : row) e = std::max(e, std::abs(x));
    return e;
}

Mueller difference(Mueller a, const Mueller& b) {
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j) a[i][j] -= b[i][j];
    return a;
}

// ---- Form factors; c the distance
// -----------------------------------------------------------------

/// Element to a parallel a×b rectangle, its normal through a corner. Siegel & Howell, Thermal
/// Radiation Heat Transfer, appendix on configuration factors; Howell's catalog, section B.
double parallel_factor(double a, double b, double c) {
    const double p = std::hypot(a, c), q = std::hypot(b, c);
    return (a / p * std::atan(b / p) + b / q * std::atan(a / q)) / (2 * kPi);
}

/// Element at distance c from the base of a perpendicular rectangle of height a and width b, in
/// front of the end of its base. Siegel & Howell, ibid.
double perpendicular_factor(double a, double b, double c) {
    const double p = std::hypot(a, c);
    return (std::atan(b / c) - c / p * std::atan(b / p)) / (2 * kPi);
}

/// Mean over a floor w×l of the factor to a wall h×l on its edge l: Howell's catalog, C-14.
double perpendicular_rectangles_factor(double w, double h, double l) {
    const double W2 = sqr(w / l), H2 = sqr(h / l), W = w / l, H = h / l;
    const double r = std::sqrt(H2 + W2), all = 1 + W2 + H2;
    return (W * std::atan(1 / W) + H * std::atan(1 / H) - r * std::atan(1 / r) +
            0.25 * (std::log((1 + W2) * (1 + H2) / all) +
                    W2 * std::log(W2 * all / ((1 + W2) * (W2 + H2))) +
                    H2 * std::log(H2 * all / ((1 + H2) * (W2 + H2))))) /
           (kPi * W);
}

/// Midpoint sum over a box of the sky, f(w) with dω = sin z dz da; zenith 0…90°.
template <class F>
Stokes sum_over_sky(double azimuth_0, double azimuth_1, int zeniths, int azimuths, F f) {
    Stokes sum{};
    const double dz = kPi / 2 / zeniths, da = (azimuth_1 - azimuth_0) / azimuths;
    for (int i = 0; i < zeniths; ++i)
        for (int j = 0; j < azimuths; ++j) {
            const double z = (i + 0.5) * dz, a = azimuth_0 + (j + 0.5) * da;
            const Vec3 w = direction(to_degrees(z), to_degrees(a));
            const Stokes s = f(w);
            for (std::size_t c = 0; c < 4; ++c) sum[c] += s[c] * std::sin(z) * dz * da;
        }
    return sum;
}

/// A floor 2×2 and a wall 2 wide and 1.5 high along its northern edge (z = −1).
Rectangle corner_floor(const Paint& p) {
    return {{-1, 0, -1}, {2, 0, 0}, {0, 0, 2}, {0, 1, 0}, p};
}
Rectangle corner_wall(const Paint& p) {
    return {{-1, 0, -1}, {2, 0, 0}, {0, 1.5, 0}, {0, 0, 1}, p};
}

}  // namespace

// ---- Fresnel and the facet ----------------------------------------------------------------------

TEST_CASE("Reference: Fresnel of green 550: R, DoLP and retardance", "[reference]") {
    // Born & Wolf's formulas for N = 1.366 + 0.2746i, worked out apart.
    struct Row {
        double beta_deg, r, dolp, retardance_deg;
    };
    for (const Row& row :
         {Row{0, 0.0369, 0, 180}, {45, 0.0482, 0.837, 155.63}, {60, 0.0910, 0.915, 47.19}}) {
        const double cos_beta = std::cos(to_radians(row.beta_deg));
        const auto [rs, rp] = fresnel({1.366, 0.2746}, cos_beta);
        const Mueller m = facet(green_550(), cos_beta);
        CAPTURE(row.beta_deg);
        CHECK(std::abs(m[0][0] - row.r) < 6e-5);
        CHECK(std::abs(m[1][0] / m[0][0] - row.dolp) < 6e-4);
        // At normal incidence the phase is 180° or −180°, as rounding has it.
        const double retardance = to_degrees(std::arg(rs * std::conj(rp)));
        CHECK(std::abs(std::remainder(retardance - row.retardance_deg, 360)) < 6e-3);
    }
}

TEST_CASE("Reference: A facet at 60° turns (0.5, 0, 0.5, 0) as in Mitsuba 3.8", "[reference]") {
    const Stokes s = multiply(facet(green_550(), 0.5), {0.5, 0, 0.5, 0});
    const Stokes expected{0.04550, 0.04164, 0.01246, 0.01345};  // Mitsuba 3.8
    for (std::size_t i = 0; i < 4; ++i) CHECK(std::abs(s[i] - expected[i]) < 6e-6);
}

TEST_CASE("Reference: Brewster: reflected light is fully s-polarized", "[reference]") {
    Paint glass;
    glass.n = 1.5;
    const Mueller m = facet(glass, std::cos(std::atan(1.5)));
    CHECK(std::abs(m[1][0] - m[0][0]) < 1e-15);
}

TEST_CASE("Reference: The whole matrix agrees with NIST SCATMECH 7", "[reference]") {
    const std::string folder = MALUS_SHARED_DATA;
    std::ifstream file(folder + "/scatmech_facet.csv");
    if (folder.empty() || !file) {
        WARN("scatmech_facet.csv is not here; skipped");
        return;
    }
    // z = mean normal, k_in = (sin θi, 0, −cos θi), k_out = (sin θs cos φs, sin θs sin φs, cos θs),
    // x = unit(k_in × k_out) on both beams, f = B cosθ f_csv with B = 1, S3 of opposite sign.
    int rows = 0;
    double worst = 0;
    std::string line;
    while (std::getline(file, line)) {
        if (line.empty() || line[0] == '#' || line[0] == 'n') continue;
        std::vector<double> v;
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');)
            v.push_back(std::strtod(cell.c_str(), nullptr));  // stod throws at 1e-310
        REQUIRE(v.size() == 25);
        if (v[9] < 1e-250) continue;

        Paint p;
        p.n = v[0], p.k = v[1], p.sigma = v[2], p.B = 1;
        const double ti = to_radians(v[3]), ts = to_radians(v[4]), ps = to_radians(v[5]);
        const Vec3 n{0, 0, 1}, wi{-std::sin(ti), 0, std::cos(ti)};
        const Vec3 wo{std::sin(ts) * std::cos(ps), std::sin(ts) * std::sin(ps), std::cos(ts)};
        const Vec3 across = cross(-wi, wo);
        const Vec3 x = length(across) > 1e-12 ? normalize(across) : some_axis(wi);
        const Mueller m = brdf(p, n, wi, wo, x, x);

        const double cos_theta = normalize(wi + wo).z;
        const auto sign = [](std::size_t i) { return i == 3 ? -1.0 : 1.0; };
        Mueller expected{};
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j)
                expected[i][j] = sign(i) * sign(j) * cos_theta * v[9 + 4 * i + j];
        worst = std::max(worst, largest_entry(difference(m, expected)) / expected[0][0]);
        ++rows;
    }
    CAPTURE(rows, worst);
    CHECK(rows > 2000);
    CHECK(worst <= 1e-10);
}

TEST_CASE("Reference: Reciprocity: M(wo→wi) = D Mᵀ D with D = diag(1,1,−1,1)", "[reference]") {
    const Vec3 wi = direction(37, 20), wo = direction(64, 171);
    const Vec3 x_in = some_axis(wi, 0.4), x_out = some_axis(wo, 1.1);
    for (Paint p : {smooth_paint(), black_440()}) {
        p.torrance_sparrow = true;
        const Mueller forth = brdf(p, kNormal, wi, wo, x_in, x_out);
        const Mueller back = brdf(p, kNormal, wo, wi, x_out, x_in);
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j) {
                const double sign = (i == 2) == (j == 2) ? 1 : -1;
                CHECK(std::abs(back[i][j] - sign * forth[j][i]) < 1e-15);
            }
    }
}

TEST_CASE("Reference: A normal mirror flips S2 and S3, on any axis", "[reference]") {
    Paint p = smooth_paint();
    p.rho_d = p.rho_v = 0;
    for (double angle : {0.0, 0.3, 1.0}) {
        const Vec3 x = some_axis(kNormal, angle);
        const Mueller m = brdf(p, kNormal, kNormal, kNormal, x, x);
        const double r = m[0][0];
        const Mueller mirror{{{r, 0, 0, 0}, {0, r, 0, 0}, {0, 0, -r, 0}, {0, 0, 0, -r}}};
        CHECK(largest_entry(difference(m, mirror)) < 1e-14 * r);
    }
}

TEST_CASE("Reference: Polarized light stays physical: S0 ≥ |S|, f_vol < 0 included",
          "[reference]") {
    for (const Paint& p : {green_550(), black_440(), smooth_paint()})
        for (double zenith : {5.0, 60.0, 88.0})
            for (double azimuth : {0.0, 77.0, 180.0}) {
                const Vec3 wi = direction(zenith, azimuth), wo = direction(70, 0);
                const Mueller m = brdf(p, kNormal, wi, wo, some_axis(wi), some_axis(wo));
                for (std::size_t axis = 1; axis < 4; ++axis)
                    for (double sign : {-1.0, 1.0}) {
                        Stokes s{1, 0, 0, 0};
                        s[axis] = sign;
                        s = multiply(m, s);
                        CHECK(std::hypot(s[1], s[2], s[3]) <= s[0] * (1 + 1e-12));
                    }
            }
}

TEST_CASE("Reference: Facets: the integral of P is B for Gaussian slopes", "[reference]") {
    for (double sigma : {0.0742, 0.1288, 0.468383, 0.7556, 0.8057, 0.8524}) {
        const Paint p = perfect_facets(sigma);
        double sum = 0;
        const int steps = 20000;
        for (int i = 0; i < steps; ++i) {
            const double theta = (i + 0.5) * kPi / 2 / steps;
            sum += facet_density(p, std::cos(theta)) * 2 * kPi * std::sin(theta) * kPi / 2 / steps;
        }
        CHECK(std::abs(sum - 1) < 1e-6);
    }
    CHECK(std::abs(facet_density(green_550(), 1) - 0.2255) < 6e-5);  // B/(2πσ²), section 5
}

// ---- Skies --------------------------------------------------------------------------------------

TEST_CASE("Reference: Rayleigh sky: the zenith is polarized across the sun's vertical",
          "[reference]") {
    const SkyFunction sky = rayleigh_sky(direction(90, 0), 1, 0.8);
    const Stokes above_sun = sky(direction(45, 0));  // electric field horizontal: S1 < 0
    CHECK(std::abs(above_sun[1] + 0.75 * 0.8 * 0.5) < 1e-15);
    CHECK(std::abs(above_sun[2]) < 1e-15);
    const Stokes east = sky(direction(89, 90));  // field nearly vertical
    CHECK(east[1] > 0.99 * 0.75 * 0.8);
    CHECK(sky(direction(91, 10))[0] == 0);
}

// ---- A panel ------------------------------------------------------------------------------------

TEST_CASE("Reference: A Lambertian panel under a uniform sky sends π ρd L", "[reference]") {
    const Vec3 wo = direction(50, 30);
    const Integral flat = panel(lambertian(0.2), kNormal, wo, some_axis(wo), uniform_sky(3), 1e-10);
    CHECK(std::abs(flat.value[0] / (kPi * 0.2 * 3) - 1) < 1e-12);
    // Tilted by t it sees the part (1 + cos t)/2 of it.
    const Vec3 n = direction(70, -60), x = some_axis(n);
    const Integral tilted = panel(lambertian(0.2), n, n, x, uniform_sky(3), 1e-10);
    const double seen = (1 + std::cos(to_radians(70))) / 2;
    CHECK(std::abs(tilted.value[0] / (kPi * 0.2 * 3 * seen) - 1) < 1e-11);
}

TEST_CASE("Reference: Perfect facets seen from the normal: closed form of the lobe",
          "[reference]") {
    // wo = n: ∫ f cosθi dωi = ∫ P cosθ dω over tilts below 45°. With u = 1/cosθ from 1 to √2,
    // Gaussian ∫ exp(−(u²−1)/2σ²)/σ² du, Cauchy ∫ 2π du / (u² (u² − a²)), a² = 1 − σ².
    const Vec3 x{1, 0, 0};
    for (double sigma : {0.05, 0.1288, 0.3, 0.9}) {
        const double q = 1 / (sigma * std::sqrt(2.0));
        const double gaussian = std::exp(q * q) * std::sqrt(kPi / 2) / sigma *
                                (std::erfc(q) - std::erfc(q * std::sqrt(2.0)));
        const double a = std::sqrt(1 - sigma * sigma);
        const auto primitive = [a](double u) {
            return (std::log((u - a) / (u + a)) / (2 * a) + 1 / u) / (a * a);
        };
        const double cauchy = 2 * kPi * (primitive(std::sqrt(2.0)) - primitive(1));
        for (Slopes slopes : {Slopes::gaussian, Slopes::cauchy}) {
            const Integral r =
                panel(perfect_facets(sigma, slopes), kNormal, kNormal, x, uniform_sky(1), 1e-7);
            const double expected = slopes == Slopes::gaussian ? gaussian : cauchy;
            CAPTURE(sigma, r.value[0], expected);
            CHECK(std::abs(r.value[0] / expected - 1) < 1e-11);
            CHECK(r.error[0] <= 1e-7 * r.value[0]);
        }
    }
}

TEST_CASE("Reference: Energy at 89°: bare facets create it, Torrance-Sparrow does not",
          "[reference]") {
    // Hemispherical reflectance of perfect facets, B = 1. Expected values: midpoint sum over
    // slopes, 2000 × 2000, of (wo·h)/cosθo where wi is above the surface.
    const Vec3 wo = direction(89, 0), x = some_axis(wo);
    CHECK(std::abs(panel(perfect_facets(0.1288), kNormal, wo, x, uniform_sky(1), 1e-6).value[0] -
                   3.387) < 1e-3);
    CHECK(std::abs(panel(perfect_facets(0.7556), kNormal, wo, x, uniform_sky(1), 1e-6).value[0] -
                   11.757) < 1e-3);
    for (double sigma : {0.05, 0.1288, 0.4, 0.9})
        for (double view_deg : {0.0, 45.0, 80.0, 89.0}) {
            Paint p = perfect_facets(sigma);
            p.torrance_sparrow = true;
            const Vec3 w = direction(view_deg, 10);
            const Integral r = panel(p, kNormal, w, some_axis(w), uniform_sky(1), 1e-5);
            CAPTURE(sigma, view_deg, r.value[0]);
            CHECK(r.value[0] <= 1);
        }
}

TEST_CASE("Reference: A vertical panel agrees with a midpoint sum over the sky", "[reference]") {
    // The wall faces south; the axis of the sky's beam here is horizontal, not the meridian.
    const Vec3 n{0, 0, 1}, wo = normalize(Vec3{0.5, -0.3, 0.8}), x_out = some_axis(wo);
    const SkyFunction sky = rayleigh_sky(direction(40, 100), 2, 0.8, 0.5);
    for (const Paint& p : {smooth_paint(), black_440()}) {
        const Stokes brute = sum_over_sky(kPi / 2, 1.5 * kPi, 300, 600, [&](Vec3 w) {
            const Vec3 across = cross(-w, meridian_axis(w));  // y, a right angle from x
            const Stokes s = sky(w);
            const Stokes cosine{dot(n, w) * s[0], -dot(n, w) * s[1], -dot(n, w) * s[2],
                                dot(n, w) * s[3]};
            return multiply(brdf(p, n, w, wo, across, x_out), cosine);
        });
        const Integral r = panel(p, n, wo, x_out, sky, 1e-7);
        check_close(brute, r.value, 2e-5);
    }
}

TEST_CASE("Reference: Panel integrals reach 1e-7 and mean what they say", "[reference]") {
    const SkyFunction sky = rayleigh_sky(direction(57, 90), 1, 0.8, 0.5);
    const Vec3 n = direction(30, 40);
    for (Slopes slopes : {Slopes::gaussian, Slopes::cauchy})
        for (double sigma : {0.05, 0.3, 0.9})
            for (double view_deg : {0.0, 60.0, 89.0})
                for (bool shadowed : {false, true}) {
                    Paint p = smooth_paint();
                    p.sigma = sigma, p.slopes = slopes, p.torrance_sparrow = shadowed;
                    if (shadowed) p.shadowing = black_440().shadowing;
                    const Vec3 along = some_axis(n, 2);
                    const double v = to_radians(view_deg);
                    const Vec3 wo = std::cos(v) * n + std::sin(v) * along;
                    const Vec3 x_out = normalize(cross(along, n));
                    const Integral r = panel(p, n, wo, x_out, sky, 1e-7);
                    const Integral coarse = panel(p, n, wo, x_out, sky, 1e-4);
                    CAPTURE(sigma, view_deg, shadowed);
                    CHECK(largest_error(r) <= 1e-7);
                    CHECK(largest_error(coarse) <= 1e-4);
                    check_close(coarse.value, r.value, 1e-4);
                }
}

TEST_CASE("Reference: Turning panel, view and sun about the vertical changes nothing",
          "[reference]") {
    const Vec3 sun = direction(57, 90), n = direction(25, 10), wo = direction(65, -70);
    const Vec3 x = some_axis(wo);
    const Stokes still =
        panel(smooth_paint(), n, wo, x, rayleigh_sky(sun, 1, 0.8, 0.5), 1e-8).value;
    for (double angle : {0.7, 2.0, 4.0}) {
        const auto turn = [angle](Vec3 v) { return turned_about_vertical(v, angle); };
        const Stokes turned = panel(smooth_paint(), turn(n), turn(wo), turn(x),
                                    rayleigh_sky(turn(sun), 1, 0.8, 0.5), 1e-8)
                                  .value;
        check_close(turned, still, 1e-9);
    }
}

TEST_CASE("Reference: A sharp lobe at 89° is not stepped over", "[reference]") {
    // There it is a sliver of the sphere that an error estimate may miss altogether. Midpoint sum
    // over facets instead: slope r = σ√(−2 ln u), dωh = cos³θ σ²/u du dφ, dωi = 4 cosβ dωh.
    Paint p = smooth_paint();
    p.sigma = 0.05, p.B = 0.1, p.rho_d = p.rho_v = 0;
    const double view = to_radians(89);
    const Vec3 along = normalize(Vec3{-0.8, 0, -0.3}), x_out = cross(kNormal, along);
    const Vec3 wo = std::cos(view) * kNormal + std::sin(view) * along;
    const SkyFunction sky = rayleigh_sky(direction(to_degrees(1), 90), 1, 0.8, 0.5);
    const int steps = 1000;
    Stokes brute{};
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double u = (i + 0.5) / steps, phi = 2 * kPi * (j + 0.5) / steps;
            const double r = p.sigma * std::sqrt(-2 * std::log(u));
            const Vec3 h = normalize(Vec3{r * std::cos(phi), 1, r * std::sin(phi)});
            const double cos_beta = dot(h, wo);
            const Vec3 wi = 2 * cos_beta * h - wo;
            if (cos_beta <= 0 || wi.y <= 0) continue;
            const double solid_angle = 4 * cos_beta * h.y * h.y * h.y * sqr(p.sigma) / u * 2 * kPi;
            Stokes s = sky(wi);
            for (double& c : s) c *= wi.y * solid_angle / steps / steps;
            s = multiply(brdf(p, kNormal, wi, wo, meridian_axis(wi), x_out), s);
            for (std::size_t c = 0; c < 4; ++c) brute[c] += s[c];
        }
    for (double tolerance : {1e-5, 1e-6, 1e-7, 1e-8, 1e-9}) {
        CAPTURE(tolerance);
        check_close(panel(p, kNormal, wo, x_out, sky, tolerance).value, brute, 3e-5);
    }
}

TEST_CASE("Reference: Turning x_out by α turns S1 and S2 by 2α", "[reference]") {
    const Vec3 wo = direction(65, -70);
    const SkyFunction sky = rayleigh_sky(direction(57, 90), 1, 0.8, 0.5);
    const auto at = [&](double a) {
        return panel(smooth_paint(), kNormal, wo, some_axis(wo, a), sky, 1e-8).value;
    };
    const Stokes s = at(0);
    for (double a : {0.3, 1.2}) {
        const double c = std::cos(2 * a), d = std::sin(2 * a);
        check_close(at(a), {s[0], c * s[1] + d * s[2], -d * s[1] + c * s[2], s[3]}, 1e-9);
    }
}

// ---- Two rectangles -----------------------------------------------------------------------------

TEST_CASE("Reference: Form factors used below agree with Howell's C-14", "[reference]") {
    // The mean over the floor of the element's factor to the wall.
    const double w = 2, h = 1.5, l = 2;
    const int steps = 400;
    double mean = 0;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double c = w * sqr((i + 0.5) / steps), left = l * (j + 0.5) / steps;
            const double weight = 2 * (i + 0.5) / steps / steps / steps;
            mean +=
                weight * (perpendicular_factor(h, left, c) + perpendicular_factor(h, l - left, c));
        }
    CHECK(std::abs(mean / perpendicular_rectangles_factor(w, h, l) - 1) < 1e-5);
}

TEST_CASE("Reference: Lambertian corner: both bounces are form factors", "[reference]") {
    const double rho_floor = 0.1, rho_wall = 0.25, radiance = 2;
    const Rectangle floor = corner_floor(lambertian(rho_floor));
    const Rectangle wall = corner_wall(lambertian(rho_wall));
    const Vec3 wo = direction(40, 140), x = some_axis(wo);
    for (const Vec3 p : {Vec3{0.2, 0, 0.3}, {-0.9, 0, 0.99}, {0.5, 0, -0.9}, {0, 0, -0.999}}) {
        const double c = p.z + 1;
        const double factor =
            perpendicular_factor(1.5, p.x + 1, c) + perpendicular_factor(1.5, 1 - p.x, c);
        const SkyFunction sky = uniform_sky(radiance);
        const Integral first = corner_first_bounce(floor, wall, p, wo, x, sky, 1e-8);
        const Integral second = corner_second_bounce(floor, wall, p, wo, x, sky, 1e-4);
        const double wall_radiance = rho_wall * kPi * radiance / 2;  // it sees half the sky
        CAPTURE(p.x, p.z);
        CHECK(std::abs(first.value[0] / (rho_floor * kPi * radiance * (1 - factor)) - 1) < 1e-9);
        CHECK(std::abs(second.value[0] / (rho_floor * kPi * wall_radiance * factor) - 1) < 2e-6);
        CHECK(largest_error(second) <= 1e-4);
    }
}

TEST_CASE("Reference: Lambertian facing walls: the sky between them is a form factor",
          "[reference]") {
    // a at z = 0 faces north, b at z = −0.8 faces south; both 2 wide and 1 high on the ground.
    const Rectangle a{{-1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, -1}, lambertian(0.1)};
    const Rectangle b{{-1, 0, -0.8}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, lambertian(0.25)};
    const double d = 0.8;
    const auto sky_seen = [d](double x, double y) {  // by b at (x, y): half, less a above y
        return 0.5 - parallel_factor(1 - x, 1 - y, d) - parallel_factor(1 + x, 1 - y, d);
    };
    const Vec3 p{0.3, 0.4, 0};
    const Vec3 wo = normalize(Vec3{0.3, 0.5, -0.8}), x_out = some_axis(wo);
    double expected = 0;
    const int steps = 500;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double x = -1 + 2 * (i + 0.5) / steps, y = (j + 0.5) / steps;
            const double r2 = sqr(x - p.x) + sqr(y - p.y) + d * d;
            const double light = 0.25 * kPi * sky_seen(x, y);
            expected += 0.1 * light * d * d / (r2 * r2) * 2 / (steps * steps);
        }
    const SkyFunction sky = uniform_sky(1);
    const Integral second = corner_second_bounce(a, b, p, wo, x_out, sky, 1e-4);
    CHECK(std::abs(second.value[0] / expected - 1) < 2e-5);
    CHECK(largest_error(second) <= 1e-4);
    const Integral first = corner_first_bounce(a, b, p, wo, x_out, sky, 1e-8);
    CHECK(std::abs(first.value[0] / (0.1 * kPi * sky_seen(p.x, p.y)) - 1) < 1e-9);
}

TEST_CASE("Reference: A polarized corner agrees with a nested midpoint sum", "[reference]") {
    // Area form over the wall, sky in zenith and azimuth, and another axis for the beam between.
    const Paint p_floor = smooth_paint();
    Paint p_wall = smooth_paint();
    p_wall.n = 1.366, p_wall.k = 0.2746, p_wall.sigma = 0.5;
    const Rectangle floor = corner_floor(p_floor), wall = corner_wall(p_wall);
    const SkyFunction sky = rayleigh_sky(direction(60, 140), 1, 0.8, 0.5);
    const Vec3 p{0.2, 0, 0.1}, wo = normalize(Vec3{-0.4, 0.8, 0.6}), x_out = some_axis(wo);
    const int nx = 20, ny = 20;
    Stokes expected{};
    for (int i = 0; i < nx; ++i)
        for (int j = 0; j < ny; ++j) {
            const Vec3 q{-1 + 2 * (i + 0.5) / nx, 1.5 * (j + 0.5) / ny, -1};
            const double r = length(q - p);
            const Vec3 wi = (q - p) / r;
            const Vec3 beam_axis = meridian_axis(wi);
            Stokes light = sum_over_sky(kPi / 2, 1.5 * kPi, 24, 48, [&](Vec3 w) {
                Stokes s = sky(w);
                for (double& c : s) c *= dot(wall.normal, w);
                return multiply(brdf(p_wall, wall.normal, w, -wi, meridian_axis(w), beam_axis), s);
            });
            const double weight = wi.y * -dot(wall.normal, wi) / (r * r) * 3 / (nx * ny);
            for (double& c : light) c *= weight;
            const Stokes out = multiply(brdf(p_floor, kNormal, wi, wo, beam_axis, x_out), light);
            for (std::size_t c = 0; c < 4; ++c) expected[c] += out[c];
        }
    const Integral r = corner_second_bounce(floor, wall, p, wo, x_out, sky, 1e-4);
    check_close(expected, r.value, 2e-3);
    CHECK(largest_error(r) <= 1e-4);
    const Integral coarse = corner_second_bounce(floor, wall, p, wo, x_out, sky, 1e-2);
    check_close(coarse.value, r.value, 1e-2);
}

TEST_CASE("Reference: A rectangle seen from behind blocks the sky and reflects nothing",
          "[reference]") {
    const Rectangle floor = corner_floor(lambertian(0.1));
    Rectangle wall = corner_wall(lambertian(0.25));
    const Vec3 p{0, 0, 0}, wo = direction(40, 140), x = some_axis(wo);
    const SkyFunction sky = uniform_sky(1);
    const double blocked = corner_first_bounce(floor, wall, p, wo, x, sky, 1e-8).value[0];
    wall.normal = -wall.normal;
    CHECK(corner_first_bounce(floor, wall, p, wo, x, sky, 1e-8).value[0] == blocked);
    CHECK(corner_second_bounce(floor, wall, p, wo, x, sky, 1e-4).value[0] == 0);
}
