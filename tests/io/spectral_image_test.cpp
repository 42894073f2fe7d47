// spectral_image_test.cpp — channels, names and files of rendered images.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/spectral_image.h"

#include <clocale>

#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/io/stats_file.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using Catch::Contains;

TEST_CASE("Channel names: six decimals and a decimal comma, both ways, in any locale") {
    for (const char* locale : {"C", "de_DE.UTF-8"}) {
        std::setlocale(LC_ALL, locale);
        CHECK(spectral_channel("S0", 440) == "S0.440,000000nm");
        CHECK(spectral_channel("StdErr_DoLP", 550.25) == "StdErr_DoLP.550,250000nm");
        const auto name = parse_spectral_channel("DoLP.550,250000nm");
        REQUIRE(name);
        CHECK(name->quantity == "DoLP");
        CHECK(name->wavelength_nm == 550.25);
    }
    std::setlocale(LC_ALL, "C");
    for (const char* other : {"R", "N.samples", "S0.nm", "S0.12,5", "S0.-3nm", "S0.1,2,3nm"})
        CHECK_FALSE(parse_spectral_channel(other));
}

TEST_CASE("Wavelengths are listed by value, not by name") {
    Image image;
    image.width = image.height = 1;
    for (double nm : {1000.0, 440.0, 550.5})
        for (const char* s : {"S0", "S1", "S2", "S3"}) image.channel(spectral_channel(s, nm));
    CHECK(stokes_wavelengths(image) == std::vector<double>{440, 550.5, 1000});
}

TEST_CASE("Film to image: every channel of the format, with the film's numbers") {
    Film film(2, 1, {440, 600});
    film.coverage = {1, 0};
    film.distance = {12, 0};
    film.instance = {1, -1};
    film.samples = {64, 64};
    film.stokes[0].mean = {2, -0.6, 0.8, 0.1};
    film.stokes[0].covariance = {0.04f, 0, 0, 0.01f, 0, 0.0225f, 0.09f};
    film.stokes[1].covariance = {0.04f, 0.001f, 0.002f, 0.01f, 0.003f, 0.0225f, 0.09f};
    const Image image = to_image(film, {{"matte", "green"}, {"root", "hull"}, {0, 1}, {0, 1}});
    const auto at = [&](const std::string& name) { return image.channels.at(name)[0]; };
    CHECK(at("S0.440,000000nm") == 2.0f);
    CHECK(at("S1.440,000000nm") == Approx(-0.6));
    CHECK(at("S2.440,000000nm") == Approx(0.8));
    CHECK(at("S3.440,000000nm") == Approx(0.1));
    CHECK(at("DoLP.440,000000nm") == Approx(0.5));
    // ½ atan2(0.8, −0.6) = ½ · 126.87°.
    CHECK(at("AoLP.440,000000nm") == Approx(63.4349));
    CHECK(at("StdErr_S0.440,000000nm") == Approx(0.2));
    CHECK(at("StdErr_S1.440,000000nm") == Approx(0.1));
    CHECK(at("StdErr_S2.440,000000nm") == Approx(0.15));
    CHECK(at("StdErr_S3.440,000000nm") == Approx(0.3));
    // var p = [0.36·0.01 + 0.64·0.0225 + 0.25·0.04]/4, var ψ = [0.36·0.0225 + 0.64·0.01]/4 rad².
    // Kish: C00/S0² = 0.01, m = 8/1.07, widening² = 7/8 · m/(m − 1).
    const double wider = std::sqrt(7.0 / 8 * (8 / 1.07) / (8 / 1.07 - 1));
    CHECK(at("StdErr_DoLP.440,000000nm") == Approx(wider * std::sqrt(0.028) / 2));
    CHECK(at("StdErr_AoLP.440,000000nm") == Approx(wider * to_degrees(std::sqrt(0.0145) / 2)));
    CHECK(at("Cov_S0S1.600,000000nm") == 0.001f);
    CHECK(at("Cov_S0S2.600,000000nm") == 0.002f);
    CHECK(at("Cov_S1S2.600,000000nm") == 0.003f);
    CHECK(at("A") == 1);
    CHECK(at("Z") == 12);
    CHECK(at("material.id") == 2);
    CHECK(at("node.id") == 2);
    CHECK(image.channels.at("node.id")[1] == 0);
    CHECK(at("N.samples") == 64);
    CHECK(at("N.replicates") == 8);
    CHECK(image.channels.size() == 2 * 15 + 6 + 3);
    CHECK(image.channels.at("R") == image.channels.at("S0.600,000000nm"));
    CHECK(*image.text("spectralLayoutVersion") == "1.0");
    CHECK(*image.text("emissiveUnits") == "W.m^-2.sr^-1");
    CHECK(*image.text("polarisationHandedness") == "right");
    CHECK(*image.text("spectralQuantity") == "spectral radiance per nm");
    CHECK(*image.text("aolpUnits") == "degrees");
    CHECK(std::get<3>(image.attributes.at("materialNames")) ==
          std::vector<std::string>{"(sky)", "matte", "green"});
}

TEST_CASE("EXR: channels and attributes come back as they were written") {
    const TempFolder folder;
    Image image;
    image.width = 3, image.height = 2;
    image.channel("S0.440,000000nm") = {1, 2, 3, 4, 5, 6};
    image.channel("Z") = {0.5, 0, 0, 0, 0, 1e30f};
    image.attributes = {{"text", "naïve"},
                        {"number", 2.5f},
                        {"count", 7},
                        {"names", std::vector<std::string>{"a", "b"}}};
    write_exr(folder / "image.exr", image);
    const Image back = read_exr(folder / "image.exr");
    CHECK(back.width == 3);
    CHECK(back.channels == image.channels);
    for (const auto& [name, value] : image.attributes) CHECK(back.attributes.at(name) == value);
}

