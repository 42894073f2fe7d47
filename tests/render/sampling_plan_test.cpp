// sampling_plan_test.cpp — which pixels a round serves, and when there is none.
// SPDX-License-Identifier: Apache-2.0
#include "render/sampling_plan.h"

#include "support/catch.h"

using namespace malus;

namespace {

// A picture whose pixels have errors of the test's choosing.
struct Pictured {
    RenderSettings settings;
    Exposure exposure;
    Film film;

    Pictured(int width, int height, double target, std::uint32_t spp = 1u << 20)
        : exposure(width, height, {550}, kReplicates), film(width, height, {550}) {
        settings.width = width, settings.height = height;
        settings.spp = spp, settings.target_error = target;
        for (float& a : film.coverage) a = 1;
        for (PixelStokes& pixel : film.stokes) pixel.mean = {1, 0, 0, 0};
        for (std::size_t i = 0; i < exposure.pixel_count(); ++i) take(i, 4);
    }
    void take(std::size_t pixel, std::uint32_t samples) {
        exposure.taken[pixel] = exposure.wanted[pixel] = samples;
    }
    void set_error(std::size_t pixel, double error) {
        film.stokes[pixel].covariance[0] = static_cast<float>(error * error);
    }
    std::optional<StoppedBy> plan() {
        SamplingPlan plan(settings, exposure);
        for (std::size_t i = 0; i < exposure.pixel_count(); ++i) plan.measure(film, i);
        return plan.plan_round(exposure);
    }
    std::size_t served() const {
        std::size_t count = 0;
        for (std::size_t i = 0; i < exposure.pixel_count(); ++i)
            count += exposure.wanted[i] > exposure.taken[i];
        return count;
    }
};

}  // namespace

TEST_CASE("Sampling plan: a fixed number of samples is reached in rounds of all pixels") {
    Pictured p(5, 3, 0, 8 * 11);
    for (std::size_t i = 0; i < 15; ++i) p.take(i, 0);
    for (std::uint32_t expected : {1u, 4u, 8u, 11u}) {
        REQUIRE_FALSE(p.plan());
        for (std::size_t i = 0; i < 15; ++i) {
            CHECK(p.exposure.wanted[i] == expected);
            p.take(i, expected);
        }
    }
    CHECK(p.plan() == StoppedBy::kSamples);
}

TEST_CASE("Sampling plan: a round that was stopped is ended first") {
    Pictured p(5, 3, 0.01);
    p.exposure.wanted[7] = 6;
    REQUIRE_FALSE(p.plan());
    CHECK(p.served() == 1);
    const SamplingPlan plan(p.settings, p.exposure);
    // Pixel 7 stands at (2, 1): in the first of two tiles.
    CHECK(plan.round(p.exposure) == std::vector<std::size_t>{0});
}

TEST_CASE("Sampling plan: met when 95 of 100 pixels are below the target, whatever the others") {
    Pictured p(40, 25, 0.1);
    for (std::size_t i = 0; i < 1000; ++i) p.set_error(i, 0.07);
    // A block in a corner, so that few neighbours feel it: 7 × 7 pixels are 4.9 %.
    for (std::size_t y = 0; y < 7; ++y)
        for (std::size_t x = 0; x < 7; ++x) p.set_error(40 * y + x, 0.15);
    CHECK_FALSE(p.plan());  // the rim's neighbours count it, too: 64 pixels
    for (std::size_t y = 0; y < 7; ++y)
        for (std::size_t x = 0; x < 7; ++x) p.set_error(40 * y + x, y < 6 && x < 6 ? 0.15 : 0.07);
    p.exposure.wanted = p.exposure.taken;
    CHECK(p.plan() == StoppedBy::kTargetError);  // 36, and 12 along their rim
}

TEST_CASE("Sampling plan: samples go where the error is, but for the hardest pixels") {
    Pictured p(40, 25, 0.01);
    for (std::size_t i = 0; i < 1000; ++i) {
        p.set_error(i, i % 40 < 20 ? 0.002 : 0.05);
        p.take(i, i % 40 < 20 ? 4 : 12);
    }
    // A corner of the bad half (2 %, under the hardest 2.5 %) has had more than the mean.
    const auto hard = [](std::size_t i) { return i % 40 >= 36 && i / 40 < 5; };
    for (std::size_t i = 0; i < 1000; ++i)
        if (hard(i)) p.set_error(i, 5.0);
    REQUIRE_FALSE(p.plan());
    for (std::size_t i = 0; i < 1000; ++i) {
        CAPTURE(i % 40, i / 40);
        if (i % 40 < 19) CHECK(p.exposure.wanted[i] == 4);
        if (i % 40 > 20 && i % 40 < 35) CHECK(p.exposure.wanted[i] == 16);  // half an octave on
        if (hard(i)) CHECK(p.exposure.wanted[i] == 12);
    }
}

