// merge_test.cpp — pictures of other random numbers as one: means, error bars, bias.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/merge.h"

#include <numeric>
#include <random>

#include "malus/core/error.h"
#include "malus/core/frame.h"
#include "malus/io/gltf.h"
#include "malus/render/render.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/scores.h"

using namespace malus;
using Catch::Contains;

namespace {

// Pixels of all kinds, at two wavelengths; a tenth of them empty.
Film random_film(unsigned seed, std::uint32_t replicates) {
    std::mt19937_64 engine(seed);
    std::uniform_real_distribution<double> u(0.1, 1);
    Film film(20, 5, {440, 600});
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        film.samples[i] = u(engine) < 0.2 ? 0 : static_cast<std::uint32_t>(1e4 * u(engine));
        film.coverage[i] = static_cast<float>(u(engine));
        film.distance[i] = static_cast<float>(10 * u(engine));
        film.instance[i] = static_cast<std::int32_t>(3 * u(engine));
        for (std::size_t w = 0; w < 2; ++w) {
            PixelStokes& p = film.stokes[i * 2 + w];
            p.mean = {1 + u(engine), u(engine) - 0.5, u(engine) - 0.5, u(engine) - 0.5};
            for (float& c : p.covariance) c = static_cast<float>(u(engine));
            p.replicates = static_cast<float>(replicates);
        }
    }
    return film;
}

Film merged(Film a, const Film& b) {
    merge_into(a, b);
    return a;
}

// Largest difference of any number but ids, relative to 1.
double difference(const Film& a, const Film& b) {
    double most = 0;
    const auto compare = [&](double x, double y) {
        most = std::max(most, std::abs(x - y) / std::max(1.0, std::abs(x)));
    };
    for (std::size_t i = 0; i < a.pixel_count(); ++i) {
        compare(a.samples[i], b.samples[i]);
        compare(double{a.coverage[i]}, double{b.coverage[i]});
        compare(double{a.distance[i]}, double{b.distance[i]});
        for (std::size_t w = 0; w < a.wavelengths_nm.size(); ++w) {
            const PixelStokes &p = a.at(i, w), &q = b.at(i, w);
            compare(p.mean.s0, q.mean.s0), compare(p.mean.s1, q.mean.s1);
            compare(p.mean.s2, q.mean.s2), compare(p.mean.s3, q.mean.s3);
            for (std::size_t e = 0; e < p.covariance.size(); ++e)
                compare(double{p.covariance[e]}, double{q.covariance[e]});
            compare(double{p.replicates}, double{q.replicates});
        }
    }
    return most;
}

}  // namespace

TEST_CASE("Merge: two pixels by hand") {
    Film a(2, 1, {550}), b(2, 1, {550});
    a.samples = {64, 100}, b.samples = {192, 100};
    a.coverage = {0.5f, 0}, b.coverage = {1, 0.25f};
    a.distance = {10, 0}, b.distance = {20, 8};
    a.instance = {3, 1}, b.instance = {5, 2};
    // Weights 1/4 and 3/4.
    a.stokes[0] = {{1, 0, 0.4, 0.8}, {0.16f, 0.032f, -0.016f, 0.08f, 0.016f, 0.048f, 0.32f}, 8};
    const auto k = [](double x) { return static_cast<float>(x * 16 / 9); };
    b.stokes[0] = {
        {5, 1.6, 2, 0}, {k(0.03), k(0.001), k(0.002), k(0.005), k(0.002), k(0.006), k(0.01)}, 16};
    // Weights 1/2.
    a.stokes[1].mean = {1, 0, 0, 0}, b.stokes[1].mean = {2, 1, 0, 0};
    merge_into(a, b);
    const PixelStokes& p = a.at(0, 0);
    CHECK(p.mean.s0 == Approx(4));    // 1/4 + 15/4
    CHECK(p.mean.s1 == Approx(1.2));  // 0 + 4.8/4
    CHECK(p.mean.s2 == Approx(1.6));  // 0.4/4 + 6/4
    CHECK(p.mean.s3 == Approx(0.2));  // 0.8/4
    // A sixteenth of the first and 9/16 of the second.
    const double C[] = {0.04, 0.003, 0.001, 0.01, 0.003, 0.009, 0.03};
    for (std::size_t e = 0; e < 7; ++e) CHECK(p.covariance[e] == Approx(C[e]));
    // 1/R = (1/16)/8 + (9/16)/16 = 11/256.
    CHECK(p.replicates == Approx(256.0 / 11));
    // P = 2, p = 1/2, (S1,S2)/P = (0.6, 0.8):
    //   S0² var p = 0.36·0.01 + 0.64·0.009 + 2·0.48·0.003 + 0.25·0.04 − (0.6·0.003 + 0.8·0.001)
    //             = 0.01964;   Kish: m = R/(1 + (R−1)·0.04/16) = 22.045, widening² = 1.00250
    CHECK(stderr_dolp(p) == Approx(std::sqrt(0.01964 * 1.00250) / 4));
    CHECK(a.coverage[0] == Approx(0.875));          // 0.5/4 + 3/4
    CHECK(a.distance[0] == Approx(16.25 / 0.875));  // (10·0.125 + 20·0.75)/0.875
    CHECK(a.instance == std::vector<std::int32_t>{5, 1});
    CHECK(a.samples == std::vector<std::uint32_t>{256, 200});
    CHECK(a.at(1, 0).mean.s0 == Approx(1.5));
    CHECK(a.at(1, 0).replicates == 16);
    CHECK(a.coverage[1] == Approx(0.125));
    CHECK(a.distance[1] == 8);
}

