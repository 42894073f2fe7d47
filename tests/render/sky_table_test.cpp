// sky_table_test.cpp — the open sky known beside the paths: no bias, true error bars, less noise.
//
// Expected numbers are quadratures (support/reference.h) and renders without the table.
// SPDX-License-Identifier: Apache-2.0
#include "render/sky_table.h"
#include "malus/io/gltf.h"
#include "malus/io/sky_file.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/scores.h"

using namespace malus;

namespace {

const std::vector<double> kThree{440, 550, 600};

// A perspective view from (zenith, azimuth), 1.5 m away.
Camera near_view(double zenith_deg, double azimuth_deg, const Vec3& target, double yfov_deg) {
    Camera camera = look_at(target, zenith_deg, azimuth_deg, 1);
    camera.projection = Projection::kPerspective;
    camera.yfov = to_radians(yfov_deg);
    camera.position = target - 1.5 * camera.forward;
    return camera;
}

RenderSettings small() {
    RenderSettings settings;
    settings.width = 16, settings.height = 12, settings.spp = 64;
    return settings;
}

PreparedScene scene_of(Scene scene, const Material& paint) {
    const std::vector<int> paints(scene.instances.size(), 0);
    return PreparedScene(std::move(scene), paints, {paint},
                         sample_sky(smooth_sky(), kThree, 180, 720), kThree);
}

// As shipped, with the camera it has, under a clear sky.
struct Target {
    Camera camera;
    PreparedScene scene;
};
Target target_a(const std::vector<double>& nm) {
    Scene scene = read_gltf(MALUS_SOURCE_DIR "/scenes/target_a.glb");
    const std::vector<Material> paints{green_paint(), black_paint()};
    const std::vector<int> of = assign_paints(scene, {}, paints);
    const Camera camera = scene.cameras.at(0);
    return {camera, PreparedScene(std::move(scene), of, paints,
                                  read_sky(MALUS_SOURCE_DIR "/skies/rayleigh_60.exr"), nm)};
}

double median(std::vector<double> x) {
    std::nth_element(x.begin(), x.begin() + std::ssize(x) / 2, x.end());
    return x[x.size() / 2];
}

// Of all pixels and wavelengths: the median of SE(S0)/S0.
double median_error(const Film& film) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < film.pixel_count(); ++i)
        for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w)
            if (film.coverage[i] == 1) errors.push_back(relative_stderr_s0(film.at(i, w)));
    return median(std::move(errors));
}

// Of a panel, or of a surface that is nowhere flat.
Vec3 normal_at(bool face, int x, int y) {
    return face ? Vec3{0, 1, 0} : normalize(Vec3{0.002 * x - 0.1, 1, 0.2 - 0.003 * y});
}
void look_at_normals(bool face, const RenderSettings& settings, SkyTable& table) {
    for (int y = 0; y < settings.height; ++y)
        for (int x = 0; x < settings.width; ++x) table.look(x, y, 0, normal_at(face, x, y));
    table.settle();
}

}  // namespace

TEST_CASE("Sky table: on an open panel the quadrature, with a tenth of the error", "[render]") {
    for (const Material* paint : {&green_paint(), &black_paint()}) {
        const PreparedScene scene = scene_of(panel_scene(), *paint);
        RenderSettings settings = small();
        const Camera camera = look_at({0, 0, 0}, 45, 20, 1e-4);
        const Film with = render(scene, camera, settings).film;
        settings.sky_table = false;
        const Film without = render(scene, camera, settings).film;
        for (std::size_t w = 0; w < kThree.size(); ++w) {
            const PixelStokes right = panel_reference(*paint, kThree[w], camera);
            CAPTURE(paint->name, kThree[w]);
            // All pixels share the table's error: one score each of S0, S1, S2 at 18 places;
            // |t| > 6 with 7 degrees of freedom: false alarms 1 %. 2e-4: the map's cells.
            for (const Quantity& q : quantities()) {
                if (q.polarization || q.name == std::string("S3")) continue;
                const PixelStokes& found = with.at(100, w);
                CAPTURE(q.name, q.value(found), q.value(right));
                CHECK(std::abs(q.off(found, right)) < 6 * q.error(found) + 2e-4 * right.mean.s0);
            }
            // Variances of S0, S1 and S2: a frame or sign that differs between T and X would show.
            for (std::size_t e : {0u, 3u, 5u})
                CHECK(with.at(100, w).covariance[e] < 0.01f * without.at(100, w).covariance[e]);
        }
    }
}

