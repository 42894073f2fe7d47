// direction_sampler_test.cpp — drawn directions follow their density.
// SPDX-License-Identifier: Apache-2.0
#include "render/direction_sampler.h"

#include "support/catch.h"
#include "support/fixtures.h"
#include "support/statistics.h"

using namespace malus;

namespace {

std::vector<PriestGermer<double>> rows_of(const Material& material) {
    std::vector<PriestGermer<double>> rows;
    for (const MaterialRow& row : material.rows) rows.push_back(row.p);
    return rows;
}

// χ² of directions over the upper hemisphere, in cells of equal solid angle around the specular
// direction's own frame; one more cell holds what falls below the surface.
double chi2_of(const DirectionSampler& sampler, const Vec3& wo, unsigned seed) {
    const DirectionSampler::View<double> view(sampler, wo);
    constexpr int kZ = 40, kA = 60, kSamples = 300000, kFine = 12;
    std::vector<double> counts(kZ * kA + 1, 0), expected(kZ * kA + 1, 0);
    Uniform u(seed);
    for (int i = 0; i < kSamples; ++i) {
        const Vec3 wi = view.sample(u(), u(), u());
        if (!(wi.z > 0)) {
            counts.back() += 1;
            continue;
        }
        double phi = std::atan2(wi.y, wi.x) / (2 * kPi);
        phi -= std::floor(phi);
        const int z = std::min(kZ - 1, static_cast<int>(kZ * wi.z));
        const int a = std::min(kA - 1, static_cast<int>(kA * phi));
        counts[static_cast<std::size_t>(z * kA + a)] += 1;
    }
    double above = 0;
    for (int z = 0; z < kZ; ++z)
        for (int a = 0; a < kA; ++a) {
            double sum = 0;
            for (int i = 0; i < kFine; ++i)
                for (int j = 0; j < kFine; ++j) {
                    const double y = (z + (i + 0.5) / kFine) / kZ;
                    const double phi = 2 * kPi * (a + (j + 0.5) / kFine) / kA;
                    const double r = std::sqrt(1 - y * y);
                    sum += view.pdf({r * std::cos(phi), r * std::sin(phi), y});
                }
            const double p = sum / (kFine * kFine) * 2 * kPi / (kZ * kA);
            expected[static_cast<std::size_t>(z * kA + a)] = p * kSamples;
            above += p;
        }
    CHECK(above < 1.002);
    expected.back() = std::max(0.0, 1 - above) * kSamples;
    return chi2_z(counts, expected);
}

}  // namespace

// Each χ² test fails a right sampler with probability 3e-5 (z > 4); there are 26.
TEST_CASE("Surface sampling: directions follow the mixture of the shipped paints",
          "[statistical]") {
    for (const Material* paint : {&green_paint(), &black_paint()}) {
        const DirectionSampler sampler(rows_of(*paint), paint->slopes);
        for (double zenith_deg : {0.0, 30.0, 60.0, 80.0, 89.0}) {
            const double z = to_radians(zenith_deg);
            CAPTURE(paint->name, zenith_deg);
            CHECK(chi2_of(sampler, {std::sin(z) * 0.8, std::sin(z) * 0.6, std::cos(z)}, 17) < 4);
        }
    }
}

TEST_CASE("Surface sampling: each lobe alone follows its density", "[statistical]") {
    for (Slopes slopes : {Slopes::kGaussian, Slopes::kCauchy})
        for (double sigma : {0.12, 0.4, 1.0, 2.0}) {
            const std::vector<PriestGermer<double>> rows{{1.5, 0.1, 1, sigma, 1, 0, 0, 0}};
            const DirectionSampler sampler(rows, slopes);
            for (double zenith_deg : {20.0, 75.0}) {
                const double z = to_radians(zenith_deg);
                CAPTURE(static_cast<int>(slopes), sigma, zenith_deg);
                CHECK(chi2_of(sampler, {-std::sin(z), 0, std::cos(z)}, 23) < 4);
            }
        }
}

TEST_CASE("Surface sampling: a mirror of σ = 1e-5 is sampled around its specular direction") {
    const std::vector<PriestGermer<double>> rows{{1.5, 0.1, 1, 1e-5, 1, 0, 0, 0}};
    const DirectionSampler sampler(rows, Slopes::kGaussian);
    const Vec3 wo = normalize(Vec3{0.6, 0.1, 0.5});
    const DirectionSampler::View<double> view(sampler, wo);
    Uniform u(2);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 wi = view.sample(u(), u(), u());
        CHECK(length(wi - Vec3{-wo.x, -wo.y, wo.z}) < 2e-4);
        // f cosθi/pdf of a perfect facet is A(wo)·B·cosθ/cosθo ≈ 1: no fireflies.
        const Reflection r = reflection({0, 0, 1}, wi, wo);
        const double P = slope_distribution(Slopes::kGaussian, 1.0, 1e-5)(
            Slopes::kGaussian, 1 / r.cos_theta, r.tan2_theta);
        CHECK(P / (4 * r.cos_o) / view.pdf(wi) == Approx(1).epsilon(1e-3));
    }
}

TEST_CASE("Surface sampling: a black paint says so") {
    const std::vector<PriestGermer<double>> rows{{1.5, 0.1, 0, 0.3, 1, 0, 0, 0}};
    CHECK(DirectionSampler(rows, Slopes::kGaussian).black());
    CHECK_FALSE(DirectionSampler(rows_of(green_paint()), Slopes::kGaussian).black());
}