TEST_CASE("EXR: channels computed while written hold their pixels' numbers in each strip of rows") {
    const TempFolder folder;
    Image image;
    // More rows than any number of threads up to 64 takes at once, and a last strip that is short.
    image.width = 5, image.height = 16 * 64 + 7;
    image.channel("stored").assign(image.pixel_count(), 3);
    const auto numbers_of = [](std::size_t from, std::size_t to, float* const* numbers) {
        for (std::size_t i = from; i < to; ++i) {
            numbers[0][i - from] = static_cast<float>(i);
            numbers[1][i - from] = static_cast<float>(i) / 2;
        }
    };
    image.computed.push_back({{"place", "half"}, numbers_of});
    for (Compression as : {Compression::kZip, Compression::kNone}) {
        write_exr(folder / "image.exr", image, as);
        const Image back = read_exr(folder / "image.exr");
        REQUIRE(back.channels.size() == 3);
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < back.pixel_count(); ++i)
            wrong += back.channels.at("place")[i] == static_cast<float>(i) &&
                             back.channels.at("half")[i] == static_cast<float>(i) / 2 &&
                             back.channels.at("stored")[i] == 3
                         ? 0
                         : 1;
        CHECK(wrong == 0);
    }
    image.compute_channels();
    CHECK(image.computed.empty());
    CHECK(image.channels == read_exr(folder / "image.exr").channels);
}

TEST_CASE("Files: they appear whole or not at all, and what stood there stays") {
    const TempFolder folder;
    write_text(folder / "kept.txt", "old");
    CHECK_THROWS_WITH(write_whole(folder / "kept.txt",
                                  [](const auto& beside) {
                                      write_text(beside.string(), "half");
                                      throw std::runtime_error("disk full");
                                  }),
                      Contains("kept.txt: cannot be written (disk full)"));
    CHECK(read_text(folder / "kept.txt") == "old");
    CHECK(std::distance(std::filesystem::directory_iterator((folder / "").parent_path()), {}) == 1);
    CHECK_THROWS_WITH(write_text(folder / "no/such/file", ""), Contains("there is no folder"));
    CHECK_THROWS_WITH(write_text((folder / "").parent_path(), ""), Contains("it is a folder"));
}

TEST_CASE("Stats: errors are summarized over the pixels that show a surface") {
    Film film(3, 1, {550});
    film.coverage = {1, 1, 0};
    film.stokes[0] = {{2, 1, 0, 0}, {0.04f, 0, 0, 0, 0, 0, 0}};  // 10 % of S0
    film.stokes[1] = {{4, 0, 1, 0}, {0.64f, 0, 0, 0, 0, 0, 0}};  // 20 %
    film.stokes[2] = {{1, 0, 0, 0}, {1, 0, 0, 0, 0, 0, 0}};      // sky: does not count
    const ErrorSummary error = summarize_error(film, 0);
    CHECK(error.rms_s0_relative == Approx(std::sqrt((0.01 + 0.04) / 2)));
    // σ_p = p σ0/S0 = 0.05 twice, widened by Kish's number for C00/S0² = 0.01 and 0.04.
    const auto wider = [](double spread) {
        const double m = 8 / (1 + 7 * spread);
        return std::sqrt(7.0 / 8 * m / (m - 1));
    };
    CHECK(error.rms_dolp == Approx(0.05 * std::sqrt((sqr(wider(0.01)) + sqr(wider(0.04))) / 2)));
    // Of two numbers 95 % are at most the larger.
    CHECK(error.p95_s0_relative == Approx(0.2));
    CHECK(error.p95_dolp == Approx(0.05 * wider(0.04)));
    CHECK(error_of_most(film) == Approx(0.2));
}

TEST_CASE("Stats: refused samples are told with pixel and seed") {
    RenderResult result;
    result.film = Film(8, 8, {550});
    result.refused = 3, result.paths = 640;
    result.first_refused = {{5, 7, 2, 11}, {6, 7, 0, 1}, {6, 7, 0, 2}};
    CHECK_THAT(refusal_warning(result, 42),
               Contains("3 of 640 samples") && Contains("pixel (5,7)") &&
                   Contains("replicate 2, sample 11") && Contains("seed 42"));
    const TempFolder folder;
    RenderStats stats;
    stats.seed = 42;
    write_stats(folder / "stats.json", stats, result);
    const std::string json = read_text(folder / "stats.json");
    CHECK_THAT(json, Contains("\"rejected_samples\": 3") && Contains("\"seed\": 42") &&
                         Contains("\"x\": 5") && Contains("\"y\": 7") &&
                         Contains("\"replicate\": 2") && Contains("\"sample\": 11"));
}

TEST_CASE("Quantile: the smallest number that a share of the values does not exceed") {
    CHECK(quantile({}, 0.95) == 0);
    CHECK(quantile({3}, 0.95) == 3);
    std::vector<double> values;
    for (int i = 100; i > 0; --i) values.push_back(i);
    CHECK(quantile(values, 0.95) == 95);
    CHECK(quantile(values, 1) == 100);
    CHECK(quantile(values, 0) == 1);
}
