// priest_germer_test.cpp — the Mueller BRDF.
// SPDX-License-Identifier: Apache-2.0
#include "malus/optics/priest_germer.h"

#include "support/catch.h"
#include "support/fixtures.h"
#include "support/geometries.h"
#include "support/statistics.h"

using namespace malus;

namespace {

using Matrix = reference::Mueller;

// The 4×4 matrix of f with its own facet frames.
Matrix matrix(const BrdfMueller<double>& f) {
    Matrix m{};
    for (std::size_t column = 0; column < 4; ++column) {
        std::array<double, 4> unit{};
        unit[column] = 1;
        const Stokes<double> out = f * Stokes<double>{unit[0], unit[1], unit[2], unit[3]};
        m[0][column] = out.s0, m[1][column] = out.s1, m[2][column] = out.s2, m[3][column] = out.s3;
    }
    return m;
}

PriestGermer<double> facets_only(double n, double k, double B, double sigma) {
    return {n, k, B, sigma, 1, 0, 0, 0};
}

Vec3 upper_direction(Uniform& u) {
    const double z = u(), phi = 2 * kPi * u(), r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

const Vec3 kNormal{0, 0, 1};

// f between frames, column by column, against a 4×4 matrix.
void compare(const BrdfMueller<double>& f, const Turn& in, const Turn& out, const Matrix& expected,
             double tolerance) {
    for (std::size_t column = 0; column < 4; ++column) {
        std::array<double, 4> unit{};
        unit[column] = 1;
        const Stokes<double> S =
            turned(f * turned(Stokes<double>{unit[0], unit[1], unit[2], unit[3]}, in), out);
        CHECK(std::abs(S.s0 - expected[0][column]) <= tolerance);
        CHECK(std::abs(S.s1 - expected[1][column]) <= tolerance);
        CHECK(std::abs(S.s2 - expected[2][column]) <= tolerance);
        CHECK(std::abs(S.s3 - expected[3][column]) <= tolerance);
    }
}

}  // namespace

TEST_CASE("Priest-Germer: the whole Mueller matrix is that of NIST SCATMECH 7") {
    // Columns and conventions: header of the file. Its S3 has the other sign, f = B cosθ f_csv.
    const auto rows = table_rows("scatmech_facet_sample.csv");
    CHECK(rows.size() >= 36);
    for (const auto& cells : rows) {
        std::vector<double> x;
        for (const std::string& cell : cells) x.push_back(std::stod(cell));
        REQUIRE(x.size() == 25);
        const double n = x[0], k = x[1], sigma = x[2];
        const Vec3 wi = -Vec3{std::sin(to_radians(x[3])), 0, -std::cos(to_radians(x[3]))};
        const Vec3 wo = direction_from(x[4], x[5]);
        const Reflection r = reflection(kNormal, wi, wo);
        const Matrix f =
            matrix(eval(facets_only(n, k, 1, sigma), Slopes::kGaussian, Attenuation::kNone, r));
        const double m00 = x[9];
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j) {
                const double flip = (i == 3) != (j == 3) ? -1 : 1;
                CAPTURE(cells, i, j);
                CHECK(std::abs(f[i][j] - flip * r.cos_theta * x[9 + 4 * i + j]) <= 1e-10 * m00);
            }
    }
}

TEST_CASE("Slopes: the Gaussian distribution of facets integrates to B for every row") {
    for (const Material* paint : {&green_paint(), &black_paint()})
        for (const MaterialRow& row : paint->rows) {
            // ∫ P dΩ = 2π ∫ P sinθ dθ with t = tan θ, to t = 12σ; midpoint rule of a smooth
            // integrand whose ends vanish.
            double sum = 0;
            const int steps = 20000;
            const double dt = 12 * row.p.sigma / steps;
            for (int i = 0; i < steps; ++i) {
                const double t = (i + 0.5) * dt, c = 1 / std::sqrt(1 + t * t);
                sum += slope_distribution(Slopes::kGaussian, row.p.B, row.p.sigma)(
                           Slopes::kGaussian, 1 / c, t * t) *
                       2 * kPi * t * c * c * c * dt;
            }
            CHECK(sum == Approx(row.p.B).epsilon(1e-6));
        }
}

TEST_CASE("Slopes: the peak of green 550 nm is the study's 0.2255") {
    const auto p = parameters_at(green_paint(), 550);
    const auto gaussian = slope_distribution(Slopes::kGaussian, p.B, p.sigma);
    CHECK(gaussian(Slopes::kGaussian, 1, 0) == near(0.2255, 5e-5));
    const auto cauchy = slope_distribution(Slopes::kCauchy, 2.0, 0.5);
    CHECK(cauchy(Slopes::kCauchy, 1 / 0.8, 0.5625) == Approx(2 / (0.8 * 0.8125)));
}

