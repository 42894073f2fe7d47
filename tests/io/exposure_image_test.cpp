// exposure_image_test.cpp — sums of samples to an EXR and back.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/exposure_image.h"

#include "malus/core/error.h"
#include "malus/io/spectral_image.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using Catch::Contains;

namespace {

// Each number another one.
Exposure numbered() {
    Exposure e(3, 2, {440, 450.6666666}, 4);
    for (std::size_t i = 0; i < e.stokes.size(); ++i) e.stokes[i] = static_cast<float>(i) / 7;
    for (std::size_t i = 0; i < e.pixel_count(); ++i) {
        e.taken[i] = static_cast<std::uint32_t>(20 + i);
        e.wanted[i] = static_cast<std::uint32_t>(40 + i);
        e.covered[i] = static_cast<std::uint32_t>(i);
        e.distance[i] = static_cast<float>(i) / 3;
        e.instance[i] = static_cast<std::int32_t>(i) - 1;
        e.votes[i] = static_cast<std::uint32_t>(2 * i);
        for (std::size_t r = 0; r < 4; ++r)
            e.kept[i * 4 + r] = static_cast<std::uint32_t>(20 + i - (r == i));
    }
    return e;
}

Image with_picture(const Exposure& e) {
    Image image;
    image.width = e.width;
    image.height = e.height;
    image.channel("S0.440,000000nm");
    image.channel("Summary");  // of another program: not one of ours
    add_exposure(image, e);
    return image;
}

}  // namespace

TEST_CASE("Exposure file: every number comes back") {
    const TempFolder folder;
    const Exposure e = numbered();
    write_exr(folder / "image.exr", with_picture(e));
    const Exposure back = read_exposure(folder / "image.exr");
    CHECK(back.width == 3);
    CHECK(back.height == 2);
    CHECK(back.replicates == 4);
    REQUIRE(back.wavelengths_nm.size() == 2);
    CHECK(back.wavelengths_nm[1] == near(450.6666666, 1e-6));
    CHECK(back.stokes == e.stokes);
    CHECK(back.kept == e.kept);
    CHECK(back.taken == e.taken);
    CHECK(back.wanted == e.wanted);
    CHECK(back.covered == e.covered);
    CHECK(back.distance == e.distance);
    CHECK(back.instance == e.instance);
    CHECK(back.votes == e.votes);
}

TEST_CASE("Exposure file: who looks at the picture does not read the sums") {
    const TempFolder folder;
    write_exr(folder / "image.exr", with_picture(numbered()));
    const Image image = read_exr(folder / "image.exr", is_picture_channel);
    CHECK(image.channels.size() == 2);
    CHECK(image.channels.count("Summary") == 1);
    CHECK(read_exr(folder / "image.exr").channels.size() == 2 + 6 + 4 + 4 * 4 * 2);
}

TEST_CASE("Exposure file: without sums, or with sums that cannot be, it is refused") {
    const TempFolder folder;
    Image plain;
    plain.width = plain.height = 1;
    plain.channel("S0.440,000000nm");
    write_exr(folder / "plain.exr", plain);
    CHECK_THROWS_WITH(read_exposure(folder / "plain.exr"),
                      Contains("plain.exr") && Contains("no sums") && Contains("anew"));
    const auto refused = [&](auto spoil, const std::string& word) {
        Exposure e = numbered();
        Image image = with_picture(e);
        spoil(image, e);
        write_exr(folder / "bad.exr", image);
        CHECK_THROWS_WITH(read_exposure(folder / "bad.exr"), Contains("bad.exr") && Contains(word));
    };
    refused([](Image& i, Exposure&) { i.channels.erase("Sum.votes"); }, "'Sum.votes' is missing");
    refused([](Image& i, Exposure&) { i.borrowed.erase("Sum2_S3.440,000000nm"); },
            "'Sum2_S3.440,000000nm' is missing");
    refused([](Image&, Exposure& e) { e.stokes[5] = NAN; }, "not finite");
    refused([](Image& i, Exposure&) { i.channels["Sum1.kept"][0] = 21; }, "contradict");
    refused([](Image& i, Exposure&) { i.channels["Sum.taken"][5] = 65; }, "contradict");
    refused([](Image& i, Exposure&) { i.channels["Sum.covered"][0] = NAN; }, "'Sum.covered' holds");
    refused([](Image& i, Exposure&) { i.channels["Sum.instance"][0] = -2; },
            "'Sum.instance' holds");
}
