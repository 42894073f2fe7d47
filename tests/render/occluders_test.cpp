// occluders_test.cpp — directions toward what hides the sky.
//
// Expected numbers: the form factor of a rectangle seen from a small level patch before it (Howell, A
// Catalog of Radiation Heat Transfer Configuration Factors, B-4).
// SPDX-License-Identifier: Apache-2.0
#include "render/occluders.h"

#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kOne{550};

// Ground before a wall, the sky's map beginning at an azimuth that is no edge of cells.
PreparedScene before_wall(const Material& paint) {
    return PreparedScene(corner_scene(), {0, 0}, {paint},
                         sample_sky(reference::uniform_sky(1), kOne, 45, 72), kOne);
}

// What a square of the picture shows that sees nothing but ground about (x, 0, z), 2 cm wide.
std::vector<std::optional<Hit>> ground_at(const Accel& accel, double x, double z) {
    std::vector<std::optional<Hit>> seen;
    for (int i = 0; i < Occluders::kSquare * Occluders::kSquare; ++i) {
        const double u = i % Occluders::kSquare, v = i / Occluders::kSquare;
        const Vec3 above{x + 0.02 * (u / 15 - 0.5), 0.5, z + 0.02 * (v / 15 - 0.5)};
        seen.push_back(accel.intersect(above - accel.center(), {0, -1, 0}));
    }
    return seen;
}

// Of a level patch at distance c before the middle of a wall of height 1 that reaches 1 to each side.
double wall_form_factor(double c) {
    const double far = std::sqrt(c * c + 1);
    return (std::atan(1 / c) - c / far * std::atan(1 / far)) / kPi;
}

}  // namespace

TEST_CASE("Occluders: directions lead to a wall, three times as many as by chance") {
    const PreparedScene scene = before_wall(black_paint());
    const Accel& accel = scene.impl().accel;
    const SkyDome& dome = scene.impl().sky.dome();
    const auto seen = ground_at(accel, 0.4, 1.5);
    Occluders occluders(scene.impl(), 16, 16);
    CHECK(occluders.find(3, 3) == nullptr);
    CHECK(occluders.look(0, 0, seen) > 1000);
    REQUIRE(occluders.find(3, 3) != nullptr);
    // 4096 points of a grid, drawn by the density and evenly over the dome.
    const Hit& from = *seen[136];
    const auto hidden = [&](const DomePoint& p) {
        const Vec3 w = direction_of(p, dome.first_azimuth());
        return accel.occluded(from.leave(w), w) ? 1.0 : 0.0;
    };
    double drawn = 0, even = 0, back = 0;
    for (int i = 0; i < 64; ++i)
        for (int j = 0; j < 64; ++j) {
            const double u = (i + 0.5) / 64, v = (j + 0.5) / 64;
            const SkyDensity::Draw draw = occluders.find(3, 3)->draw(u, v);
            drawn += hidden(draw.point) / 4096;
            even += hidden({u, 2 * kPi * v}) / 4096;
            // The density over all directions, from an even cover.
            back += occluders.find(3, 3)->pdf({u, 2 * kPi * v}) * 2 * kPi / 4096;
        }
    CAPTURE(drawn, even);
    CHECK(drawn > 3 * even);
    // Two thirds go by what was met hidden (kDefence), less what its cells reach beyond the edges.
    CHECK(drawn > 0.4);
    CHECK(back == Approx(1).epsilon(0.02));
}

TEST_CASE("Occluders: none where all sky is free, much is hidden, lobes are sharp or it is night") {
    const auto found = [](const PreparedScene& scene, double z) {
        Occluders occluders(scene.impl(), 40, 40);
        // The square in the middle; others know nothing of it.
        occluders.look(1, 1, ground_at(scene.impl().accel, 0.1, z));
        CHECK(occluders.find(15, 16) == nullptr);
        CHECK(occluders.find(33, 16) == nullptr);
        return occluders.find(16, 31) != nullptr;
    };
    CHECK(found(before_wall(black_paint()), 1.5));
    CHECK(found(before_wall(lambertian(0.5)), 1.5));
    CHECK(!found(before_wall(black_paint()), 0.1));
    CHECK(!found(before_wall(green_paint()), 1.5));
    const PreparedScene night(corner_scene(), {0, 0}, {black_paint()},
                              sample_sky(reference::uniform_sky(0), kOne, 45, 72), kOne);
    CHECK(!found(night, 1.5));
    const PreparedScene open(panel_scene(), {0}, {black_paint()},
                             sample_sky(reference::uniform_sky(1), kOne, 45, 72), kOne);
    CHECK(!found(open, 0.1));
}

TEST_CASE("Occluders: matte ground loses a wall's form factor, with less error than without",
          "[render]") {
    constexpr double kAlbedo = 0.6, kDistance = 1.5;
    const PreparedScene scene = before_wall(lambertian(kAlbedo));
    const Camera camera = look_at({0, 0, kDistance}, 30, 180, 0.01);
    RenderSettings settings;
    settings.width = settings.height = 16, settings.spp = 256, settings.max_depth = 1;
    const double right = kAlbedo * (1 - wall_form_factor(kDistance));
    std::array<double, 2> error;
    for (int table : {0, 1}) {
        settings.sky_table = table == 1;
        const Film film = render(scene, camera, settings).film;
        const PictureMean found = picture_mean(film, 0);
        CAPTURE(table, found.mean.s0, found.error.s0, right);
        // The mean of 256 pixels: false alarms 6e-5; 3e-4: the map's cells, and F over 2 cm.
        CHECK(std::abs(found.mean.s0 - right) < 4 * found.error.s0 + 3e-4 * right);
        CHECK(found.mean.s1 == near(0, 1e-6));
        double squares = 0;
        for (std::size_t i = 0; i < film.pixel_count(); ++i)
            squares += static_cast<double>(film.at(i, 0).covariance[0]);
        error[static_cast<std::size_t>(table)] = std::sqrt(squares / 256);
    }
    CAPTURE(error[0], error[1]);
    CHECK(error[1] < 0.5 * error[0]);
}
