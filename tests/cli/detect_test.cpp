// detect_test.cpp — malus detect as its users meet it.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "malus/io/file.h"
#include "malus/io/spectral_image.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/program.h"

using namespace malus;
using Catch::Contains;
namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr int kSize = 12;

// A target of 6 × 6 pixels in the middle of a ground of 12 × 12, made of three nodes: "vehicle" holds
// "hull" (rows 3 to 5) and "tracks" (rows 6 to 8).
Image synthetic() {
    Image image;
    image.width = image.height = kSize;
    image.attributes["nodeNames"] =
        std::vector<std::string>{"(sky)", "ground", "vehicle", "hull", "tracks", "hidden"};
    image.attributes["nodeParents"] = std::vector<std::string>{"0", "0", "0", "2", "2", "0"};
    image.attributes["materialNames"] = std::vector<std::string>{"(sky)", "black", "green"};
    for (std::size_t p = 0; p < image.pixel_count(); ++p) {
        const std::size_t x = p % kSize, y = p / kSize;
        const bool target = x >= 3 && x < 9 && y >= 3 && y < 9;
        const float jitter = 0.01f * static_cast<float>(p % 7);
        image.channel("A")[p] = 1;
        image.channel("node.id")[p] = !target ? 1 : y < 6 ? 3 : 4;
        image.channel("material.id")[p] = target ? 2 : 1;
        // S0 tells nothing; AoLP is about 0° in the target, to both sides, and 90° in the ground.
        image.channel("S0.550,000000nm")[p] = 1 + jitter;
        image.channel("S1.550,000000nm")[p] = target ? 0.2f : -0.2f;
        image.channel("S2.550,000000nm")[p] = 0.01f * (p % 2 ? 1.f : -1.f);
        image.channel("S3.550,000000nm")[p] = 0;
        image.channel("StdErr_S0.550,000000nm")[p] = 0.002f;
    }
    return image;
}

class Folder {
  public:
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::string write(const std::string& name, const Image& image) const {
        write_exr(path(name), image);
        return quoted(path(name));
    }
    Json detect(const std::string& image, const std::string& options) const {
        const Outcome result = run("detect " + image + " " + options + " --quiet --json " +
                                   quoted(path("result.json")));
        CAPTURE(result.err);
        REQUIRE(result.exit_code == 0);
        CHECK(result.out.empty());
        return Json::parse(read_text(path("result.json")));
    }

  private:
    TempFolder folder_;
};

const Json& channel(const Json& result, const std::string& name, double nm) {
    for (const Json& c : result.at("channels"))
        if (c.at("channel") == name && c.at("wavelength_nm") == nm) return c;
    FAIL("no channel " << name);
    return result;
}

}  // namespace

TEST_CASE("Detect: masks by node, material, ring, border and coverage", "[cli]") {
    const Folder in;
    const std::string image = in.write("a.exr", synthetic());
    const auto pixels = [&](const std::string& options) {
        const Json result = in.detect(image, options);
        return std::pair<int, int>(result.at("target").at("pixels"),
                                   result.at("background").at("pixels"));
    };
    using Counts = std::pair<int, int>;
    CHECK(pixels("--target vehicle --border 0") == Counts(36, 144 - 36));
    CHECK(pixels("--target hull --target tracks --border 0") == Counts(36, 108));
    CHECK(pixels("--target-material green --border 0") == Counts(36, 108));
    // 4 × 4 are left of 6 × 6, and of the ground all but 24 beside the target, the corners kept.
    CHECK(pixels("--target vehicle") == Counts(16, 108 - 24));
    CHECK(pixels("--target vehicle --border 1.5") == Counts(16, 108 - 28));
    CHECK(pixels("--target hull --background tracks --border 0") == Counts(18, 18));
    CHECK(pixels("--target hull --background vehicle --border 0") == Counts(18, 18));
    CHECK(pixels("--target hull --background-material black --border 0") == Counts(18, 108));
    // Next to the target: 24 beside it at 1, and 4 corners at √2.
    CHECK(pixels("--target vehicle --border 0 --ring 0,1") == Counts(36, 24));
    CHECK(pixels("--target vehicle --border 0 --ring 1,1.5") == Counts(36, 4));

    Image mixed = synthetic();
    mixed.channel("A")[0] = 0.5f;
    mixed.channel("A")[40] = 0.99f;
    const std::string partly = in.write("b.exr", mixed);
    const Json all = in.detect(partly, "--target vehicle --border 0 --min-coverage 0.4"),
               whole = in.detect(partly, "--target vehicle --border 0");
    CHECK(all.at("target").at("pixels") == 36);
    CHECK(all.at("background").at("pixels") == 108);
    CHECK(whole.at("target").at("pixels") == 35);
    CHECK(whole.at("background").at("pixels") == 107);
}