TEST_CASE("Sky table: beside a wall over 400 seeds z-scores spread as errors say", "[render]") {
    // Ground before a wall: some sky is hidden, light comes from the wall, and views are not the
    // node's. One pixel: those of a node have an error in common.
    for (const Material* paint : {&green_paint(), &black_paint()}) {
        const PreparedScene scene = scene_of(corner_scene(), *paint);
        const Camera camera = near_view(60, 160, {0, 0, 0.2}, 1.5);
        RenderSettings settings = small();
        settings.width = settings.height = 8;
        settings.spp = 1 << 16, settings.seed = 1u << 20, settings.sky_table = false;
        const std::size_t pixel = 1 * 8 + 4;
        const Film reference = render(scene, camera, settings).film;
        settings.spp = 256, settings.sky_table = true;
        std::vector<Film> films;
        for (settings.seed = 0; settings.seed < 400; ++settings.seed)
            films.push_back(render(scene, camera, settings).film);
        for (std::size_t w = 0; w < kThree.size(); ++w)
            for (const Quantity& q : quantities()) {
                const PixelStokes& right = reference.at(pixel, w);
                if (q.polarization && dolp(right.mean) < 0.01) continue;
                Scores scores;
                for (const Film& film : films) {
                    const PixelStokes& found = film.at(pixel, w);
                    scores.add(q.off(found, right) / std::hypot(q.error(found), q.error(right)),
                               student95(7));
                }
                CAPTURE(paint->name, kThree[w], q.name, scores.mean(), scores.deviation(),
                        scores.coverage());
                // By its own 7 degrees of freedom a pixel has scores as Student's t: √(7/5) and 95 %.
                // Where 15 neighbours say the same of its error (shared_errors.h), they have 1.02 and 97.6 %
                // (by drawing gamma variates); else something between. 400 scores know their
                // deviation to 5 %, the coverage to 1.1 %: false alarms under 1e-3 a number. The
                // reference's own error, the same in all, is seen in the mean.
                CHECK(std::abs(scores.mean()) < 0.3);
                CHECK(scores.deviation() > 1.02 * 0.83);
                CHECK(scores.deviation() < std::sqrt(7.0 / 5) * 1.17);
                CHECK(scores.coverage() > 0.95 - 0.035);
            }
    }
}

TEST_CASE("Sky table: few samples that miss hidden light do not claim to know", "[render]") {
    // Ground beside a wall at one sample a replicate: while pixels did not share their errors, some 7 %
    // of the values of S0 were off by more than six of them.
    const std::vector<double> two{440, 600};
    const PreparedScene scene(corner_scene(), {0, 1}, {black_paint(), green_paint()},
                              read_sky(MALUS_SOURCE_DIR "/skies/hazy_60.exr"), two);
    const Camera camera = look_at({0, 0.3, 0.8}, 30, 0, 1.1);
    RenderSettings settings = small();
    settings.width = settings.height = 32;
    settings.spp = 1 << 14, settings.seed = 1u << 20, settings.sky_table = false;
    const Film reference = render(scene, camera, settings).film;
    settings.spp = 8, settings.sky_table = true;
    int far = 0, count = 0;
    for (settings.seed = 0; settings.seed < 10; ++settings.seed) {
        const Film film = render(scene, camera, settings).film;
        for (std::size_t i = 0; i < film.pixel_count(); ++i)
            for (std::size_t w = 0; w < two.size(); ++w) {
                if (film.coverage[i] < 1 || film.instance[i] != 0) continue;
                const PixelStokes &found = film.at(i, w), &right = reference.at(i, w);
                const double off = std::abs(found.mean.s0 - right.mean.s0);
                const double variance = static_cast<double>(found.covariance[0]) +
                                        static_cast<double>(right.covariance[0]);
                far += off > 6 * std::sqrt(variance), ++count;
            }
    }
    CAPTURE(far, count);
    CHECK(count > 5000);
    // Student's t with 7 degrees of freedom is beyond 6 in 0.05 %; few samples of rare light are not quite
    // it.
    CHECK(far < 0.01 * count);
}

