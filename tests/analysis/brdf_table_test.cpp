// brdf_table_test.cpp — a paint over the hemisphere, between meridian frames.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/brdf_table.h"

#include <sstream>

#include "malus/io/spectral_image.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/geometries.h"
#include "support/statistics.h"

using namespace malus;

namespace {

const Stokes<double> kNatural{1, 0, 0, 0};

PaintModel model(const Material& material, double nm) {
    return {nm, parameters_at(material, nm), material.slopes, material.attenuation};
}
PaintModel facets_only(double n, double k, double B, double sigma) {
    return {550, {n, k, B, sigma, 1, 0, 0, 0}};
}

SurfaceDirection from_degrees(double zenith_deg, double azimuth_deg) {
    return {to_radians(zenith_deg), to_radians(azimuth_deg)};
}
SurfaceDirection random_direction(Uniform& u) {
    return {std::acos(u()), 2 * kPi * u()};
}

// The largest facet distribution of a table, and where.
struct Peak {
    double value = 0, zenith_deg = 0, azimuth_deg = 0;
};
Peak facet_peak(const BrdfTable& table) {
    Peak peak;
    for (int i = 0; i < table.zeniths(); ++i)
        for (int j = 0; j < table.azimuths(); ++j)
            if (const double P = table.at(i, j).facet_distribution; P > peak.value)
                peak = {P, table.degrees(i), table.degrees(j)};
    return peak;
}

void check_matrix(const MuellerMatrix& m, const reference::Mueller& expected, double tolerance) {
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j) {
            CAPTURE(i, j);
            CHECK(m[i][j] == near(expected[i][j], tolerance));
        }
}

}  // namespace

TEST_CASE("BRDF: between meridian frames the whole matrix is the independent reference's") {
    Uniform u(11);
    for (const Material& paint : varied_paints())
        for (const MaterialRow& row : paint.rows)
            for (int i = 0; i < 20; ++i) {
                const SurfaceDirection light = random_direction(u), view = random_direction(u);
                const Vec3 wi = direction(light.zenith, light.azimuth),
                           wo = direction(view.zenith, view.azimuth);
                const reference::Paint same = reference_paint(paint, row.wavelength_nm);
                const reference::Mueller expected = reference::brdf(
                    same, kUp, wi, wo, reference::meridian_axis(wi), reference::meridian_axis(wo));
                const BrdfValue value = brdf_at(model(paint, row.wavelength_nm), light, view);
                CAPTURE(paint.name, row.wavelength_nm, light.zenith, view.zenith);
                // The exponential's argument is known to 1e-11 of itself (a mirror's is large),
                // amplitudes to 1e-15 of 1.
                const Reflection r = reflection(kUp, wi, wo);
                const double steep = r.tan2_theta / (2 * sqr(row.p.sigma));
                const double strength = facet_strength(paint, row, r);
                check_matrix(meridian_mueller(value), expected,
                             (1e-10 + 1e-11 * steep) * expected[0][0] +
                                 1e-15 * std::sqrt(strength * expected[0][0]) + 1e-30 * strength +
                                 1e-300);
                const double P = reference::facet_density(same, std::cos(value.theta));
                if (row.p.sigma > 1e-3)  // through θ, a mirror's has no digits
                    CHECK(value.facet_distribution == near(P, 1e-8 * P + 1e-300));
                CHECK(std::abs(value.f00() - meridian_mueller(value)[0][0]) <= 1e-15 * value.f00());
            }
}