TEST_CASE("Merge: a pixel without samples takes no part") {
    const Film full = random_film(1, 8);
    Film none = random_film(2, 4);
    for (std::uint32_t& n : none.samples) n = 0;
    CHECK(difference(merged(full, none), full) == 0);
    const Film taken = merged(none, full);
    for (std::size_t i = 0; i < full.pixel_count(); ++i) {
        if (full.samples[i] == 0) continue;
        CHECK(taken.at(i, 1).mean.s2 == full.at(i, 1).mean.s2);
        CHECK(taken.at(i, 1).covariance == full.at(i, 1).covariance);
        CHECK(taken.at(i, 1).replicates == 8);
        CHECK(taken.distance[i] == Approx(full.distance[i]).epsilon(1e-6));
        CHECK(taken.instance[i] == full.instance[i]);
    }
    Film both = none;
    merge_into(both, none);
    CHECK(difference(both, none) == 0);
}

TEST_CASE("Merge: any grouping and order gives the same to 1e-6") {
    const Film a = random_film(1, 8), b = random_film(2, 4), c = random_film(3, 100);
    const Film all = merged(merged(a, b), c);
    CHECK(difference(merged(a, merged(b, c)), all) < 1e-6);
    CHECK(difference(merged(merged(c, a), b), all) < 1e-6);
}

TEST_CASE("Merge: light stays physical, also as floats") {
    // Fully polarized in directions that differ by a few roundings.
    std::mt19937_64 engine(4);
    std::normal_distribution<double> normal;
    for (int trial = 0; trial < 1000; ++trial) {
        const double x = normal(engine), y = normal(engine), z = normal(engine);
        Film sum(1, 1, {550});
        for (int k = 0; k < 8; ++k) {
            const double s0 = std::exp(normal(engine)), r = s0 / std::hypot(x, y, z);
            Film film(1, 1, {550});
            const auto f = [](double v) { return double{static_cast<float>(v)}; };
            film.samples[0] = 64;
            film.stokes[0].mean = {f(s0), f(r * x), f(r * y), f(r * z)};
            merge_into(sum, film);
        }
        const Stokes<double>& S = sum.at(0, 0).mean;
        const auto f = [](double v) { return double{static_cast<float>(v)}; };
        REQUIRE(std::hypot(f(S.s1), f(S.s2), f(S.s3)) <= f(S.s0));
        REQUIRE(dop(S) == near(1, 1e-6));
    }
}

TEST_CASE("Merge: what is not alike, or too much to count, is refused") {
    Film film(2, 1, {440, 600});
    CHECK_THROWS_WITH(merge_into(film, Film(1, 2, {440, 600})), Contains("differ in size"));
    CHECK_THROWS_WITH(merge_into(film, Film(2, 1, {440})), Contains("wavelengths"));
    CHECK_THROWS_WITH(merge_into(film, Film(2, 1, {440, 600.5})), Contains("wavelengths"));
    Film other(2, 1, {440, 600.0000004});
    film.samples = {4000000000u, 1}, other.samples = {294967295u, 1};
    CHECK_NOTHROW(merge_into(film, other));
    CHECK(film.samples[0] == 4294967295u);
    CHECK_THROWS_WITH(merge_into(film, other), Contains("over 4294967295 samples"));
}

