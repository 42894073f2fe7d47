// lanes_test.cpp — the BRDF in vector registers against the same in double.
// SPDX-License-Identifier: Apache-2.0
#include "render/lanes.h"

#include "malus/optics/priest_germer.h"
#include "render/prepared_scene.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/statistics.h"

using namespace malus;

TEST_CASE("Lanes: every wavelength of a register is the double's number to 1e-5") {
    Uniform u(8);
    const std::vector<double> wavelengths{440, 470, 520, 550, 575, 600};
    for (const Material* paint : {&green_paint(), &black_paint()}) {
        const Surface surface(*paint, wavelengths);
        for (int i = 0; i < 500; ++i) {
            const auto upper = [&] {
                const double z = u(), phi = 7 * u(), r = std::sqrt(1 - z * z);
                return Vec3{r * std::cos(phi), r * std::sin(phi), z};
            };
            const Reflection r = reflection({0, 0, 1}, upper(), upper());
            const auto lanes = eval(surface.lanes(0), surface.slopes(), surface.attenuation(), r);
            for (std::size_t w = 0; w < wavelengths.size() && w < kLanes; ++w) {
                const auto p = parameters_at(*paint, wavelengths[w]);
                const auto f = eval(p, paint->slopes, paint->attenuation, r);
                const auto lane = [w](const Lanes& x) { return static_cast<double>(x.get(w)); };
                const double scale = f.facet.a();
                // The exponential's argument is exact to 2⁻²⁴ of itself; beyond e^{−40} of the
                // peak that matters to nobody.
                if (r.tan2_theta / (2 * p.sigma * p.sigma) > 40) continue;
                CHECK(std::abs(lane(lanes.facet.a()) - f.facet.a()) <= 1e-5 * scale);
                CHECK(std::abs(lane(lanes.facet.b()) - f.facet.b()) <= 1e-5 * scale);
                CHECK(std::abs(lane(lanes.facet.re) - f.facet.re) <= 1e-5 * scale);
                CHECK(std::abs(lane(lanes.facet.im) - f.facet.im) <= 1e-5 * scale);
                CHECK(lane(lanes.volume) == Approx(f.volume).epsilon(1e-5).margin(1e-9));
            }
        }
    }
}