TEST_CASE("BRDF: in the plane of incidence at specular, Fresnel's matrix with S1 in the plane") {
    // P = B/2πσ² = 0.225454, R = 0.0910, DoLP = 0.915, Δ = arg(rs rp*) = 47.19° at 60° of
    // N = 1.366+0.2746i: computed for the contract of equations with complex numbers, apart from this code.
    const BrdfValue value =
        brdf_at(model(green_paint(), 550), from_degrees(60, 20), from_degrees(60, 200));
    const double P = 0.0235 / (2 * kPi * 0.1288 * 0.1288);
    const MuellerMatrix m = meridian_mueller(value), f = facet_mueller(value);
    CHECK(value.facet_distribution == Approx(P).epsilon(1e-12));
    CHECK(value.shadowing == near(1, 1e-12));
    CHECK(value.attenuation == 1);
    CHECK(value.f00() == near(P * 0.0910, 5e-5 * P));  // 4 cos² 60° = 1
    CHECK(m[1][0] / m[0][0] == near(-0.915, 5e-4));
    CHECK(f[1][0] / f[0][0] == near(0.915, 5e-4));
    CHECK(to_degrees(std::atan2(f[3][2], f[2][2])) == near(47.19, 5e-3));
    // Both axes turned by 90°: S1 and S2 change sign on either side.
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j) {
            const double flip = (i == 1 || i == 2) != (j == 1 || j == 2) ? -1 : 1;
            CHECK(m[i][j] == near(flip * f[i][j], 1e-14));
        }
}

TEST_CASE("BRDF: along the normal a mirror turns over S2 and S3") {
    // R(0) = ((n−1)² + k²)/((n+1)² + k²).
    const PaintModel mirror = facets_only(0.2, 5, 1, 0.01);
    const double R = (0.64 + 25) / (1.44 + 25), P = 1 / (2 * kPi * 1e-4);
    const MuellerMatrix m =
        meridian_mueller(brdf_at(mirror, from_degrees(0, 0), from_degrees(0, 180)));
    const double f = R * P / 4;
    check_matrix(m, {{{f, 0, 0, 0}, {0, f, 0, 0}, {0, 0, -f, 0}, {0, 0, 0, -f}}}, 1e-12 * f);
}

TEST_CASE("BRDF: at twice Brewster's angle from the light DoLP is 1, and S1 = S0 finds nothing") {
    const PaintModel glass = facets_only(1.5, 0, 1, 0.3);
    const double brewster = std::atan(1.5);
    for (double zenith : {0.7, 0.9, 1.2}) {
        // In the plane of incidence the facet lies half-way: β = (θi + θo)/2.
        const BrdfValue value = brdf_at(glass, {zenith, 0}, {2 * brewster - zenith, kPi});
        CHECK(value.beta == near(brewster, 1e-12));
        CHECK(dolp(reflected(value, kNatural)) == near(1, 1e-12));
        CHECK(aolp(reflected(value, kNatural)) == near(kPi / 2, 1e-12));  // across the plane
        CHECK(reflected(value, {1, 1, 0, 0}).s0 == near(0, 1e-12 * value.f00()));
        CHECK(reflected(value, {1, -1, 0, 0}).s0 == Approx(2 * value.f00()).epsilon(1e-12));
    }
}

TEST_CASE("BRDF: of facets alone DoLP is that of Fresnel at the facet's incidence") {
    // Green 550 nm has no volume light: its printed term is below 0.
    const BrdfTable table = tabulate(model(green_paint(), 550), from_degrees(45, 0), kNatural, 90);
    int checked = 0;
    for (int i = 0; i < 90; i += 5)
        for (int j = 0; j < 360; j += 15) {
            const BrdfNode& node = table.at(i, j);
            // cos 2β = wi·wo = cosθi cosθo + sinθi sinθo cosΔφ
            const double z = to_radians(i), s = std::sqrt(0.5);
            const double cos_2beta = s * std::cos(z) + s * std::sin(z) * std::cos(to_radians(j));
            const auto a = reference::fresnel({1.366, 0.2746}, std::sqrt((1 + cos_2beta) / 2));
            const double Rs = std::norm(a.rs), Rp = std::norm(a.rp);
            CAPTURE(i, j);
            if (node.f00 > 1e-250) {
                CHECK(dolp(node.out) == near((Rs - Rp) / (Rs + Rp), 1e-9));
                ++checked;
            }
        }
    CHECK(checked > 400);
    CHECK(dolp(table.at(45, 180).out) == near(0.837, 5e-4));  // at 45°, as computed elsewhere
}

