// exposure_file_test.cpp — sums of samples to a file and back.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/exposure_file.h"

#include "malus/core/error.h"
#include "malus/io/exr.h"
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
        e.distance[i] = 1e12f * static_cast<float>(i) / 3;
        e.instance[i] = static_cast<std::int32_t>(i) - 1;
        e.votes[i] = static_cast<std::uint32_t>(2 * i);
        for (std::size_t r = 0; r < 4; ++r)
            e.kept[i * 4 + r] = static_cast<std::uint32_t>(20 + i - (r == i));
    }
    return e;
}

}  // namespace

TEST_CASE("Exposure file: every number comes back") {
    const TempFolder folder;
    const Exposure e = numbered();
    const auto path = sums_path(folder / "image.exr");
    CHECK(path.filename() == "image.exr.sums");
    write_exposure(path, e);
    const Exposure back = read_exposure(path);
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
    CHECK(fingerprint(back) == fingerprint(e));
    const auto changed = [&](auto field) {
        Exposure other = e;
        (other.*field).back() = 2 * (other.*field).back() + 1;
        return fingerprint(other) != fingerprint(e);
    };
    CHECK((changed(&Exposure::stokes) && changed(&Exposure::kept) && changed(&Exposure::taken)));
    CHECK((changed(&Exposure::wanted) && changed(&Exposure::covered)));
    CHECK((changed(&Exposure::distance) && changed(&Exposure::instance)));
    CHECK(changed(&Exposure::votes));
}

TEST_CASE("Exposure file: sums that cannot be any render's are refused") {
    const TempFolder folder;
    const auto path = folder / "bad.exr.sums";
    const auto refused = [&](auto spoil, const std::string& word) {
        write_exposure(path, numbered());
        Image image = read_exr(path);
        spoil(image.channels);
        write_exr(path, image);
        CHECK_THROWS_WITH(read_exposure(path), Contains("bad.exr.sums") && Contains(word));
    };
    using Channels = std::map<std::string, std::vector<float>>;
    const auto renamed = [](const std::string& from) {
        return [from](Channels& c) { c["Sum.other"] = c[from], c.erase(from); };
    };
    refused(renamed("Sum.votes"), "'Sum.votes' is missing");
    refused(renamed("Sum2_S3.440,000000nm"), "'Sum2_S3.440,000000nm' is missing");
    refused([](Channels& c) { c["Sum4.kept"] = c["Sum3.kept"]; }, "do not fit 5 replicates");
    refused([](Channels& c) { c["Sum.distance"][2] = INFINITY; }, "'Sum.distance' holds");
    refused([](Channels& c) { c["Sum1_S2.440,000000nm"][3] = NAN; }, "not finite");
    refused([](Channels& c) { c["Sum1.kept"][0] = 21; }, "contradict");
    refused([](Channels& c) { c["Sum.taken"][5] = 65; }, "contradict");
    refused([](Channels& c) { c["Sum.covered"][0] = NAN; }, "'Sum.covered' holds");
    refused([](Channels& c) { c["Sum.instance"][0] = -2; }, "'Sum.instance' holds");
    refused(
        [](Channels& c) {
            c = {{"S0.440,000000nm", c["Sum.taken"]}};
        },
        "do not fit 0 replicates");
    CHECK_THROWS_WITH(read_exposure(folder / "none.exr.sums"), Contains("not found"));
}