TEST_CASE("Decay: e^x for x ≤ 0, 0 where numbers end") {
    for (double x : {0.0, -1e-12, -0.5, -86.9, -87.1, -700.0}) CHECK(decay(x) == std::exp(x));
    for (double x : {-709.0, -1e10, -HUGE_VAL}) CHECK(decay(x) == 0);
}

TEST_CASE("Shadowing: none at exact specular and at exact retro-reflection") {
    const double tau = to_radians(47.56), inv_omega = 1 / to_radians(0.0741);
    CHECK(shadowing(tau, inv_omega)(0, 0.7) == 1);
    CHECK(shadowing(tau, inv_omega)(0.4, 0) == near(1, 1e-15));
    // A hand calculation: θ = Ω, β = τ/2: (1 + e⁻¹)/2.
    CHECK(shadowing(0.3, 1 / 0.2)(0.2, 0.15) == Approx((1 + std::exp(-1.0)) / 2));
}

TEST_CASE("Torrance-Sparrow: perfect facets reflect no more than they receive") {
    for (double sigma : {0.13, 0.76})
        for (double zenith : {0.0, 60.0, 85.0, 89.0}) {
            const Vec3 wi = direction_from(zenith, 180);
            // Directional-hemispherical reflectance with Rs = Rp = 1 (n → metal-like k = 1e6).
            const auto p = facets_only(1, 1e6, 1, sigma);
            double sum = 0;
            const int rings = 600, sectors = 600;
            for (int i = 0; i < rings; ++i)
                for (int j = 0; j < sectors; ++j) {
                    const double z = (i + 0.5) / rings, phi = 2 * kPi * (j + 0.5) / sectors;
                    const double r = std::sqrt(1 - z * z);
                    const Vec3 wo{r * std::cos(phi), r * std::sin(phi), z};
                    sum += eval(p, Slopes::kGaussian, Attenuation::kTorranceSparrow,
                                reflection(kNormal, wi, wo))
                               .facet.a() *
                           z;
                }
            CHECK(sum * 2 * kPi / (rings * sectors) < 1.001);
        }
}

TEST_CASE("Volume: never negative, and the published negative rows are clamped") {
    CHECK(volume(-9.450e-4, -1.285e-3, 0.5, 0.5) == 0);
    CHECK(volume(0.02, 0.01, 0.25, 0.75) == Approx(0.04));
}

TEST_CASE("Reciprocity: swapping light and sensor gives D Mᵀ D, for random directions") {
    Uniform u(5);
    constexpr std::array<double, 4> D{1, 1, -1, 1};
    for (const Material& paint : varied_paints())
        for (const MaterialRow& row : paint.rows)
            for (int i = 0; i < 200; ++i) {
                const Vec3 wi = upper_direction(u), wo = upper_direction(u);
                const Reflection there = reflection(kNormal, wi, wo);
                const Reflection back = reflection(kNormal, wo, wi);
                const Matrix a = matrix(eval(row.p, paint.slopes, paint.attenuation, there));
                const Matrix b = matrix(eval(row.p, paint.slopes, paint.attenuation, back));
                // The axis s of the way back is −s, the same axis; both matrices are in it.
                for (std::size_t r = 0; r < 4; ++r)
                    for (std::size_t c = 0; c < 4; ++c)
                        CHECK(b[r][c] == near(D[r] * D[c] * a[c][r], 1e-12 * a[0][0]));
            }
}

TEST_CASE("Physicality: light stays light, |S| ≤ S0, for random directions and paints") {
    Uniform u(6);
    for (const Material& paint : varied_paints())
        for (const MaterialRow& row : paint.rows)
            for (int i = 0; i < 300; ++i) {
                const Vec3 wi = upper_direction(u);
                const Reflection r = reflection(kNormal, wi, upper_direction(u));
                const auto f = eval(row.p, paint.slopes, paint.attenuation, r);
                // Where the exponential has left double's range there are no digits to check.
                if (f.facet.a() < 1e-250 && f.volume == 0) continue;
                for (const Stokes<double>& in :
                     {Stokes<double>{1, 0, 0, 0}, Stokes<double>{1, 1, 0, 0},
                      Stokes<double>{1, -1, 0, 0}, Stokes<double>{1, 0, 1, 0},
                      Stokes<double>{1, 0, -1, 0}, Stokes<double>{1, 0, 0, 1},
                      Stokes<double>{1, 0, 0, -1}, Stokes<double>{1, 0.48, -0.6, 0.64}}) {
                    const Stokes<double> out = f * in;
                    CHECK(out.s0 >= 0);
                    CHECK(dop(out) <= 1 + 1e-12);
                }
            }
}