TEST_CASE("BRDF table: the facet distribution of green 550 nm peaks with 0.22 at specular") {
    // B/2πσ² of the study's Table 1, 0.0235/(2π 0.1288²) = 0.22545; its figure reads 0.22.
    for (int incidence : {45, 60}) {
        const Peak peak = facet_peak(
            tabulate(model(green_paint(), 550), from_degrees(incidence, 0), kNatural, 90));
        CHECK(peak.value == near(0.22545, 5e-6));
        CHECK(peak.zenith_deg == incidence);
        CHECK(peak.azimuth_deg == 180);
    }
}

TEST_CASE("BRDF table: a Lambertian surface reflects its albedo, and not at the horizon") {
    const PaintModel matte = model(lambertian(0.37), 550);
    for (double zenith : {0.0, 45.0, 89.0})
        for (int steps : {90, 12, 7}) {
            const BrdfTable table = tabulate(matte, from_degrees(zenith, 33), {2, 1, 1, 1}, steps);
            CHECK(reflectance(table) == near(0.37, 1e-13));
            for (int j = 0; j < table.azimuths(); ++j) {
                CHECK(table.at(steps - 1, j).f00 == near(0.37 / kPi, 1e-15));
                CHECK(table.at(steps - 1, j).out.s0 == near(2 * 0.37 / kPi, 1e-15));
                CHECK(table.at(steps - 1, j).out.s1 == 0);
                CHECK(table.at(steps, j).f00 == 0);
            }
        }
}

TEST_CASE("BRDF table: the sum over views is what an even sky shows by reciprocity") {
    // Adaptive cubature of the same paint seen from there under a sky of radiance 1.
    for (const Material* paint : {&green_paint(), &black_paint()})
        for (const MaterialRow& row : paint->rows)
            for (double zenith : {0.0, 45.0, 60.0}) {
                const Vec3 w = direction(to_radians(zenith), 0);
                const auto sky =
                    reference::panel(reference_paint(*paint, row.wavelength_nm), kUp, w,
                                     reference::meridian_axis(w), reference::uniform_sky(1), 1e-5);
                const double R = reflectance(tabulate(model(*paint, row.wavelength_nm),
                                                      from_degrees(zenith, 0), kNatural, 90));
                CAPTURE(paint->name, row.wavelength_nm, zenith);
                // What steps of 1° leave, most of it near the horizon.
                CHECK(R == Approx(sky.value[0]).epsilon(0.005));
            }
}

TEST_CASE("BRDF: light and view exchanged give D Mᵀ D, between meridian frames too") {
    Uniform u(12);
    constexpr std::array<double, 4> D{1, 1, -1, 1};
    for (const Material& paint : varied_paints())
        for (int i = 0; i < 50; ++i) {
            const SurfaceDirection a = random_direction(u), b = random_direction(u);
            const PaintModel one = model(paint, 550);
            const MuellerMatrix there = meridian_mueller(brdf_at(one, a, b)),
                                back = meridian_mueller(brdf_at(one, b, a));
            for (std::size_t r = 0; r < 4; ++r)
                for (std::size_t c = 0; c < 4; ++c)
                    CHECK(back[r][c] == near(D[r] * D[c] * there[c][r], 1e-12 * there[0][0]));
        }
}

TEST_CASE("BRDF table: mirrored in the plane of incidence S2 and S3 change sign") {
    const PaintModel paint = model(black_paint(), 600);
    // Light with S1 alone is its own mirror image; S2 and S3 turn over.
    for (const Stokes<double>& S :
         {Stokes<double>{1, -0.6, 0, 0}, Stokes<double>{1, 0.2, 0.5, -0.4}}) {
        const BrdfTable a = tabulate(paint, from_degrees(50, 0), S, 30),
                        b = tabulate(paint, from_degrees(50, 0), {S.s0, S.s1, -S.s2, -S.s3}, 30);
        for (int i = 0; i < a.zeniths(); ++i)
            for (int j = 1; j < a.azimuths(); ++j) {
                const BrdfNode &x = a.at(i, j), &y = b.at(i, a.azimuths() - j);
                const double tolerance = 1e-12 * x.f00;
                CHECK(x.f00 == near(y.f00, tolerance));
                CHECK(x.out.s0 == near(y.out.s0, tolerance));
                CHECK(x.out.s1 == near(y.out.s1, tolerance));
                CHECK(x.out.s2 == near(-y.out.s2, tolerance));
                CHECK(x.out.s3 == near(-y.out.s3, tolerance));
            }
    }
}