TEST_CASE("Sky table: errors stay below the light where a narrow lobe ends", "[render]") {
    // Green paint at 550 nm reflects no light but by its lobe, whose ends are 1e4 to 1e30 times darker than
    // the pixels around. An error above three times S0 leaves nothing known of DoLP either.
    const auto [camera, scene] = target_a({440, 550});
    RenderSettings settings;
    settings.width = 160, settings.height = 120, settings.spp = 16;
    int unknown = 0, count = 0;
    const Film film = render(scene, camera, settings).film;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        if (film.coverage[i] < 1) continue;
        const PixelStokes& pixel = film.at(i, 1);
        const double error = std::sqrt(static_cast<double>(pixel.covariance[0]));
        unknown += error > 3 * pixel.mean.s0, ++count;
    }
    CAPTURE(unknown, count);
    CHECK(count > 15000);
    // 31, differences that noise left nothing of; 91 where neighbours share errors as light.
    CHECK(unknown < 0.003 * count);
}

TEST_CASE("Sky table: where it is not used errors are those without it", "[render]") {
    // Pixels that use it at one wavelength and not at the other, where their light is the very same.
    const auto [camera, scene] = target_a({440, 550});
    RenderSettings settings;
    settings.width = 80, settings.height = 60, settings.spp = 16;
    const Film with = render(scene, camera, settings).film;
    settings.sky_table = false;
    const Film without = render(scene, camera, settings).film;
    const auto same = [&](std::size_t i, std::size_t w) {
        const Stokes<double>&a = with.at(i, w).mean, &b = without.at(i, w).mean;
        return a.s0 == b.s0 && a.s1 == b.s1 && a.s2 == b.s2 && a.s3 == b.s3;
    };
    int count = 0, other = 0;
    for (std::size_t i = 0; i < with.pixel_count(); ++i) {
        if (same(i, 0) || !same(i, 1)) continue;
        other += with.at(i, 1).covariance != without.at(i, 1).covariance, ++count;
    }
    CAPTURE(count, other);
    CHECK(count > 50);
    // In 4 the sky's light is below the last digit of what they reflect of their surroundings: they use the
    // table, and their light does not show it. 48 where all wavelengths share errors if one may.
    CHECK(other < 10);
}

TEST_CASE("Sky table: over 200 seeds the mean picture is that without it", "[render]") {
    const auto [camera, scene] = target_a({440, 600});
    RenderSettings settings;
    settings.width = 40, settings.height = 30, settings.spp = 16;
    // What other surfaces reflect at grazing angles has no bounded variance, and nothing to do with
    // the table.
    settings.max_depth = 1;
    constexpr int kSeeds = 200;
    // Mean over the picture of S0, S1, S2 at both wavelengths: sum and sum of squares over seeds.
    std::array<std::array<double, 6>, 2> sum{}, squares{};
    for (int table = 0; table < 2; ++table) {
        settings.sky_table = table == 1;
        for (settings.seed = 0; settings.seed < kSeeds; ++settings.seed) {
            RenderSettings run = settings;
            run.seed += table == 1 ? 7000 : 0;  // independent of each other
            const Film film = render(scene, camera, run).film;
            std::array<double, 6> mean{};
            for (std::size_t i = 0; i < film.pixel_count(); ++i)
                for (std::size_t w = 0; w < 2; ++w) {
                    const Stokes<double>& S = film.at(i, w).mean;
                    mean[3 * w] += S.s0, mean[3 * w + 1] += S.s1, mean[3 * w + 2] += S.s2;
                }
            for (std::size_t q = 0; q < 6; ++q) {
                sum[table][q] += mean[q];
                squares[table][q] += sqr(mean[q]);
            }
        }
    }
    for (std::size_t q = 0; q < 6; ++q) {
        double mean[2], variance[2];
        for (std::size_t t = 0; t < 2; ++t) {
            mean[t] = sum[t][q] / kSeeds;
            variance[t] = (squares[t][q] / kSeeds - sqr(mean[t])) / (kSeeds - 1);
        }
        CAPTURE(q, mean[0], mean[1], std::sqrt(variance[0]), std::sqrt(variance[1]));
        // Six numbers: false alarms 4e-4. And the test would see a bias of half a percent of S0.
        CHECK(std::abs(mean[1] - mean[0]) < 4 * std::sqrt(variance[0] + variance[1]));
        CHECK(4 * std::sqrt(variance[0] + variance[1]) < 0.005 * sum[0][q / 3 * 3] / kSeeds);
    }
}

