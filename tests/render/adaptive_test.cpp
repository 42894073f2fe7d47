// adaptive_test.cpp — renders that stop by their error, by request, and go on.
//
// True errors are deviations from a picture of the same scene with far more samples and another seed.
// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>

#include "malus/io/gltf.h"
#include "malus/io/sky_file.h"
#include "malus/render/render.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;

namespace {

const std::vector<double> kTwo{440, 600};

// A shipped target under a shipped sky, sun included.
PreparedScene shipped(const std::string& target, Attenuation attenuation = Attenuation::kNone) {
    Scene scene = read_gltf(MALUS_SOURCE_DIR "/scenes/" + target + ".glb");
    std::vector<Material> paints{green_paint(), black_paint()};
    for (Material& paint : paints) paint.attenuation = attenuation;
    const std::vector<int> of = assign_paints(scene, {}, paints);
    return PreparedScene(std::move(scene), of, paints,
                         read_sky(MALUS_SOURCE_DIR "/skies/rayleigh_60.exr"), kTwo);
}

Camera first_camera(const PreparedScene& scene) {
    return scene.scene().cameras.at(0);
}

// The pixel's largest deviation from the reference, as pixel_error() measures it.
double true_error(const Film& film, const Film& reference, std::size_t pixel) {
    double largest = 0;
    for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w) {
        const Stokes<double>&S = film.at(pixel, w).mean, &R = reference.at(pixel, w).mean;
        if (!(R.s0 > 0)) continue;
        largest = std::max({largest, std::abs(S.s0 / R.s0 - 1), std::abs(dolp(S) - dolp(R))});
    }
    return largest;
}

// Root mean square of the least 95 %.
double rms_of_most(std::vector<double> errors) {
    std::sort(errors.begin(), errors.end());
    errors.resize(errors.size() * 95 / 100);
    double squares = 0;
    for (double e : errors) squares += e * e;
    return std::sqrt(squares / static_cast<double>(errors.size()));
}

double rms_of_most(const Film& film, const Film& reference) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < film.pixel_count(); ++i)
        if (reference.coverage[i] > 0) errors.push_back(true_error(film, reference, i));
    return rms_of_most(std::move(errors));
}

// What the picture's own error bars say of it.
double own_rms_of_most(const Film& film) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < film.pixel_count(); ++i)
        if (const auto error = pixel_error(film, i)) errors.push_back(*error);
    return rms_of_most(std::move(errors));
}

double mean_samples(const Film& film) {
    double sum = 0;
    for (std::uint32_t n : film.samples) sum += n;
    return sum / static_cast<double>(film.pixel_count());
}

bool same(const RenderResult& a, const RenderResult& b) {
    const Exposure &x = a.exposure, &y = b.exposure;
    return x.stokes == y.stokes && x.kept == y.kept && x.taken == y.taken &&
           x.covered == y.covered && x.distance == y.distance && x.instance == y.instance &&
           x.votes == y.votes && a.film.samples == b.film.samples;
}

}  // namespace

