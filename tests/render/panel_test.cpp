// panel_test.cpp — a flat panel under a smooth sky, seen in ways that must agree.
// panel_accuracy_test.cpp has the numbers.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/frame.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kWavelengths{440, 550, 600};

Film render_panel(const Material& paint, const Sky& sky, const Camera& camera, std::uint32_t spp,
                  std::vector<double> wavelengths = kWavelengths,
                  Lighting lighting = Lighting::kBoth, Sampling sampling = Sampling::kSobol) {
    RenderSettings settings;
    settings.width = settings.height = 8;
    settings.spp = spp;
    settings.lighting = lighting;
    settings.sampling = sampling;
    settings.sky_table = false;  // means over pixels are judged here, so their errors must be apart
    const PreparedScene prepared(panel_scene(), {0}, {paint}, sky, std::move(wavelengths));
    return render(prepared, camera, settings).film;
}

}  // namespace

TEST_CASE("Panel: sky samples, surface samples, both and independent numbers agree", "[render]") {
    const Sky sky = sample_sky(smooth_sky(), kWavelengths, 90, 360);
    const Camera camera = look_at({0, 0, 0}, 40, 70, 0.05);
    const auto estimate = [&](Lighting lighting, Sampling sampling) {
        return picture_mean(
            render_panel(green_paint(), sky, camera, 2048, kWavelengths, lighting, sampling), 0);
    };
    const PictureMean both = estimate(Lighting::kBoth, Sampling::kSobol);
    for (const auto& [lighting, sampling] : {std::pair{Lighting::kLightSamples, Sampling::kSobol},
                                             std::pair{Lighting::kSurfaceSamples, Sampling::kSobol},
                                             std::pair{Lighting::kBoth, Sampling::kIndependent}}) {
        const PictureMean alone = estimate(lighting, sampling);
        const auto z = [&](double a, double ea, double b, double eb) {
            return std::abs(a - b) / std::hypot(ea, eb);
        };
        // |z| < 4: false alarms 12 × 6e-5.
        CHECK(z(alone.mean.s0, alone.error.s0, both.mean.s0, both.error.s0) < 4);
        CHECK(z(alone.mean.s1, alone.error.s1, both.mean.s1, both.error.s1) < 4);
        CHECK(z(alone.mean.s2, alone.error.s2, both.mean.s2, both.error.s2) < 4);
        CHECK(z(alone.mean.s3, alone.error.s3, both.mean.s3, both.error.s3) < 4);
    }
}

TEST_CASE("Panel: one wavelength alone is what it is among others", "[render]") {
    const Sky sky = sample_sky(smooth_sky(), kWavelengths, 90, 360);
    const Camera camera = look_at({0, 0, 0}, 50, 70, 0.05);
    const PictureMean among = picture_mean(render_panel(black_paint(), sky, camera, 2048), 2);
    const PictureMean alone =
        picture_mean(render_panel(black_paint(), sky, camera, 2048, {600}), 0);
    const double error = std::hypot(among.error.s0, alone.error.s0);
    CHECK(std::abs(among.mean.s0 - alone.mean.s0) < 4 * error);  // false alarms 1e-4
    CHECK(error < 2e-3 * alone.mean.s0);
}

TEST_CASE("Lambert: a free white-ish panel under a uniform sky L shows a·L", "[render]") {
    const Sky sky = sample_sky(reference::uniform_sky(2.0), kWavelengths, 10, 10);
    const Film film = render_panel(lambertian(0.4), sky, look_at({0, 0, 0}, 40, 0, 0.05), 64);
    const PictureMean found = picture_mean(film, 1);
    CHECK(found.mean.s0 == near(0.8, std::max(4 * found.error.s0, 1e-6)));
    CHECK(found.error.s0 < 1e-3);
    CHECK(std::abs(found.mean.s1) + std::abs(found.mean.s2) + std::abs(found.mean.s3) == 0);
}

TEST_CASE("Camera roll: a rolled camera sees AoLP turned by −r and the same DoLP", "[render]") {
    const Sky sky = sample_sky(smooth_sky(), kWavelengths, 90, 360);
    const Camera camera = look_at({0, 0, 0}, 60, 70, 0.05);
    Camera rolled = camera;
    const double roll = to_radians(30);
    rolled.right = std::cos(roll) * camera.right + std::sin(roll) * camera.up;
    rolled.up = std::cos(roll) * camera.up - std::sin(roll) * camera.right;
    const Stokes<double> a = picture_mean(render_panel(green_paint(), sky, camera, 1024), 1).mean;
    const Stokes<double> b = picture_mean(render_panel(green_paint(), sky, rolled, 1024), 1).mean;
    CHECK(dolp(b) == Approx(dolp(a)).epsilon(1e-4));
    CHECK(to_degrees(std::remainder(aolp(a) - roll - aolp(b), kPi)) == near(0, 0.02));
}
