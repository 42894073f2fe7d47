// lanes_test.cpp — the BRDF in vector registers against the same in double.
// SPDX-License-Identifier: Apache-2.0
#include "render/lanes.h"

#include "malus/optics/priest_germer.h"
#include "render/prepared_scene.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/geometries.h"
#include "support/statistics.h"

using namespace malus;

namespace {

// Some of those that a paint has.
std::vector<double> wavelengths_of(const Material& paint) {
    if (paint.rows.size() == 1) return {550};
    return {440, 470, 520, 550, 575, 600};
}

// Every number of the registers is finite, and the double's to 1e-5.
void compare(const Material& paint, const Surface& surface, const Vec3& wi, const Vec3& wo) {
    const Vec3 n{0, 0, 1};
    const Reflection r = reflection(n, wi, wo);
    const ReflectionOf<Reals> side_by_side = reflection(Vec3s(n), Vec3s(wi), Vec3s(wo));
    const auto geometry = facet_geometry<Lanes>(
        Mask(surface.attenuation() == Attenuation::kTorranceSparrow), side_by_side);
    const std::vector<double> wavelengths = wavelengths_of(paint);
    for (std::size_t w = 0; w < wavelengths.size(); ++w) {
        const auto lanes = eval(surface.lanes(w / 2), surface.slopes(), geometry);
        const auto p = parameters_at(paint, wavelengths[w]);
        const auto f = eval(p, paint.slopes, paint.attenuation, r);
        const auto lane = [w](const Lanes& x) { return static_cast<double>(x.get(w % 2 * kSide)); };
        const double a = lane(lanes.facet.a()), b = lane(lanes.facet.b());
        const double re = lane(lanes.facet.re), im = lane(lanes.facet.im);
        CHECK(std::isfinite(a + b + re + im + lane(lanes.volume)));
        // Near its change of sign f_vol is the difference of two rounded terms.
        CHECK(lane(lanes.volume) == near(f.volume, 1e-5 * f.volume + 3e-7 * std::abs(p.rho_d)));
        // The exponential's argument is exact to 2⁻²⁴ of itself; beyond e^{−40} of the peak that
        // matters to nobody.
        if (paint.slopes == Slopes::kGaussian && r.tan2_theta / (2 * p.sigma * p.sigma) > 40)
            continue;
        // Amplitudes of facets are known to some roundings of 1: that tells where there is hardly any
        // contrast. Near the critical angle g = √(n² − sin²β) is the root of a rounded difference.
        const double strength = facet_strength(paint, {wavelengths[w], p}, r);
        const double g2 = std::abs(p.n * p.n - 1 + sqr(r.cos_beta));
        const double critical = p.k == 0 ? 4e-7 / std::sqrt(g2 + 1e-7) / r.cos_beta : 0;
        const double scale = 1e-5 * f.facet.a() + 1e-6 * std::sqrt(strength * f.facet.a()) +
                             (1e-12 + critical) * strength;
        CHECK(std::abs(a - f.facet.a()) <= scale);
        CHECK(std::abs(b - f.facet.b()) <= scale);
        CHECK(std::abs(re - f.facet.re) <= scale);
        CHECK(std::abs(im - f.facet.im) <= scale);
    }
}

}  // namespace

TEST_CASE("Lanes: every wavelength of a register is the double's number to 1e-5") {
    Uniform u(8);
    for (const Material& paint : varied_paints()) {
        const std::vector<double> wavelengths = wavelengths_of(paint);
        const Surface surface(paint, wavelengths);
        for (int i = 0; i < 500; ++i) {
            const auto upper = [&] {
                const double z = u(), phi = 7 * u(), r = std::sqrt(1 - z * z);
                return Vec3{r * std::cos(phi), r * std::sin(phi), z};
            };
            const Vec3 wi = upper();
            compare(paint, surface, wi, upper());
        }
    }
}

TEST_CASE("Lanes: singular geometries, at the point and beside it") {
    for (const Material& paint : varied_paints()) {
        const std::vector<double> wavelengths = wavelengths_of(paint);
        const Surface surface(paint, wavelengths);
        for (const Geometry& g : singular_geometries()) {
            CAPTURE(paint.name, g.name, g.beside);
            compare(paint, surface, g.wi, g.wo);
        }
    }
}

TEST_CASE("Lanes: decay is e^x for x ≤ 0 to 2 roundings, 0 where floats end") {
    for (double x : {0.0, -1e-6, -0.5, -30.0, -86.9})
        CHECK(static_cast<double>(decay(Lanes(static_cast<float>(x))).get(0)) ==
              Approx(std::exp(static_cast<double>(static_cast<float>(x)))).epsilon(2.5e-7));
    for (float x : {-87.5f, -1e10f, -3e38f, -HUGE_VALF}) CHECK(decay(Lanes(x)).get(0) == 0);
}
