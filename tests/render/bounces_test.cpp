// bounces_test.cpp — light that is reflected more than once.
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <utility>

#include "malus/core/frame.h"
#include "malus/io/gltf.h"
#include "support/agreement.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kOne{550};

// Two rectangles that light each other, for the renderer and for the reference; the detector sees
// the point p of the first.
struct Pair {
    Scene scene;
    reference::Rectangle seen, other;
    Vec3 p;
    Camera camera;
};

Pair corner(const Material& material, const Vec3& p, double view_zenith_deg) {
    const reference::Paint paint = reference_paint(material, 550);
    return {corner_scene(),
            {{-1, 0, 0}, {2, 0, 0}, {0, 0, 2}, {0, 1, 0}, paint},
            {{-1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, paint},
            p,
            look_at(p, view_zenith_deg, 160, 1e-4)};
}

// Walls 2 m × 1 m, half a metre apart; seen from between them.
Pair facing(const Material& material, double height, double view_zenith_deg) {
    const reference::Paint paint = reference_paint(material, 550);
    Pair pair{{},
              {{-1, 0, -0.25}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, paint},
              {{-1, 0, 0.25}, {2, 0, 0}, {0, 1, 0}, {0, 0, -1}, paint},
              {0.2, height, -0.25},
              look_at({0.2, height, -0.25}, view_zenith_deg, 170, 1e-4)};
    add_rectangle(pair.scene, "north", pair.seen.corner, pair.seen.edge_u, pair.seen.edge_v);
    add_rectangle(pair.scene, "south", pair.other.corner, pair.other.edge_u, pair.other.edge_v);
    pair.camera.position = pair.p - 0.2 * pair.camera.forward;
    return pair;
}

// What depth 2 adds to depth 1, pixel by pixel: both draw the same numbers, so the difference is
// the second bounce alone. Its error from the spread of 16 pixels.
struct SecondBounce {
    std::array<double, 4> value{}, error{};
};
SecondBounce second_bounce(const PreparedScene& scene, const Camera& camera, std::uint32_t spp) {
    constexpr int kPixels = 16;
    RenderSettings settings;
    settings.width = kPixels, settings.height = 1, settings.spp = spp;
    settings.max_depth = 1;
    const Film one = render(scene, camera, settings).film;
    settings.max_depth = 2;
    const Film two = render(scene, camera, settings).film;
    SecondBounce out;
    std::array<double, 4> squares{};
    for (std::size_t i = 0; i < kPixels; ++i) {
        const Stokes<double> d = two.at(i, 0).mean + -1.0 * one.at(i, 0).mean;
        const std::array<double, 4> S{d.s0, d.s1, d.s2, d.s3};
        for (std::size_t c = 0; c < 4; ++c) out.value[c] += S[c] / kPixels;
        for (std::size_t c = 0; c < 4; ++c) squares[c] += sqr(S[c]) / kPixels;
    }
    for (std::size_t c = 0; c < 4; ++c)
        out.error[c] = std::sqrt(std::max(0.0, squares[c] - sqr(out.value[c])) / (kPixels - 1));
    return out;
}

constexpr const char* kBounceColumns = "pair,samples,worst,error\n";

// Each component of the second bounce within 0.1 % of its S0, with samples enough that this is five
// standard errors (15 degrees of freedom: false alarms 2e-4 a component, four components a pair).
void compare_second_bounce(const std::string& name, const Material& paint, const Pair& pair,
                           std::ofstream& csv) {
    constexpr double kTolerance = 1e-3;
    const reference::Integral expected =
        reference::corner_second_bounce(pair.seen, pair.other, pair.p, -pair.camera.forward,
                                        pair.camera.right, smooth_sky(150), 1e-4);
    const PreparedScene scene(pair.scene, {0, 0}, {paint},
                              sample_sky(smooth_sky(150), kOne, 360, 1440), kOne);
    const double whole = expected.value[0];
    SecondBounce found;
    std::uint32_t each = 1u << 13;
    for (; each <= 1u << 19; each *= 2) {
        found = second_bounce(scene, pair.camera, kReplicates * each);
        if (5 * *std::max_element(found.error.begin(), found.error.end()) < kTolerance * whole)
            break;
    }
    double worst = 0;
    for (std::size_t c = 0; c < 4; ++c) {
        CAPTURE(name, each, c, found.value[c], expected.value[c], found.error[c] / whole);
        CHECK(5 * found.error[c] < kTolerance * whole);
        CHECK(expected.error[c] < 1e-4 * whole);
        CHECK(std::abs(found.value[c] - expected.value[c]) < kTolerance * whole);
        worst = std::max(worst, std::abs(found.value[c] - expected.value[c]) / whole);
    }
    csv << name << ',' << 16 * kReplicates * each << ',' << worst << ',' << found.error[0] / whole
        << '\n';
}

void compare_first_bounce(const Material& paint, const Pair& pair) {
    const PreparedScene scene(pair.scene, {0, 0}, {paint},
                              sample_sky(smooth_sky(150), kOne, 360, 1440), kOne);
    const reference::Integral expected =
        reference::corner_first_bounce(pair.seen, pair.other, pair.p, -pair.camera.forward,
                                       pair.camera.right, smooth_sky(150), 1e-6);
    RenderSettings settings;
    settings.width = settings.height = 4, settings.max_depth = 1;
    Agreement a{};
    for (settings.spp = 1u << 15; settings.spp <= 1u << 20; settings.spp *= 2) {
        a = agreement(as_one_pixel(render(scene, pair.camera, settings).film, 0), expected);
        if (5 * a.noise.stokes < 1e-3) break;
    }
    CAPTURE(paint.name, a.stokes, a.noise.stokes, a.reference);
    CHECK(a.reference < 1e-5);
    CHECK(5 * a.noise.stokes < 1e-3);  // false alarms under 1e-5: 112 degrees of freedom
    CHECK(a.stokes < 1e-3);
}

const Material& rough_facets() {
    static const Material paint = single_row("facets", {1.5, 0.3, 1, 0.4, 1, 0, 0.02, 0.01});
    return paint;
}
const Material& polished() {
    static const Material paint = single_row("polished", {1.4, 1.2, 1, 0.3, 0.8, 2, 0, 0});
    return paint;
}

}  // namespace