TEST_CASE("Whole matrix: facet frames and turns agree with an independent derivation") {
    // Between fixed frames on both beams, against full 4×4 rotations in complex arithmetic.
    Uniform u(7);
    for (const Material* paint : {&green_paint(), &black_paint()})
        for (const MaterialRow& row : paint->rows)
            for (int i = 0; i < 100; ++i) {
                const Vec3 n = normalize(Vec3{u() - 0.5, u() + 0.2, u() - 0.5});
                const Basis basis(n);
                const Vec3 wi = basis.to_world(upper_direction(u));
                const Vec3 wo = basis.to_world(upper_direction(u));
                const BeamFrame in{-wi, any_perpendicular(wi)}, out{wo, any_perpendicular(wo)};
                const Reflection r = reflection(n, wi, wo);
                const auto f = eval(row.p, paint->slopes, paint->attenuation, r);
                const Matrix expected = reference::brdf(reference_paint(*paint, row.wavelength_nm),
                                                        n, wi, wo, in.x, out.x);
                // 1e-300: where double runs out of normal numbers.
                compare(f, turn_between(in, r.in), turn_between(r.out, out), expected,
                        1e-10 * expected[0][0] + 1e-300);
            }
}

TEST_CASE("Retro-reflection: the limit holds at the point and beside it") {
    const auto p = parameters_at(green_paint(), 440);
    const Vec3 wo = direction_from(40, 20);
    const Vec3 across = any_perpendicular(wo);
    const auto seen = [&](const Vec3& wi) {
        const Reflection r = reflection(kNormal, wi, wo);
        // Between frames that do not depend on s.
        const BeamFrame in{-wi, normalize(across - dot(across, wi) * wi)}, out{wo, across};
        const auto f = eval(p, Slopes::kGaussian, Attenuation::kNone, r);
        return turned(f * turned(Stokes<double>{1, 0.3, 0.5, 0.2}, turn_between(in, r.in)),
                      turn_between(r.out, out));
    };
    // At β = 0 a facet is a mirror: R(0) P/(4cos²) times (S0, S1, −S2, −S3) in a frame whose y
    // turns over with the beam.
    const Reflection r = reflection(kNormal, wo, wo);
    const double R = (sqr(p.n - 1) + sqr(p.k)) / (sqr(p.n + 1) + sqr(p.k));
    const double P =
        prepared(p, Slopes::kGaussian).P(Slopes::kGaussian, 1 / r.cos_theta, r.tan2_theta);
    const double f = R * P / (4 * sqr(r.cos_i));
    for (double beside : {0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-3}) {
        const Vec3 wi = normalize(wo + beside * normalize(across + 0.5 * cross(wo, across)));
        const Stokes<double> S = seen(wi);
        CAPTURE(beside);
        const double tolerance = f * (1e-12 + 10 * beside);
        CHECK(std::abs(S.s0 - f - volume(p.rho_d, p.rho_v, r.cos_i, r.cos_o)) < tolerance);
        CHECK(std::abs(S.s1 - 0.3 * f) < tolerance);
        CHECK(std::abs(S.s2 + 0.5 * f) < tolerance);
        CHECK(std::abs(S.s3 + 0.2 * f) < tolerance);
    }
}

TEST_CASE("Singular geometries: at them and 1e-12, 1e-6, 1e-3 beside, f is the reference's") {
    for (const Geometry& g : singular_geometries()) {
        const BeamFrame in{-g.wi, any_perpendicular(g.wi)}, out{g.wo, any_perpendicular(g.wo)};
        const Reflection r = reflection(kNormal, g.wi, g.wo);
        for (const Material& paint : varied_paints())
            for (const MaterialRow& row : paint.rows) {
                const auto f = eval(row.p, paint.slopes, paint.attenuation, r);
                const Matrix expected = reference::brdf(reference_paint(paint, row.wavelength_nm),
                                                        kNormal, g.wi, g.wo, in.x, out.x);
                // The exponential's argument tan²θ/2σ² is known to 1e-11 of itself: a mirror at
                // grazing has a steep one. Amplitudes are known to 1e-15 (of 1): that tells where
                // there is hardly any contrast.
                const double argument = r.tan2_theta / (2 * sqr(row.p.sigma));
                const double strength = facet_strength(paint, row, r);
                const double scale = (1e-10 + 1e-11 * argument) * expected[0][0] +
                                     1e-15 * std::sqrt(strength * expected[0][0]) +
                                     1e-30 * strength + 1e-300;
                CAPTURE(g.name, g.beside, paint.name, row.wavelength_nm, expected[0][0]);
                compare(f, turn_between(in, r.in), turn_between(r.out, out), expected, scale);
            }
    }
}