TEST_CASE("Detect: known contrasts come out, the best channel first", "[cli]") {
    const Folder in;
    const std::string image = in.write("a.exr", synthetic()), csv = in.path("t.csv");
    const Json result = in.detect(image, "--target vehicle --border 0 --csv " + quoted(csv));
    // S1 = ±0.2 and S2 = ±0.01: AoLP is ±½ atan(0.05) = ±1.43° about 0° and about 90°.
    const Json& aolp = channel(result, "AoLP", 550);
    CHECK(std::abs(std::remainder(aolp.at("target").at("mean").get<double>(), 180)) < 1e-4);
    CHECK(aolp.at("background").at("mean").get<double>() == near(90, 1e-4));
    CHECK(std::abs(aolp.at("difference").get<double>()) == near(90, 1e-4));
    CHECK(aolp.at("target").at("spread").get<double>() ==
          near(1.4312 * std::sqrt(36.0 / 35), 1e-3));
    CHECK(aolp.at("area") == 1);
    CHECK(aolp.at("target_is") == "farther");
    CHECK(aolp.at("weber").is_null());
    CHECK(channel(result, "S1", 550).at("area") == 1);
    CHECK(channel(result, "S1", 550).at("difference").get<double>() == near(0.4, 1e-6));
    const Json& s0 = channel(result, "S0", 550);
    CHECK(std::abs(s0.at("area").get<double>() - 0.5) < 0.1);
    CHECK(s0.at("target").at("noise").get<double>() == near(0.002, 1e-6));
    CHECK(s0.at("unit") == "W m^-2 sr^-1 nm^-1");
    CHECK(result.at("channels").size() == 7);
    // Three have an area of 1; in S1 nothing spreads, so its Fisher ratio is largest.
    CHECK(result.at("best").at("channel") == "S1");
    double before = 1;
    for (const Json& c : result.at("channels")) {
        const double strength = std::abs(c.at("area").get<double>() - 0.5);
        CHECK(strength <= before);
        before = strength;
        CHECK(c.at("roc").front() == Json::array({0.0, 0.0}));
        CHECK(c.at("roc").back() == Json::array({1.0, 1.0}));
    }
    std::istringstream lines(read_text(csv));
    std::string line;
    std::getline(lines, line);
    const auto columns = std::count(line.begin(), line.end(), ',');
    CHECK_THAT(line, Contains("wavelength_nm,channel,unit,") && Contains(",area,area_error,"));
    int rows = 0;
    for (; std::getline(lines, line); ++rows)
        CHECK(std::count(line.begin(), line.end(), ',') == columns);
    CHECK(rows == 7);

    const Outcome table = run("detect " + image + " --target vehicle --border 0");
    CHECK(table.err.empty());
    CHECK_THAT(table.out,
               Contains("target: node 'vehicle', 36 pixels") &&
                   Contains("background: all other surfaces, 108 pixels") &&
                   Contains("best of all: S1 at 550 nm, ROC area 1.0000 ± 0.0000 (target higher)"));
}

TEST_CASE("Detect: long and repeated names do not lose the end of a line", "[cli]") {
    const Folder in;
    Image image = synthetic();
    std::vector<std::string> names{"(sky)"};
    for (char letter : {'a', 'b', 'c', 'd', 'e'}) names.push_back(std::string(150, letter));
    image.attributes["nodeNames"] = names;
    const Outcome table =
        run("detect " + in.write("a.exr", image) + " --border 0 --target " + names[3] +
            " --target " + names[3] + " --target " + names[4] + " --target " + names[5]);
    CAPTURE(table.err);
    CHECK_THAT(table.out, Contains("target: node '" + names[3] + "', node '" + names[4] +
                                   "', node '" + names[5] + "', 36 pixels\n"));
}