namespace {

// A picture of one pixel that goes on when it sees much noise: skewed samples of mean 1.
Film adaptive_picture(std::mt19937_64& engine) {
    std::exponential_distribution<float> rare;
    Exposure exposure(1, 1, {550}, 8);
    PixelExposure pixel(exposure);
    Film film(1, 1, {550});
    const auto go_on = [&](int samples) {
        for (int n = 0; n < samples; ++n) {
            for (std::uint32_t r = 0; r < 8; ++r) {
                const float x = rare(engine), S[4] = {x * x * x / 6, 0, 0, 0};
                pixel.add(r, S, 1);
            }
            pixel.end_sample();
        }
        pixel.develop(film, 0);
    };
    go_on(4);
    if (relative_stderr_s0(film.at(0, 0)) > 0.4) go_on(28);
    return film;
}

}  // namespace

TEST_CASE("Merge: pictures that stopped by what they saw have no bias together", "[statistical]") {
    // 300 merges of 64 pictures. Their mean has some 1/64 of the bias of a plain mean of pictures
    // (−9 %), and a standard error of 0.3 %. Deviation of the scores: known to 4 %, coverage to
    // 1.3 %. False alarms under 1e-4.
    std::mt19937_64 engine(5);
    Scores scores;
    double plain = 0, by_samples = 0;
    for (int trial = 0; trial < 300; ++trial) {
        Film sum(1, 1, {550});
        for (int k = 0; k < 64; ++k) {
            const Film film = adaptive_picture(engine);
            plain += film.at(0, 0).mean.s0 / (300 * 64);
            merge_into(sum, film);
        }
        const PixelStokes& p = sum.at(0, 0);
        by_samples += p.mean.s0 / 300;
        scores.add((p.mean.s0 - 1) / std::sqrt(double{p.covariance[0]}), 1.96);
    }
    CAPTURE(plain, by_samples, scores.mean(), scores.deviation(), scores.coverage());
    CHECK(plain < 0.95);
    CHECK(by_samples == near(1, 0.015));
    CHECK(scores.deviation() == near(1, 0.2));
    CHECK(scores.coverage() == near(0.95, 0.05));
}

namespace {

// z-scores, and the variance that Student's t has with the degrees of freedom of each.
struct Tally {
    Scores scores;
    double variance = 0;  ///< summed: ν/(ν − 2)

    void add(double off, double error, double degrees) {
        scores.add(off / error, student95(degrees));
        variance += degrees / (degrees - 2);
    }
    double expected_deviation() const { return std::sqrt(variance / scores.count); }
};

struct Tolerance {
    double mean, deviation, coverage;
};
void check(const Tally& tally, const char* quantity, const Tolerance& within) {
    const Scores& scores = tally.scores;
    CAPTURE(quantity, scores.count, scores.mean(), scores.deviation(), tally.expected_deviation(),
            scores.coverage());
    CHECK(std::abs(scores.mean()) < within.mean);
    CHECK(scores.deviation() == Approx(tally.expected_deviation()).epsilon(within.deviation));
    CHECK(scores.coverage() == near(0.95, within.coverage));
}

// Degrees of freedom of a sum of estimated variances, each with its own (Welch, Satterthwaite).
struct Variance {
    double value, degrees;
};
double welch(const std::vector<Variance>& variances) {
    double sum = 0, squares = 0;
    for (const Variance& v : variances) sum += v.value, squares += sqr(v.value) / v.degrees;
    return sqr(sum) / squares;
}

// Renders of one scene, each with another seed.
class Renders {
  public:
    Renders(const PreparedScene& scene, const Camera& camera, int width, int height)
        : scene_(scene), camera_(camera) {
        settings_.width = width, settings_.height = height;
        settings_.sky_table = false;  // pixels that share an error count as one score
    }
    Film next(std::uint32_t spp, std::uint32_t replicates = kReplicates) {
        settings_.spp = spp, settings_.replicates = replicates;
        ++settings_.seed;
        return render(scene_, camera_, settings_).film;
    }