TEST_CASE("Sky table: nodes of bent surfaces are for few wavelengths", "[render]") {
    // With many wavelengths it takes longer to read all nodes of a pixel than to trace its paths.
    for (const std::size_t count : {2u, 64u})
        for (const bool face : {true, false}) {
            std::vector<double> nm;
            for (std::size_t i = 0; i < count; ++i)
                nm.push_back(440 + 2.5 * static_cast<double>(i));
            const PreparedScene scene(panel_scene(), {0}, {black_paint()},
                                      sample_sky(smooth_sky(), nm, 18, 72), nm);
            const Camera camera = near_view(60, 160, {0, 0, 0}, 12);
            RenderSettings settings = small();
            settings.width = 96, settings.height = 72;
            SkyTable table(scene.impl(), camera, settings);
            look_at_normals(face, settings, table);
            CAPTURE(count, face, table.node_count());
            CHECK((table.node_count() > 0) == (face || count == 2));
        }
}

TEST_CASE("Sky table: between nodes T is the quadrature, on faces and bent surfaces", "[render]") {
    // Nodes hold quadratures, so that what is left is the interpolation's.
    const std::vector<double> two{440, 600};
    for (const Material* paint : {&green_paint(), &black_paint()})
        for (const bool face : {true, false}) {
            const PreparedScene scene(panel_scene(), {0}, {*paint},
                                      sample_sky(smooth_sky(), two, 18, 72), two);
            const Camera camera = near_view(60, 160, {0, 0, 0}, 12);
            RenderSettings settings = small();
            settings.width = 96, settings.height = 72, settings.replicates = 2;
            SkyTable table(scene.impl(), camera, settings);
            const Picture picture(camera, settings.width, settings.height);
            const auto normal = [&](int x, int y) { return normal_at(face, x, y); };
            look_at_normals(face, settings, table);
            REQUIRE(table.node_count() > 0);
            const auto quadrature = [&](const Vec3& n, const Vec3& wo, double nm) {
                return reference::panel(reference_paint(*paint, nm), n, wo,
                                        image_frame(camera, wo).x, smooth_sky(), 1e-5)
                    .value;
            };
            for (std::size_t i = 0; i < table.node_count(); ++i) {
                std::vector<float> C(4 * two.size() * 2);
                for (std::size_t w = 0; w < two.size(); ++w) {
                    const auto S = quadrature(table.node(i).n, table.node(i).wo, two[w]);
                    for (std::size_t c = 0; c < 4; ++c)
                        for (std::size_t r = 0; r < 2; ++r)
                            C[(c * two.size() + w) * 2 + r] = static_cast<float>(S[c]);
                }
                table.add(i, C.data());
                table.develop(i);
            }
            // Of S0 to S2 in what variances() of exposure.cpp takes; of S3, which it leaves out, in a
            // quarter of S0.
            std::array<double, 4> worst{};
            for (int y = 0; y < settings.height; y += 11)
                for (int x = 0; x < settings.width; x += 13) {
                    const Vec3 wo = -picture.ray(x + 0.5, y + 0.5).direction, n = normal(x, y);
                    const SkySpot spot = table.find(x, y, x + 0.5, y + 0.5, 0, n, wo);
                    REQUIRE(spot.cell >= 0);
                    std::vector<float> space;
                    const SkyTable::Corners corners = table.corners(spot.cell, x, y, space);
                    for (std::size_t w = 0; w < two.size(); ++w) {
                        const auto right = quadrature(n, wo, two[w]);
                        const double linear = std::hypot(right[1], right[2]);
                        const double bound = std::min(right[0], 100 * linear);
                        const std::array<double, 4> scale{right[0], bound, bound, 0.25 * right[0]};
                        for (std::size_t c = 0; c < 4; ++c) {
                            double T = 0;
                            for (std::size_t k = 0; k < kCorners; ++k)
                                T += static_cast<double>(spot.weight[k] *
                                                         corners[k][(c * two.size() + w) * 2]);
                            worst[c] = std::max(worst[c], std::abs(T - right[c]) / scale[c]);
                        }
                    }
                }
            CAPTURE(paint->name, face, table.node_count(), worst[0], worst[1], worst[2], worst[3]);
            for (double off : worst) CHECK(off < (face ? 1.5e-4 : 3e-4));
        }
}