TEST_CASE("Adaptive: over 200 seeds the mean picture is that of fixed sampling", "[render]") {
    const PreparedScene scene = shipped("target_a");
    const Camera camera = first_camera(scene);
    constexpr int kSeeds = 200;
    constexpr double kTarget = 0.1;
    RenderSettings settings;
    settings.width = 20, settings.height = 15;
    // Per pixel, wavelength and component S0 to S2: sum and sum of squares over the seeds; and the
    // same of the mean over the surface's pixels of each component relative to the pixel's S0.
    struct Sums {
        std::vector<double> sum, squares;
        double samples = 0;
    };
    const std::size_t values = 20 * 15 * 2 * 3;
    std::vector<std::vector<double>> mean_of_picture[2];
    Sums sums[2];
    double most_over_least = HUGE_VAL;
    const Film scale = [&] {  // what to divide by: any picture will do, if it is the same for both
        RenderSettings many = settings;
        many.spp = 4096, many.seed = 1000;
        return render(scene, camera, many).film;
    }();
    double surface = 0;
    for (float a : scale.coverage) surface += a > 0;
    for (int adaptive = 0; adaptive < 2; ++adaptive) {
        Sums& s = sums[adaptive];
        s.sum.assign(values, 0), s.squares.assign(values, 0);
        for (settings.seed = 0; settings.seed < kSeeds; ++settings.seed) {
            settings.target_error = adaptive ? kTarget : 0;
            settings.spp = adaptive ? 1u << 20 : 128;
            // Other seeds, so that the two are independent.
            RenderSettings run = settings;
            run.seed += adaptive ? 5000 : 0;
            const Film film = render(scene, camera, run).film;
            s.samples += mean_samples(film) / kSeeds;
            const auto [least, most] =
                std::minmax_element(film.samples.begin(), film.samples.end());
            if (adaptive) most_over_least = std::min(most_over_least, 1.0 * *most / *least);
            std::vector<double> picture(6);
            for (std::size_t v = 0; v < values; ++v) {
                const std::size_t i = v / 6, w = v / 3 % 2, c = v % 3;
                const Stokes<double>& S = film.at(i, w).mean;
                const double s0 = scale.at(i, w).mean.s0;
                if (!(scale.coverage[i] > 0) || !(s0 > 0)) continue;
                const double x = (c == 0 ? S.s0 : c == 1 ? S.s1 : S.s2) / s0;
                s.sum[v] += x, s.squares[v] += x * x;
                picture[v % 6] += x / surface;
            }
            mean_of_picture[adaptive].push_back(picture);
        }
    }
    // Work went where the error is: the most samples in a pixel are many times the fewest.
    CAPTURE(sums[1].samples);
    CHECK(sums[1].samples < 128);
    CHECK(most_over_least > 3);

    // Bias of the picture's mean, for S0, S1, S2 at two wavelengths: within 4 standard errors (false
    // alarms 4e-4) and below a tenth of the target.
    for (std::size_t q = 0; q < 6; ++q) {
        double mean[2], variance[2];
        for (int a = 0; a < 2; ++a) {
            double sum = 0, squares = 0;
            for (const auto& picture : mean_of_picture[a])
                sum += picture[q], squares += sqr(picture[q]);
            mean[a] = sum / kSeeds;
            variance[a] = (squares / kSeeds - sqr(mean[a])) / (kSeeds - 1);
        }
        CAPTURE(q, mean[0], mean[1]);
        CHECK(std::abs(mean[1] - mean[0]) < 4 * std::sqrt(variance[0] + variance[1]));
        CHECK(std::abs(mean[1] - mean[0]) < 0.1 * kTarget);
    }
    // Pixel by pixel: what the squares of the differences have beyond what chance gives them, over
    // the 95 % of the pixels of least chance.
    std::vector<std::pair<double, double>> chance_and_excess;
    for (std::size_t v = 0; v < values; ++v) {
        double mean[2], chance = 0;
        for (int a = 0; a < 2; ++a) {
            mean[a] = sums[a].sum[v] / kSeeds;
            chance += (sums[a].squares[v] / kSeeds - sqr(mean[a])) / (kSeeds - 1);
        }
        if (chance > 0) chance_and_excess.push_back({chance, sqr(mean[1] - mean[0]) - chance});
    }
    std::sort(chance_and_excess.begin(), chance_and_excess.end());
    chance_and_excess.resize(chance_and_excess.size() * 95 / 100);
    double excess = 0;
    for (const auto& each : chance_and_excess) excess += each.second;
    const double bias =
        std::sqrt(std::max(0.0, excess / static_cast<double>(chance_and_excess.size())));
    std::printf("adaptive: bias %.2g of S0 a pixel (rms)\n", bias);
    CAPTURE(bias);
    CHECK(bias < 0.1 * kTarget);
}

TEST_CASE("Target error: the true error is what was asked for, or down to a third of it",
          "[render]") {
    for (const char* target : {"target_a", "target_b"}) {
        const PreparedScene scene = shipped(target);
        const Camera camera = first_camera(scene);
        RenderSettings settings;
        settings.width = 32, settings.height = 24;
        RenderSettings many = settings;
        many.spp = 1u << 20, many.target_error = 0.01, many.seed = 1;
        const Film reference = render(scene, camera, many).film;
        settings.spp = 1u << 20, settings.target_error = 0.04;
        const RenderResult result = render(scene, camera, settings);
        const double error = rms_of_most(result.film, reference);
        CAPTURE(target, error, mean_samples(result.film));
        CHECK(result.stopped_by == StoppedBy::kTargetError);
        CHECK(error_of_most(result.film) <= 0.04);
        CHECK(error < 0.04);
        CHECK(error > 0.04 / 3);
    }
}

