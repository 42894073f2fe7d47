// film_image_test.cpp — films to an EXR and back.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/film_image.h"

#include "malus/core/error.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using Catch::Contains;

namespace {

// Each number another one; two nodes share a name, one pixel has no samples.
Film numbered() {
    Film film(3, 2, {440, 450.6666666});
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        const auto x = static_cast<double>(i) + 1;
        film.samples[i] = static_cast<std::uint32_t>(i == 4 ? 0 : 1000 * x);
        film.coverage[i] = static_cast<float>(x / 7);
        film.distance[i] = static_cast<float>(x * 1.1);
        film.instance[i] = static_cast<std::int32_t>(i % 4) - 1;
        for (std::size_t w = 0; w < 2; ++w) {
            PixelStokes& p = film.stokes[i * 2 + w];
            p.mean = {x, 0.1 * x + static_cast<double>(w), -0.2 * x, 0.3};
            for (std::size_t e = 0; e < 7; ++e)
                p.covariance[e] = static_cast<float>((static_cast<double>(e) + x) / 13);
            p.replicates = static_cast<float>(8 + x / 3);
        }
    }
    return film;
}

const Labels kLabels{{"matte", "green"}, {"root", "wheel", "wheel"}, {1, 0, 1}, {0, 2, 1}};

Image spoiled(const std::string& channel, float value) {
    Image image = to_image(numbered(), kLabels);
    image.channel(channel)[5] = value;
    return image;
}

}  // namespace

TEST_CASE("Film file: every number comes back, and makes the same image again") {
    const TempFolder folder;
    const Film film = numbered();
    const Image image = to_image(film, kLabels);
    write_exr(folder / "image.exr", image);
    Labels labels;
    const Film back = film_of(read_exr(folder / "image.exr"), labels);
    CHECK(back.width == 3);
    CHECK(back.height == 2);
    CHECK(back.samples == film.samples);
    CHECK(back.coverage == film.coverage);
    CHECK(back.distance == film.distance);
    REQUIRE(back.wavelengths_nm.size() == 2);
    CHECK(back.wavelengths_nm[1] == near(450.6666666, 1e-6));
    constexpr double kFloat = 1.2e-7;  // two roundings
    for (std::size_t i = 0; i < film.pixel_count(); ++i)
        for (std::size_t w = 0; w < 2; ++w) {
            const PixelStokes &p = film.at(i, w), &q = back.at(i, w);
            CHECK(q.mean.s0 == Approx(p.mean.s0).epsilon(kFloat));
            CHECK(q.mean.s1 == Approx(p.mean.s1).epsilon(kFloat));
            CHECK(q.mean.s2 == Approx(p.mean.s2).epsilon(kFloat));
            CHECK(q.mean.s3 == Approx(p.mean.s3).epsilon(kFloat));
            for (std::size_t e = 0; e < 7; ++e)
                CHECK(q.covariance[e] == Approx(p.covariance[e]).epsilon(2 * kFloat));
            CHECK(q.replicates == film.at(i, 0).replicates);
        }
    // Ids, names and what is derived; errors of DoLP are small differences of covariances.
    const Image again = to_image(back, labels);
    CHECK(again.attributes == image.attributes);
    REQUIRE(again.channels.size() == image.channels.size());
    for (const auto& [name, values] : image.channels)
        for (std::size_t i = 0; i < values.size(); ++i) {
            CAPTURE(name, i);
            CHECK(again.channels.at(name)[i] == Approx(values[i]).epsilon(3e-6));
        }
}

TEST_CASE("Film file: instances are known by the names of material and node") {
    Labels labels;
    const Film first = film_of(to_image(numbered(), kLabels), labels);
    // The same surfaces, listed in another order, one more material, another pair.
    Film film = numbered();
    film.instance = {0, 1, 2, 3, -1, 0};
    const Labels other{
        {"blue", "green", "matte"}, {"root", "wheel", "wheel"}, {1, 2, 1, 0}, {0, 2, 1, 0}};
    const Film second = film_of(to_image(film, other), labels);
    CHECK(labels.materials == std::vector<std::string>{"matte", "green", "blue"});
    CHECK(labels.nodes == kLabels.nodes);
    CHECK(second.instance[0] == first.instance[1]);  // green root
    CHECK(second.instance[1] == first.instance[2]);  // matte second wheel
    CHECK(second.instance[2] == first.instance[3]);  // green first wheel
    CHECK(second.instance[3] == 3);                  // blue root
    CHECK(second.instance[4] == -1);
    CHECK(labels.material_of_instance == std::vector<int>{1, 0, 1, 2});
    CHECK(labels.node_of_instance == std::vector<int>{0, 2, 1, 0});
}

TEST_CASE("Film file: what no render writes is refused with channel and pixel") {
    const auto refused = [](const Image& image, const std::string& word) {
        Labels labels;
        CHECK_THROWS_WITH(film_of(image, labels), Contains(word));
    };
    const auto lacks = [](const std::string& channel) {
        Image image = to_image(numbered(), kLabels);
        image.channels.erase(channel);
        return image;
    };
    refused(spoiled("S2.440,000000nm", NAN), "channel 'S2.440,000000nm' holds nan at pixel (2,1)");
    refused(spoiled("S0.440,000000nm", -1), "'S0.440,000000nm' holds -1");
    refused(spoiled("StdErr_S3.440,000000nm", -0.1f), "'StdErr_S3.440,000000nm' holds -0.1");
    refused(spoiled("StdErr_S1.440,000000nm", INFINITY), "holds inf");
    refused(spoiled("Cov_S1S2.440,000000nm", NAN), "'Cov_S1S2.440,000000nm' holds nan");
    refused(spoiled("A", 1.5f), "'A' holds 1.5");
    refused(spoiled("Z", -1), "'Z' holds -1");
    refused(spoiled("N.samples", 2.5f), "'N.samples' holds 2.5");
    refused(spoiled("N.samples", 5e9f), "'N.samples' holds 5");
    refused(spoiled("N.replicates", 0), "'N.replicates' holds 0");
    refused(spoiled("material.id", 3), "'material.id' holds 3");
    refused(spoiled("node.id", 0), "contradict");
    refused(lacks("N.samples"), "channel 'N.samples' is missing");
    refused(lacks("Cov_S0S1.440,000000nm"), "'Cov_S0S1.440,000000nm' is missing");
    refused(lacks("S3.440,000000nm"), "'S3.440,000000nm' is missing");
    Image nameless = to_image(numbered(), kLabels);
    nameless.attributes.erase("nodeNames");
    refused(nameless, "no list 'nodeNames'");
    Image other;
    other.width = other.height = 1;
    other.channel("R");
    refused(other, "no channels S0 to S3");
}
