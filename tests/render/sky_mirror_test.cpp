// sky_mirror_test.cpp — signs that a mirrored or flipped sky cannot pass.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/frame.h"
#include "malus/scene/clear_sky.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kRed{600};
const Vec3 kSunAt = direction(to_radians(60), to_radians(37));

// The sun at an azimuth that is no multiple of 90°, over ground that reflects little.
Sky clear_sky() {
    ClearSky model;
    model.sun_zenith = to_radians(60), model.sun_azimuth = to_radians(37);
    model.ground_albedo = 0.1;
    Sky sky = make_clear_sky(model, kRed, 90, 360);
    sky.sun.reset();
    return sky;
}

Stokes<double> in_meridian_frame(const SkyDome& dome, const Vec3& w) {
    return measured_in(Beam<double>{dome.radiance(w, 0), fixed_frame(w)}, meridian_frame(w)).stokes;
}

double angle_between(double a, double b) {
    return std::abs(std::remainder(a - b, kPi));
}

}  // namespace

TEST_CASE("Clear sky: on both sides of the sun's meridian light is polarized across the plane") {
    // Light scattered once: perpendicular to sun and view. At 600 nm, 60° to 120° from the sun, light
    // scattered more often turns it by less than 3°.
    const SkyDome dome(clear_sky(), kRed);
    int compared = 0;
    for (double zenith : {20.0, 45.0, 70.0})
        for (double azimuth = 2; azimuth < 360; azimuth += 23) {
            const Vec3 w = direction(to_radians(zenith), to_radians(azimuth));
            if (std::abs(dot(w, kSunAt)) > 0.5) continue;
            const reference::Stokes once = polarized_along(cross(kSunAt, w), w, 1, 1, 0);
            const Stokes<double> S = in_meridian_frame(dome, w);
            CAPTURE(zenith, azimuth);
            CHECK(angle_between(aolp(S), 0.5 * std::atan2(once[2], once[1])) < to_radians(3));
            CHECK(dolp(S) > 0.3);
            ++compared;
        }
    CHECK(compared >= 20);
}

TEST_CASE("Clear sky: a mirror shows its polarization turned as Fresnel and the camera have it",
          "[render]") {
    // From the meridian frame at the specular direction into the plane of incidence, through the
    // facet, into the camera's frame: by the reference's full matrices.
    const Sky sky = clear_sky();
    const SkyDome dome(sky, kRed);
    Material mirror = single_row("mirror", {1.5, 2.0, 1, 1e-5, 1, 0, 0, 0});
    mirror.rows[0].wavelength_nm = 600;
    const PreparedScene scene(panel_scene(), {0}, {mirror}, sky, kRed);
    for (const auto& [zenith, azimuth] :
         {std::pair{30.0, 20.0}, {50.0, 110.0}, {65.0, 263.0}, {40.0, 310.0}}) {
        const Camera camera = look_at({0, 0, 0}, zenith, azimuth, 0.05);
        RenderSettings settings;
        settings.width = settings.height = 4;
        settings.max_depth = 1;
        const Stokes<double> S = picture_mean(render(scene, camera, settings).film, 0).mean;

        const Vec3 wo = -camera.forward, wi{-wo.x, wo.y, -wo.z};
        const Vec3 s = normalize(cross(-wi, wo));
        const reference::Mueller M = reference::product(
            reference::rotation(wo, s, camera.right),
            reference::product(
                reference::facet(reference_paint(mirror, 600), std::cos(to_radians(zenith))),
                reference::rotation(-wi, reference::meridian_axis(wi), s)));
        const Stokes<double> L = in_meridian_frame(dome, wi);
        const reference::Stokes expected = reference::multiply(M, {L.s0, L.s1, L.s2, L.s3});
        const reference::Stokes flipped = reference::multiply(M, {L.s0, L.s1, -L.s2, L.s3});
        CAPTURE(zenith, azimuth);
        CHECK(S.s0 == near(expected[0], 1e-3 * expected[0]));
        CHECK(S.s1 == near(expected[1], 1e-3 * expected[0]));
        CHECK(S.s2 == near(expected[2], 1e-3 * expected[0]));
        CHECK(S.s3 == near(expected[3], 1e-3 * expected[0]));
        CHECK(std::hypot(flipped[1] - expected[1], flipped[2] - expected[2],
                         flipped[3] - expected[3]) > 0.05 * expected[0]);
    }
}