  private:
    const PreparedScene& scene_;
    const Camera& camera_;
    RenderSettings settings_;
};

// Merged halves of 128 samples less a whole of 256, in units of both error bars, which have 14 and
// 7 degrees of freedom. DoLP and AoLP count where their errors are known.
void check_halves(Renders renders, int times, const Tolerance& within) {
    std::vector<Tally> tallies(quantities().size());
    for (int k = 0; k < times; ++k) {
        const Film halves = merged(renders.next(128), renders.next(128));
        const Film whole = renders.next(256);
        for (std::size_t i = 0; i < whole.pixel_count(); ++i)
            for (std::size_t q = 0; q < tallies.size(); ++q) {
                const Quantity& quantity = quantities()[q];
                const PixelStokes &a = halves.at(i, 0), &b = whole.at(i, 0);
                const double ea = quantity.error(a), eb = quantity.error(b);
                if (quantity.polarization && std::max(ea, eb) > 0.5) continue;
                tallies[q].add(quantity.off(a, b), std::hypot(ea, eb),
                               welch({{sqr(ea), 14}, {sqr(eb), 7}}));
            }
    }
    for (std::size_t q = 0; q < tallies.size(); ++q)
        check(tallies[q], quantities()[q].name, within);
}

// Merges of such parts against the quadrature.
struct Part {
    std::uint32_t spp, replicates;
};
void check_against_quadrature(const std::vector<Part>& parts, int merges, double nm) {
    const PreparedScene scene(panel_scene(), {0}, {green_paint()},
                              sample_sky(smooth_sky(), {nm}, 180, 720), {nm});
    const Camera camera = look_at({0, 0, 0}, 45, 20, 1e-4);
    const PixelStokes right = panel_reference(green_paint(), nm, camera);
    Renders renders(scene, camera, 8, 8);
    std::vector<Film> sums;
    std::vector<Variance> variances;  // of S0, up to one factor
    for (const Part& part : parts) variances.push_back({0, part.replicates - 1.0});
    for (int k = 0; k < merges; ++k) {
        Film& sum = sums.emplace_back(8, 8, std::vector<double>{nm});
        for (std::size_t p = 0; p < parts.size(); ++p) {
            const Film film = renders.next(parts[p].spp, parts[p].replicates);
            for (std::size_t i = 0; i < film.pixel_count(); ++i)
                variances[p].value += sqr(film.samples[i]) * double{film.at(i, 0).covariance[0]};
            merge_into(sum, film);
        }
    }
    for (const Quantity& quantity : quantities()) {
        Tally tally;
        for (const Film& sum : sums)
            for (std::size_t i = 0; i < sum.pixel_count(); ++i)
                tally.add(quantity.off(sum.at(i, 0), right), quantity.error(sum.at(i, 0)),
                          welch(variances));
        CAPTURE(nm, welch(variances));
        // 3200 scores know their mean to 0.018, deviation to 1.3 %, coverage to 0.4 %: false alarms
        // under 1e-4 a number. S3, small and skewed, takes its room.
        check(tally, quantity.name, {0.1, 0.06, 0.02});
    }
}

}  // namespace

TEST_CASE("Merge: two halves are the whole, on a panel, within error bars that cover 95 %",
          "[render]") {
    const PreparedScene scene(panel_scene(), {0}, {green_paint()},
                              sample_sky(smooth_sky(), {600}, 180, 720), {600});
    // 6400 scores: mean known to 0.013, deviation to 0.9 %, coverage to 0.27 %; false alarms under
    // 1e-4 a number.
    check_halves(Renders(scene, look_at({0, 0, 0}, 45, 20, 1e-4), 8, 8), 100, {0.06, 0.05, 0.015});
}

TEST_CASE("Merge: two halves are the whole, on a target on its ground", "[render]") {
    Scene target = read_gltf(MALUS_SOURCE_DIR "/scenes/target_a.glb");
    const std::vector<Material> paints{green_paint(), black_paint()};
    const std::vector<int> of = assign_paints(target, {}, paints);
    const Camera camera = target.cameras.at(0);
    const PreparedScene scene(std::move(target), of, paints,
                              sample_sky(smooth_sky(), {600}, 90, 360), {600});
    // 1920 scores: mean known to 0.023, deviation to 1.7 %, coverage to 0.5 %; false alarms under
    // 1e-4 a number.
    check_halves(Renders(scene, camera, 16, 12), 10, {0.1, 0.08, 0.025});
}

TEST_CASE("Merge: error bars of eight pictures cover the quadrature in 95 %", "[render]") {
    const std::vector<Part> eight(8, {128, 8});  // 56 degrees of freedom
    for (double nm : {440.0, 600.0}) check_against_quadrature(eight, 50, nm);
}

TEST_CASE("Merge: error bars are right where samples and replicates differ", "[render]") {
    check_against_quadrature({{64, 8}, {256, 16}, {1024, 4}}, 50, 600);
}