TEST_CASE("Sky table: over 200 seeds flat ground near by is that without it", "[render]") {
    for (const Material* paint : {&green_paint(), &black_paint()}) {
        const PreparedScene scene = scene_of(panel_scene(), *paint);
        const Camera camera = near_view(55, 160, {0, 0, 0}, 12);
        RenderSettings settings = small();
        settings.width = 32, settings.height = 24;
        settings.spp = 1 << 14, settings.seed = 1u << 20, settings.sky_table = false;
        const Film reference = render(scene, camera, settings).film;
        settings.spp = 16, settings.sky_table = true;
        constexpr int kSeeds = 200;
        // Of a pixel in a corner of the picture, far from the middle of its cell or not: S0, S1, S2.
        const std::vector<std::size_t> pixels{0, 5, 32 * 11 + 17, 32 * 24 - 1};
        std::vector<std::array<double, 3>> sum(pixels.size() * kThree.size()), squares = sum;
        for (settings.seed = 0; settings.seed < kSeeds; ++settings.seed) {
            const Film film = render(scene, camera, settings).film;
            for (std::size_t i = 0; i < sum.size(); ++i) {
                const Stokes<double>& S = film.at(pixels[i / 3], i % 3).mean;
                const std::array<double, 3> x{S.s0, S.s1, S.s2};
                for (std::size_t c = 0; c < 3; ++c) sum[i][c] += x[c], squares[i][c] += sqr(x[c]);
            }
        }
        for (std::size_t i = 0; i < sum.size(); ++i) {
            const PixelStokes& right = reference.at(pixels[i / 3], i % 3);
            const std::array<double, 3> expected{right.mean.s0, right.mean.s1, right.mean.s2};
            constexpr std::array<std::size_t, 3> kVariance{0, 3, 5};
            for (std::size_t c = 0; c < 3; ++c) {
                const double mean = sum[i][c] / kSeeds;
                const double variance = (squares[i][c] / kSeeds - sqr(mean)) / (kSeeds - 1);
                const double error =
                    std::sqrt(variance + static_cast<double>(right.covariance[kVariance[c]]));
                CAPTURE(paint->name, pixels[i / 3], kThree[i % 3], c, mean, expected[c], error);
                // 72 numbers. The reference's error, of 7 degrees of freedom, is a third of the whole,
                // at most 0.86: false alarms some 1 %; were it all of it, 11 %.
                CHECK(std::abs(mean - expected[c]) < 5 * error);
                CHECK(error < 0.01 * right.mean.s0);
            }
        }
    }
}

TEST_CASE(
    "Sky table: a near view of open ground has a tenth of the error, a corner no more than "
    "without",
    "[render]") {
    for (const Material* paint : {&green_paint(), &black_paint()}) {
        RenderSettings settings = small();
        settings.width = 64, settings.height = 48, settings.spp = 32;
        for (bool open : {true, false}) {
            const PreparedScene scene = scene_of(open ? panel_scene() : corner_scene(), *paint);
            const Camera camera = near_view(55, 160, {0, open ? 0 : 0.1, open ? 0 : 0.2}, 12);
            settings.sky_table = true;
            const double with = median_error(render(scene, camera, settings).film);
            settings.sky_table = false;
            const double without = median_error(render(scene, camera, settings).film);
            CAPTURE(paint->name, open, with, without);
            // The other kind of C for both paints: 0.123 for green's sharp lobes, 0.038 for black's; and
            // 0.038 for black's nearest nodes alone.
            const double most = !open ? 1.0 : paint == &green_paint() ? 0.10 : 0.032;
            CHECK(with < most * without);
        }
    }
}

TEST_CASE("Sky table: a black sky lights nothing", "[render]") {
    const auto dark = [](Vec3) { return reference::Stokes{}; };
    const PreparedScene night(panel_scene(), {0}, {green_paint()}, sample_sky(dark, kThree, 4, 8),
                              kThree);
    for (const PixelStokes& pixel :
         render(night, look_at({0, 0, 0}, 45, 20, 1e-4), small()).film.stokes)
        CHECK(pixel.mean.s0 == 0);
}

TEST_CASE(
    "Sky table: a render stopped at any time and gone on with has the bits of one that was not",
    "[render]") {
    // The table is not kept: it must come out as it was, also of nodes whose pixels want no more.
    const PreparedScene scene = scene_of(corner_scene(), green_paint());
    const Camera camera = near_view(55, 160, {0, 0.1, 0.2}, 6);
    RenderSettings settings = small();
    settings.width = 40, settings.height = 30;
    settings.spp = 1u << 20, settings.target_error = 0.1;
    const RenderResult whole = render(scene, camera, settings);
    const auto [part, stops] = render_with_stops(scene, camera, settings, 20);
    CAPTURE(stops);
    CHECK(stops >= 5);
    CHECK(part.stopped_by == whole.stopped_by);
    CHECK(part.exposure.open == whole.exposure.open);
    CHECK(part.exposure.taken == whole.exposure.taken);
    CHECK((part.exposure.stokes == whole.exposure.stokes));  // too long to print
}