TEST_CASE("Detect: AoLP that noise hides is left out and counted, also when nothing is left",
          "[cli]") {
    const Folder in;
    Image image = synthetic();
    std::vector<float>& error = image.channel("StdErr_DoLP.550,000000nm");
    std::fill(error.begin(), error.end(), 0.01f);
    error[3 * kSize + 3] = error[0] = error[1] = 0.1f;  // DoLP is 0.2: two errors
    const Json some = in.detect(in.write("a.exr", image), "--target vehicle --border 0");
    CHECK(channel(some, "AoLP", 550).at("target").at("unknown") == 1);
    CHECK(channel(some, "AoLP", 550).at("target").at("pixels") == 35);
    CHECK(channel(some, "AoLP", 550).at("background").at("unknown") == 2);
    CHECK(channel(some, "DoLP", 550).at("background").at("unknown") == 0);

    std::fill(error.begin(), error.end(), 1.f);
    const std::string noisy = in.write("b.exr", image);
    const Json none = in.detect(noisy, "--target vehicle --border 0");
    CHECK(channel(none, "AoLP", 550).at("area").is_null());
    CHECK(none.at("channels").back().at("channel") == "AoLP");
    CHECK(channel(none, "AoLP", 550).at("target_is") == "unknown");
    CHECK_THAT(run("detect " + noisy + " --target vehicle --border 0").out,
               Contains("AoLP at 550 nm is not known of 36 of the target's pixels and 108 of"));
}

TEST_CASE("Detect: a rendered vehicle is told from the ground, and its curves are drawn", "[cli]") {
    const Folder in;
    const std::string image = in.path("target.exr"), png = in.path("roc.png");
    REQUIRE(run("render " + shipped("scenes/target_a.glb") + " --quiet --final --sky " +
                shipped("skies/rayleigh_60.exr") + " --materials " +
                shipped("materials/paints.json") +
                " --wavelengths 440,600 --width 64 --height 48 --spp 16 -o " + quoted(image))
                .exit_code == 0);
    const Json result = in.detect(quoted(image), "--target target --png " + quoted(png));
    CHECK(read_text(png).starts_with("\x89PNG"));
    CHECK(result.at("channels").size() == 14);
    // The picture holds 3072 pixels, all of them surfaces.
    const Image read = read_exr(image);
    const int target = result.at("target").at("pixels"),
              background = result.at("background").at("pixels");
    CHECK(target > 300);
    CHECK(target + background < 3072);
    CHECK(target + background > 2500);
    // At 600 nm green paint is clamped and dark, black paint strongly polarized by reflection; the
    // picture in scenes/README.md shows it. DoLP of the target is the lower one.
    CHECK(channel(result, "DoLP", 600).at("area").get<double>() < 0.1);
    CHECK(channel(result, "DoLP", 600).at("target_is") == "lower");
    // The means of the picture itself, by the ids of the nodes: the ground stands last of them.
    const Json all = in.detect(quoted(image), "--target target --border 0 --min-coverage 0");
    const auto& names = std::get<std::vector<std::string>>(read.attributes.at("nodeNames"));
    const auto ground =
        static_cast<float>(std::find(names.begin(), names.end(), "ground") - names.begin());
    double sum = 0, pixels = 0;
    for (std::size_t p = 0; p < read.pixel_count(); ++p) {
        if (read.channels.at("node.id")[p] != ground) continue;
        sum += double{spectral_data(read, "S0", 440)[p]}, pixels += 1;
    }
    CHECK(all.at("background").at("pixels").get<double>() == pixels);
    CHECK(channel(all, "S0", 440).at("background").at("mean").get<double>() ==
          Approx(sum / pixels).epsilon(1e-6));
    const Json one = in.detect(quoted(image), "--target-material green_paint --wavelengths 600");
    CHECK(one.at("channels").size() == 7);
    CHECK(one.at("target").at("pixels") == target);
    CHECK(channel(one, "DoLP", 600) == channel(result, "DoLP", 600));
    const Json ring = in.detect(quoted(image), "--target target --ring 1,6");
    CHECK(ring.at("background").at("pixels") < background);

    // Noise makes light look polarized: without it the target's mean DoLP is lower.
    const Json debiased = in.detect(quoted(image), "--target target --debias");
    CHECK(channel(debiased, "DoLP", 600).at("target").at("mean") <
          channel(result, "DoLP", 600).at("target").at("mean"));
    CHECK(channel(debiased, "S0", 600) == channel(result, "S0", 600));
}