TEST_CASE("Target error: 0.01, 0.003 and 0.001 on both targets against a reference", "[grid]") {
    std::ofstream table(MALUS_TEST_OUTPUT "/target_error.md");
    table << "| scene | attenuation | asked | true error, rms of 95 % | of what was asked | the "
             "reference's own | "
             "samples a pixel | time, s |\n|---|---|---|---|---|---|---|---|\n";
    struct Subject {
        const char* target;
        Attenuation attenuation;
    };
    for (const Subject& subject :
         {Subject{"target_a", Attenuation::kTorranceSparrow},
          Subject{"target_b", Attenuation::kTorranceSparrow},
          Subject{"target_a", Attenuation::kNone}, Subject{"target_b", Attenuation::kNone}}) {
        const bool bounded = subject.attenuation != Attenuation::kNone;
        const char* target = subject.target;
        const PreparedScene scene = shipped(target, subject.attenuation);
        const Camera camera = first_camera(scene);
        RenderSettings settings;
        settings.width = 24, settings.height = 18, settings.spp = 1u << 27;
        RenderSettings many = settings;
        many.spp = 1u << 18, many.seed = 1;
        const Film reference = render(scene, camera, many).film;
        const double own = own_rms_of_most(reference);
        std::map<double, double> samples;
        for (double asked : {0.03, 0.01, 0.003, 0.001}) {
            settings.target_error = asked;
            const auto start = std::chrono::steady_clock::now();
            const Film film = render(scene, camera, settings).film;
            const double seconds =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            // The reference's own error adds to what is seen of the picture's.
            const double seen = rms_of_most(film, reference);
            const double rms = std::sqrt(std::max(0.0, sqr(seen) - sqr(own)));
            samples[asked] = mean_samples(film);
            table << "| " << target << " | " << (bounded ? "Torrance-Sparrow" : "none") << " | "
                  << asked << " | " << rms << " | " << rms / asked << " | " << own << " | "
                  << samples[asked] << " | " << seconds << " |" << std::endl;
            CAPTURE(target, asked, rms, samples[asked], seconds);
            CHECK(rms < asked);
            CHECK(rms > asked / 3);
        }
        // Half of what E⁻² would take, once more from 0.01 to 0.001 with attenuation. Without it
        // the light of grazing surfaces has no bounded variance. Target A still keeps to E⁻² (78
        // times); target B, of smooth normals, does not (142; tests/README.md).
        CAPTURE(target, bounded, samples[0.03], samples[0.01], samples[0.003], samples[0.001]);
        CHECK(samples[0.003] < 0.5 * 100 * samples[0.03]);
        if (bounded || std::string(target) == "target_a")
            CHECK(samples[0.001] < (bounded ? 0.5 : 1) * 100 * samples[0.01]);
    }
}

TEST_CASE(
    "Going on: a render stopped at any time and gone on with has the bits of one that was not",
    "[render]") {
    const PreparedScene scene = shipped("target_a");
    const Camera camera = first_camera(scene);
    for (double target : {0.0, 0.1}) {
        RenderSettings settings;
        settings.width = 37, settings.height = 23, settings.seed = 3;
        settings.spp = target > 0 ? 1u << 20 : 136;
        settings.target_error = target;
        const RenderResult whole = render(scene, camera, settings);
        const auto [part, stops] = render_with_stops(scene, camera, settings, 30);
        CAPTURE(target, stops);
        CHECK(stops >= 2);
        CHECK(same(part, whole));
        CHECK(part.stopped_by == whole.stopped_by);
    }
}

TEST_CASE(
    "Going on: an exposure of another size, or of other replicates or wavelengths, is refused") {
    const PreparedScene scene({panel_scene(),
                               {0},
                               {green_paint()},
                               sample_sky(reference::uniform_sky(1), kTwo, 4, 8),
                               kTwo});
    const Camera camera = look_at({0, 0, 0}, 30, 20, 1);
    RenderSettings settings;
    settings.width = settings.height = 2, settings.spp = 8;
    using Catch::Contains;
    CHECK_THROWS_WITH(render(scene, camera, settings, Exposure(2, 3, kTwo, 8)), Contains("2 x 3"));
    CHECK_THROWS_WITH(render(scene, camera, settings, Exposure(2, 2, kTwo, 16)),
                      Contains("16 replicates"));
    CHECK_THROWS_WITH(render(scene, camera, settings, Exposure(2, 2, {440, 601}, 8)),
                      Contains("440, 601 nm"));
    CHECK(render(scene, camera, settings, Exposure(2, 2, {440, 600.0000001}, 8)).complete());
}

TEST_CASE("Time limit: the samples that fit, and the first in any case", "[render]") {
    const PreparedScene scene = shipped("target_a");
    const Camera camera = first_camera(scene);
    RenderSettings settings;
    settings.width = 64, settings.height = 48, settings.spp = 1u << 20;
    settings.time_limit_s = 1.5;
    const auto start = std::chrono::steady_clock::now();
    const RenderResult result = render(scene, camera, settings);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    CHECK(result.stopped_by == StoppedBy::kTimeLimit);
    // On a quiet machine 0.2 %.
    CHECK(seconds == near(1.5, 0.1));
    settings.time_limit_s = 1e-6;
    CHECK(render(scene, camera, settings).complete());
}