TEST_CASE("BRDF table: light from another azimuth turns the table") {
    const PaintModel paint = model(green_paint(), 440);
    const Stokes<double> S{1, 0.3, 0.2, 0.1};
    const BrdfTable a = tabulate(paint, from_degrees(60, 0), S, 18),
                    b = tabulate(paint, from_degrees(60, 75), S, 18);
    for (int i = 0; i < a.zeniths(); ++i)
        for (int j = 0; j < a.azimuths(); ++j) {
            const BrdfNode &x = a.at(i, j), &y = b.at(i, (j + 15) % a.azimuths());
            CHECK(x.facet_distribution == Approx(y.facet_distribution).epsilon(1e-12));
            CHECK(x.shadowing == Approx(y.shadowing).epsilon(1e-12));
            CHECK(x.out.s2 == near(y.out.s2, 1e-12 * x.f00));
            CHECK(x.out.s3 == near(y.out.s3, 1e-12 * x.f00));
        }
}

TEST_CASE("BRDF table: attenuation is a column of its own, and 1 without") {
    Material paint = black_paint();
    const BrdfTable bare = tabulate(model(paint, 440), from_degrees(70, 0), kNatural, 18);
    paint.attenuation = Attenuation::kTorranceSparrow;
    const BrdfTable less = tabulate(model(paint, 440), from_degrees(70, 0), kNatural, 18);
    CHECK(bare.at(16, 0).attenuation == 1);
    // View from 80° above light from 70°: θ = 75°, β = 5°; 2 cos 75° cos 80° / cos 5°.
    const double G =
        2 * std::cos(to_radians(75)) * std::cos(to_radians(80)) / std::cos(to_radians(5));
    CHECK(less.at(16, 0).attenuation == Approx(G));
    const double volume =
        2.290e-2 + 2 * 3.100e-2 / (std::cos(to_radians(70)) + std::cos(to_radians(80)));
    CHECK(less.at(16, 0).f00 - volume == Approx((bare.at(16, 0).f00 - volume) * G));
}

TEST_CASE("BRDF table: CSV and image hold the same numbers at the same directions") {
    const std::vector<BrdfTable> tables{
        tabulate(model(green_paint(), 440), from_degrees(45, 0), {1, 0.3, 0.2, 0.1}, 9),
        tabulate(model(green_paint(), 600), from_degrees(45, 0), {1, 0.3, 0.2, 0.1}, 9)};
    const Image image = brdf_image(tables);
    CHECK(image.width == 36);
    CHECK(image.height == 10);
    CHECK(image.channels.size() == 20);
    CHECK(*image.text("stokesReferenceFrame") == "surface meridian");
    CHECK(*image.number("stepDegrees") == 10);

    std::istringstream lines(brdf_csv(tables));
    std::string line;
    std::getline(lines, line);
    CHECK(line ==
          "wavelength_nm,view_zenith_deg,view_azimuth_deg,facet_distribution_per_sr,shadowing,"
          "attenuation,f00_per_sr,S0_per_sr,S1_per_sr,S2_per_sr,S3_per_sr,DoLP,AoLP_deg");
    std::size_t rows = 0;
    for (; std::getline(lines, line); ++rows) {
        std::istringstream cells(line);
        std::vector<double> x;
        for (std::string cell; std::getline(cells, cell, ',');) x.push_back(std::stod(cell));
        REQUIRE(x.size() == 13);
        const auto pixel = static_cast<std::size_t>(x[1] / 10 * 36 + x[2] / 10);
        const char* channels[] = {"P", "SO", "G", "F00", "S0", "S1", "S2", "S3", "DoLP", "AoLP"};
        for (std::size_t c = 0; c < 10; ++c) {
            CAPTURE(line, channels[c]);
            CHECK(spectral_data(image, channels[c], x[0])[pixel] == static_cast<float>(x[3 + c]));
        }
        CHECK(x[11] <= 1);
        CHECK(x[12] < 180);
    }
    CHECK(rows == 2 * 360);
}