TEST_CASE("Detect: what cannot be told apart is refused in one line", "[cli]") {
    const Folder in;
    const Image whole = synthetic();
    const std::string image = in.write("a.exr", whole);
    const fs::path out = in.path("out.json");
    const auto refused = [&](const std::string& which, const std::string& options,
                             const std::vector<std::string>& words) {
        check_fails("detect " + which + " " + options + " --json " + quoted(out.string()), out,
                    words);
    };
    const auto spoiled = [&](auto spoil) {
        Image copy = whole;
        spoil(copy);
        return in.write("spoiled.exr", copy);
    };
    refused(image, "--target vehicel", {"a.exr: no node 'vehicel'", "did you mean 'vehicle'?"});
    refused(image, "--target-material gren", {"no material 'gren'", "did you mean 'green'?"});
    refused(image, "--target hull --background grund", {"did you mean 'ground'?"});
    refused(image, "--target hidden",
            {"a.exr: no pixel shows the target", "name another --target"});
    refused(image, "--target vehicle --target ground",
            {"a.exr: no pixel is left for the background", "covers all"});
    refused(image, "--target vehicle --background hull", {"no pixel shows the background"});
    refused(image, "--target vehicle --border 3",
            {"the target keeps 0 of 36 pixels", "--border 3", "render more pixels"});
    refused(image, "--target vehicle --ring 40,50",
            {"the background keeps 0 of 108 pixels", "--ring"});
    refused(image, "--target vehicle --wavelengths 440", {"a.exr: no 440 nm", "among 550"});
    refused(image, "--target vehicle --debias", {"a.exr: --debias: "});
    refused(spoiled([](Image& i) { i.channels.erase("node.id"); }), "--target hull",
            {"spoiled.exr: channel 'node.id' is missing"});
    refused(spoiled([](Image& i) { i.channels.erase("S2.550,000000nm"); }), "--target hull",
            {"spoiled.exr: ", "S2"});
    refused(spoiled([](Image& i) {
                for (const char* s : {"S0", "S1", "S2", "S3"})
                    i.channels.erase(spectral_channel(s, 550));
            }),
            "--target hull", {"spoiled.exr: no Stokes channels"});
    refused(shipped("skies/rayleigh_60.exr"), "--target hull", {"no list 'nodeNames'"});
    refused(quoted(in.path("absent.exr")), "--target hull", {"absent.exr: file not found"});
    check_fails("detect " + image + " --target hull --csv " + quoted(in.path("no/t.csv")),
                in.path("no"), {"there is no folder"});
    const std::string before = read_text(in.path("a.exr"));
    CHECK(run("detect " + image + " --target hull --csv " + image).exit_code == 1);
    CHECK(read_text(in.path("a.exr")) == before);
    check_fails("detect " + image + " --target hull --csv " + quoted(in.path("x")) + " --json " +
                    quoted(in.path("x")),
                in.path("x"), {"would replace"});
}

TEST_CASE("Detect: wrong usage ends with 2", "[cli]") {
    const Folder in;
    const std::string image = in.write("a.exr", synthetic());
    for (const std::string& wrong :
         {std::string(), image, image + " --target hull --ring 5,5",
          image + " --target hull --ring 5", image + " --target hull --ring -1,5",
          image + " --target hull --ring 0,3 --border 3", image + " --target hull --border nan",
          image + " --target hull --min-coverage 2", image + " --target hull --wavelengths 0"}) {
        const Outcome result = run("detect " + wrong);
        CAPTURE(wrong, result.err);
        CHECK(result.exit_code == 2);
        CHECK_FALSE(result.err.empty());
    }
}