TEST_CASE(
    "Sampling plan: ends with the samples when more pixels than may miss the target have all") {
    Pictured p(100, 10, 0.01, 64);
    for (std::size_t i = 0; i < 1000; ++i) p.set_error(i, 0.005), p.take(i, 4);
    const auto corner = [](std::size_t i, std::size_t columns) {
        return i % 100 < columns && i / 100 < 5;
    };
    for (std::size_t i = 0; i < 1000; ++i)
        if (corner(i, 12)) p.set_error(i, 0.5), p.take(i, 8);
    CHECK(p.plan() == StoppedBy::kSamples);
    // Three in a hundred may miss it: then the others can still meet it.
    for (std::size_t i = 0; i < 1000; ++i)
        if (!corner(i, 6)) p.set_error(i, i % 100 < 50 ? 0.005 : 0.05);
    REQUIRE_FALSE(p.plan());
    CHECK(p.exposure.wanted[575] == 6);
    CHECK(p.exposure.wanted[0] == 8);
}

TEST_CASE("Sampling plan: pixels that show no surface do not count") {
    Pictured p(10, 10, 0.01);
    for (std::size_t i = 0; i < 100; ++i) p.set_error(i, i < 50 ? 0.5 : 0.001);
    for (std::size_t i = 0; i < 50; ++i) p.film.coverage[i] = 0;
    CHECK(p.plan() == StoppedBy::kTargetError);
    for (float& a : p.film.coverage) a = 0;
    CHECK(p.plan() == StoppedBy::kTargetError);
}

TEST_CASE("Sampling plan: under a time limit alone, a picture without noise is sampled evenly") {
    Pictured p(10, 10, 0, 64);
    p.settings.time_limit_s = 1;
    REQUIRE_FALSE(p.plan());
    CHECK(p.served() == 100);
    CHECK(p.exposure.wanted[5] == 8);
    for (std::size_t i = 0; i < 100; ++i) p.take(i, 8);
    CHECK(p.plan() == StoppedBy::kSamples);
}

TEST_CASE("Sampling plan: when none but the hardest pixels are left, they are served") {
    // Most of the surface gets no light and stays at the pilot, which holds the mean down; 45 bad
    // pixels have all they can get, 25 have had more than the mean.
    Pictured p(100, 10, 0.01, 8 * 1024);
    const auto error = [](std::size_t i) { return i < 45 ? 0.5 : i < 70 ? 0.2 : 0.0; };
    for (std::size_t i = 0; i < 1000; ++i) {
        p.set_error(i, error(i));
        if (i < 70) p.take(i, i < 45 ? 1024 : 64);
        if (i >= 70) p.film.stokes[i].mean = {0, 0, 0, 0};
    }
    REQUIRE_FALSE(p.plan());
    CHECK(p.exposure.wanted[50] == 96);
    CHECK(p.exposure.wanted[0] == 1024);
    CHECK(p.exposure.wanted[500] == 4);
}

TEST_CASE(
    "Sampling plan: a pixel beside a surface keeps pace with it, whatever it has seen so far") {
    Pictured p(10, 10, 0.01);
    for (std::size_t i = 0; i < 100; ++i) {
        p.set_error(i, 0.05);
        p.take(i, i % 10 < 5 ? 64 : 4);
        if (i % 10 >= 5) p.film.coverage[i] = 0;
    }
    p.set_error(90, 0.5);  // the hardest, which waits
    REQUIRE_FALSE(p.plan());
    for (std::size_t y = 0; y < 10; ++y) {
        CHECK(p.exposure.wanted[10 * y + 4] == 96);
        CHECK(p.exposure.wanted[10 * y + 5] >= 64);
        CHECK(p.exposure.wanted[10 * y + 6] == 4);
    }
}

TEST_CASE("Sampling plan: a round that was begun under a larger cap is ended under the new one") {
    Pictured p(5, 3, 0, 8 * 40);
    for (std::size_t i = 0; i < 15; ++i) p.take(i, 32), p.exposure.wanted[i] = 64;
    REQUIRE_FALSE(p.plan());
    for (std::size_t i = 0; i < 15; ++i) CHECK(p.exposure.wanted[i] == 40);
}
