// shared_errors_test.cpp — errors of rare events, known from neighbours.
// SPDX-License-Identifier: Apache-2.0
#include "render/shared_errors.h"

#include <random>

#include "support/catch.h"

using namespace malus;

namespace {

PixelStokes with_covariance(const std::array<float, 7>& covariance, double S0 = 1) {
    PixelStokes pixel;
    pixel.mean.s0 = S0;
    pixel.covariance = covariance;
    return pixel;
}

}  // namespace

TEST_CASE(
    "Shared errors: half of a pixel's own and half of its neighbours', never less than its own",
    "[render]") {
    // C00, C01, C02, C11, C12, C22, C33; 10 and 40 samples: of one sample 10 and 0 times this.
    PixelStokes sure = with_covariance({});
    PixelStokes unsure = with_covariance({4, -1, 0.5f, 2, 0.25f, 1, 0.125f});
    share_errors(std::array<SharedError, 2>{{{&sure, 40}, {&unsure, 10}}});
    CHECK(unsure.covariance == std::array<float, 7>{4, -1, 0.5f, 2, 0.25f, 1, 0.125f});
    // Mean of one sample: (40, …)/2 = 20; half of it is 10, over 40 samples 0.25.
    CHECK(sure.covariance ==
          std::array<float, 7>{0.25f, -0.0625f, 0.03125f, 0.125f, 0.015625f, 0.0625f, 0.0078125f});
}

TEST_CASE(
    "Shared errors: a dark pixel has no larger part of its light in doubt than its neighbours",
    "[render]") {
    PixelStokes dark = with_covariance({}, 1e-3), black = with_covariance({}, 0);
    PixelStokes bright = with_covariance({4, -1, 0.5f, 2, 0.25f, 1, 0.125f}, 10);
    share_errors(std::array<SharedError, 3>{{{&dark, 5}, {&black, 5}, {&bright, 5}}});
    CHECK(bright.covariance == std::array<float, 7>{4, -1, 0.5f, 2, 0.25f, 1, 0.125f});
    CHECK(black.covariance == std::array<float, 7>{});
    // In units of their own light squared the two with light have (0 + 4/100)/2 on average; half of it.
    CHECK(dark.covariance[0] == Approx(0.01 * 1e-6));
    CHECK(dark.covariance[1] == Approx(-0.0025 * 1e-6));
    CHECK(dark.covariance[6] == Approx(0.0003125 * 1e-6));
    // A bright pixel beside a dark one that knows nothing of its little light goes by light itself.
    PixelStokes certain = with_covariance({}, 10), dim = with_covariance({4e-6f}, 1e-3);
    share_errors(std::array<SharedError, 2>{{{&certain, 5}, {&dim, 5}}});
    CHECK(certain.covariance[0] == Approx(1e-6));
    CHECK(dim.covariance[0] == 4e-6f);
}

TEST_CASE("Shared errors: only among pixels of one instance, at one wavelength", "[render]") {
    Film film(4, 1, {440, 600});
    for (PixelStokes& pixel : film.stokes) pixel.mean.s0 = 1;
    film.instance = {7, 2, 7, 2};
    film.samples = {1, 1, 1, 1};
    film.stokes[2 * 0].covariance[0] = film.stokes[2 * 0 + 1].covariance[0] = 8;
    film.stokes[2 * 3 + 1].covariance[0] = 2;
    std::vector<std::size_t> all{0, 1, 2, 3}, some{1, 2, 3};
    share_errors(film, 0, all);
    share_errors(film, 1, some);
    // At 440 nm pixel 2 learns of 0: half of (8 + 0)/2. At 600 nm, where 0 is not on the list, it does
    // not, and pixel 1 learns of 3: half of (2 + 0)/2.
    const std::array<std::array<float, 2>, 4> expected{{{8, 8}, {0, 0.5f}, {2, 0}, {0, 2}}};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t w = 0; w < 2; ++w) {
            CAPTURE(i, w);
            CHECK(film.at(i, w).covariance[0] == expected[i][w]);
        }
}

TEST_CASE("Shared errors: light that one sample of 300 misses is within six errors", "[render]") {
    // 16 pixels, 8 replicates of 2 samples of light 1, each without in one of 300: the mean is 299/300.
    // In a whole tile 256 samples meet it with a chance of 0.43; then nobody knows.
    std::mt19937 random(1);
    std::bernoulli_distribution misses(1.0 / 300);
    int far_alone = 0, far_shared = 0, tiles = 0;
    while (tiles < 2000) {
        std::array<PixelStokes, 16> pixels;
        std::vector<SharedError> shared;
        double whole = 0;
        for (PixelStokes& pixel : pixels) {
            std::array<double, 8> means{};
            for (double& mean : means) {
                for (int i = 0; i < 2; ++i) mean += misses(random) ? 0 : 0.5;
                pixel.mean.s0 += mean / 8;
            }
            double squares = 0;
            for (double mean : means) squares += (mean - pixel.mean.s0) * (mean - pixel.mean.s0);
            pixel.covariance[0] = static_cast<float>(squares / 56);
            whole += 1 - pixel.mean.s0;
            shared.push_back({&pixel, 16});
        }
        if (whole == 0) continue;
        ++tiles;
        const auto far = [&] {
            int count = 0;
            for (const PixelStokes& pixel : pixels)
                count += std::abs(pixel.mean.s0 - 299.0 / 300) >
                         6 * std::sqrt(static_cast<double>(pixel.covariance[0]));
            return count;
        };
        far_alone += far();
        share_errors(shared);
        far_shared += far();
    }
    CHECK(far_alone > 16 * tiles / 2);
    CHECK(far_shared == 0);
}