TEST_CASE("First bounce: a wall takes away the sky it hides, within 0.1 % of quadrature",
          "[render]") {
    for (const Material* paint : {&rough_facets(), &polished()}) {
        compare_first_bounce(*paint, corner(*paint, {0.2, 0, 0.3}, 40));
        compare_first_bounce(*paint, facing(*paint, 0.8, 40));
    }
}

TEST_CASE("Second bounce: within 0.1 % of an independent nested integration", "[render]") {
    std::ofstream csv(MALUS_TEST_OUTPUT "/second_bounce.csv");
    csv << kBounceColumns;
    const Material matte = lambertian(0.6);
    compare_second_bounce("corner polished", polished(), corner(polished(), {-0.1, 0, 0.5}, 55),
                          csv);
    compare_second_bounce("corner matte", matte, corner(matte, {0.3, 0, 0.1}, 20), csv);
    compare_second_bounce("facing matte", matte, facing(matte, 0.8, 40), csv);
}

TEST_CASE("Second bounce grid: rough, polished, matte and painted, corner and facing walls",
          "[.][grid]") {
    const Material matte = lambertian(0.6);
    std::ofstream csv(MALUS_TEST_OUTPUT "/second_bounce_grid.csv");
    csv << kBounceColumns;
    // Between the walls the detector looks up, so that mirror-like lobes lead to the sky, too.
    for (const Material* paint :
         {&rough_facets(), &polished(), &std::as_const(matte), &green_paint(), &black_paint()}) {
        compare_second_bounce("corner " + paint->name, *paint, corner(*paint, {0.2, 0, 0.3}, 40),
                              csv);
        compare_second_bounce("facing " + paint->name, *paint, facing(*paint, 0.35, 125), csv);
    }
}

TEST_CASE("Corner: a wavelength alone is what it is among others, where volume light is clamped",
          "[render]") {
    // Green paint at 600 nm has ρv < 0: at grazing views its volume light lives near the normal
    // only. Ground of it beside a matte wall.
    const std::vector<double> two{440, 600};
    const Sky sky = sample_sky(smooth_sky(150), two, 90, 360);
    Material wall = lambertian(0.9);
    RenderSettings settings;
    settings.width = settings.height = 8;
    settings.spp = 2048;
    const Camera camera = look_at({0.2, 0, 0.3}, 78, 90, 1e-4);
    const auto bounce = [&](const std::vector<double>& wavelengths) {
        const PreparedScene prepared(corner_scene(), {0, 1}, {green_paint(), wall}, sky,
                                     wavelengths);
        return picture_mean(render(prepared, camera, settings).film, wavelengths.size() - 1);
    };
    const PictureMean alone = bounce({600}), among = bounce(two);
    // False alarms 1e-4.
    CHECK(std::abs(alone.mean.s0 - among.mean.s0) < 4 * std::hypot(alone.error.s0, among.error.s0));
    settings.max_depth = 1;
    CHECK(alone.mean.s0 > 1.02 * bounce({600}).mean.s0);
}

TEST_CASE("Sphere with a hole: every depth is the geometric series", "[render]") {
    // Area fraction f is open; a uniform sky L shines in: a f L Σ_{k<d} (a(1−f))^k everywhere
    // inside, since every point of a sphere sees every other under the same form factor.
    const double a = 0.7, f = 0.1, L = 2;
    const Scene scene = read_gltf(MALUS_SOURCE_DIR "/scenes/sphere_with_hole.glb");
    REQUIRE(scene.cameras.size() == 1);
    const Camera camera = scene.cameras[0];
    const Sky sky = sample_sky(reference::uniform_sky(L), kOne, 20, 40);
    const PreparedScene prepared(scene, {0}, {lambertian(a)}, sky, kOne);
    RenderSettings settings;
    settings.width = settings.height = 16;
    settings.spp = 4096;
    double series = 0;
    for (int depth = 1; depth <= 8; ++depth) {
        series += std::pow(a * (1 - f), depth - 1);
        if (depth == 4 || depth == 6 || depth == 7) continue;
        settings.max_depth = depth;
        const RenderResult result = render(prepared, camera, settings);
        const PictureMean found = picture_mean(result.film, 0);
        CAPTURE(depth, found.mean.s0, found.error.s0);
        // 256 × 128 facets stand for the sphere: the hole's edge is a polygon, its area and the
        // chords are off by up to (2π/256)²/6 = 1e-4 a bounce.
        const double expected = a * f * L * series;
        CHECK(std::abs(found.mean.s0 - expected) < 4 * found.error.s0 + 3e-4 * depth * expected);
        CHECK(found.error.s0 < 2e-3 * expected);
        CHECK(result.refused == 0);
        // Everywhere: the left, middle and right thirds of the picture, too.
        for (int third = 0; third < 3; ++third) {
            double sum = 0;
            for (std::size_t i = 0; i < result.film.pixel_count(); ++i)
                if (static_cast<int>(i % 16) * 3 / 16 == third) sum += result.film.at(i, 0).mean.s0;
            const double columns = third == 1 ? 5 : third == 0 ? 6 : 5;
            CHECK(sum / (16 * columns) == Approx(expected).epsilon(0.01));
        }
    }
}
