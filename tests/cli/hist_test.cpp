// hist_test.cpp — malus hist on images small enough to count by hand.
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <nlohmann/json.hpp>

#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/program.h"

using namespace malus;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

// Five pixels at 550 nm: sky, two of black paint, two of green. S0 is 1, so S1 is DoLP and AoLP 0°.
Image five_pixels() {
    Image image;
    image.width = 5, image.height = 1;
    const std::map<std::string, std::vector<float>> channels{
        {"S0.550,000000nm", {1, 1, 1, 1, 1}},
        {"S1.550,000000nm", {0.9f, 0.1f, 0.3f, 0.5f, 0.7f}},
        {"S2.550,000000nm", {0, 0, 0, 0, 0}},
        {"S3.550,000000nm", {0, 0, 0, 0, 0}},
        {"StdErr_DoLP.550,000000nm", {0.1f, 0.1f, 0.1f, 0.06f, 1}},
        {"AoLP.550,000000nm", {90, 10, 170, 0, 179}},
        {"A", {0, 1, 1, 1, 0.5f}},
        {"Z", {0, 2, 2, 3, 7}},
        {"node.id", {0, 1, 1, 2, 2}},
        {"material.id", {0, 1, 1, 2, 2}}};
    image.channels = channels;
    image.attributes["nodeNames"] = std::vector<std::string>{"(sky)", "ground", "hull"};
    image.attributes["materialNames"] = std::vector<std::string>{"(sky)", "black", "green"};
    return image;
}

class Folder {
  public:
    Folder() { write_exr(path("five.exr"), five_pixels()); }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::string five() const { return quoted(path("five.exr")); }
    nlohmann::json json(const std::string& options) const {
        const Outcome result =
            run("hist --quiet " + five() + " " + options + " --json " + quoted(path("h.json")));
        CAPTURE(result.err);
        REQUIRE(result.exit_code == 0);
        CHECK(result.out.empty());
        return nlohmann::json::parse(read_text(path("h.json"))).at("histograms");
    }

  private:
    TempFolder folder_;
};

}  // namespace

TEST_CASE("Hist: counts, moments and what lies outside, by hand", "[cli]") {
    const Folder in;
    // The sky is no surface: 0.1, 0.3, 0.5, 0.7 are left, of which 0.1 and 0.7 lie outside.
    const nlohmann::json all = in.json("--quantity DoLP --bins 2 --range 0.2,0.6");
    REQUIRE(all.size() == 1);
    CHECK(all[0]["quantity"] == "DoLP");
    CHECK(all[0]["wavelength_nm"] == 550);
    CHECK(all[0]["bin_width"].get<double>() == near(0.2, 1e-12));
    CHECK(all[0]["range_from"] == "asked");
    const nlohmann::json& s = all[0]["series"].at(0);
    CHECK(s["counts"] == nlohmann::json{1, 1});
    CHECK(s["pixels"] == 4);
    CHECK(s["below"] == 1);
    CHECK(s["above"] == 1);
    CHECK(s["mean"].get<double>() == near(0.4, 1e-7));
    CHECK(s["median"].get<double>() == near(0.4, 1e-7));
    CHECK(s["deviation"].get<double>() == near(std::sqrt(0.2 / 3), 1e-7));
    CHECK(all[0]["distances"].empty());

    const nlohmann::json three = in.json("");
    REQUIRE(three.size() == 3);  // S0, DoLP, AoLP
    CHECK(three[1]["low"] == 0);
    CHECK(three[1]["high"] == 1);
    CHECK(three[2]["high"] == 180);
    CHECK(three[2]["unit"] == "degrees");
    // 10, 170, 0 and 179 degrees: their mean is near 0, not near 90.
    const double mean = three[2]["series"][0]["mean"];
    CHECK((mean > 170 || mean < 10));
}

TEST_CASE("Hist: a series for each node and material, with distances between them", "[cli]") {
    const Folder in;
    const nlohmann::json h =
        in.json("--quantity Z,DoLP --node hull --material black --bins 2 --wavelengths 550");
    REQUIRE(h.size() == 2);
    CHECK(h[0]["quantity"] == "Z");
    CHECK(h[0]["wavelength_nm"].is_null());
    CHECK(h[0]["unit"] == "m");
    CHECK(h[0]["range_from"] == "percentiles 0.1 and 99.9");
    CHECK(h[0]["low"] == 2);
    CHECK(h[0]["high"] == 7);
    const nlohmann::json& series = h[1]["series"];
    CHECK(series[0]["region"] == "node hull");
    CHECK(series[1]["region"] == "material black");
    CHECK(series[0]["counts"] == nlohmann::json{0, 2});  // 0.5 begins the upper bin
    CHECK(series[1]["counts"] == nlohmann::json{2, 0});
    const nlohmann::json& d = h[1]["distances"].at(0);
    CHECK(d["intersection"] == 0);
    CHECK(d["hellinger"] == 1);
    CHECK(d["correlation"].get<double>() == near(-1, 1e-12));
    CHECK(d["earth_movers"].get<double>() == near(0.5, 1e-12));  // one bin
}

TEST_CASE("Hist: with --noise the width falls into truth and noise", "[cli]") {
    const Folder in;
    const nlohmann::json noise = in.json("--quantity DoLP --noise").at(0)["series"].at(0)["noise"];
    // The last pixel's error of 1 says that nothing is known: 0.1, 0.3, 0.5 with 0.1, 0.1, 0.06.
    CHECK(noise["pixels_with_known_error"] == 3);
    CHECK(noise["deviation_observed"].get<double>() == near(0.2, 1e-7));
    const double variance = (0.01 + 0.01 + 0.0036) / 3;
    CHECK(noise["deviation_noise"].get<double>() == near(std::sqrt(variance), 1e-7));
    CHECK(noise["deviation_truth"].get<double>() == near(std::sqrt(0.04 - variance), 1e-7));
    CHECK(noise["noise_of_variance"].get<double>() == near(variance / 0.04, 1e-6));
    const Outcome table = run("hist --noise --quantity DoLP " + in.five());
    CHECK_THAT(table.out, Contains("DoLP, 550 nm: 100 bins of 0.01 from 0 to 1") &&
                              Contains("surfaces") && Contains("19.7 %"));
}

TEST_CASE("Hist: CSV has a row for each bin and for what lies outside", "[cli]") {
    const Folder in;
    const std::string csv = in.path("h.csv"), png = in.path("h.png");
    const Outcome result = run("hist --quantity DoLP --bins 2 --range 0.2,0.6 " + in.five() +
                               " --csv " + quoted(csv) + " --png " + quoted(png));
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    const std::string start = "DoLP,550," + in.path("five.exr") + ",surfaces,";
    CHECK(read_text(csv) == "quantity,wavelength_nm,image,region,low,high,count,share,density\n" +
                                start + "-inf,0.2,1,0.25,\n" + start + "0.2,0.4,1,0.25,1.25\n" +
                                start + "0.4,0.6,1,0.25,1.25\n" + start + "0.6,inf,1,0.25,\n");
    CHECK(read_text(png).substr(1, 3) == "PNG");
}

TEST_CASE("Hist: two images are overlaid, of the second what the first has", "[cli]") {
    const Folder in;
    Image other = five_pixels();
    other.channel("S1.550,000000nm") = {0, 0.1f, 0.1f, 0.1f, 0.1f};
    const std::string b = in.path("b.exr");
    write_exr(b, other);
    const nlohmann::json h = in.json(quoted(b) + " --quantity DoLP --bins 4");
    REQUIRE(h[0]["series"].size() == 2);
    CHECK(h[0]["series"][0]["counts"] == nlohmann::json{1, 1, 2, 0});
    CHECK(h[0]["series"][1]["counts"] == nlohmann::json{4, 0, 0, 0});
    // Mass ½ goes two bins and ¼ one bin of 0.25.
    CHECK(h[0]["distances"][0]["earth_movers"].get<double>() == near(0.3125, 1e-12));
    for (const char* s : {"S0", "S1", "S2", "S3"})
        other.channels.erase(std::string(s) + ".550,000000nm");
    for (const char* s : {"S0", "S1", "S2", "S3"})
        other.channel(std::string(s) + ".440,000000nm") = {1, 1, 1, 1, 1};
    write_exr(b, other);
    check_fails("hist " + in.five() + " " + quoted(b) + " --json " + quoted(in.path("x.json")),
                in.path("x.json"), {"b.exr: no 550 nm", "440"});
}

TEST_CASE("Hist: what cannot be counted is refused in one line, and nothing is written", "[cli]") {
    const Folder in;
    const std::string out = in.path("out.json");
    const auto refused = [&](const std::string& options, const std::vector<std::string>& words) {
        check_fails("hist " + in.five() + " --json " + quoted(out) + " " + options, out, words);
    };
    refused("--quantity DoLp", {"five.exr: no quantity 'DoLp'", "did you mean 'DoLP'"});
    refused("--quantity S1/S0 --noise", {"five.exr: --noise: no error of S1/S0, 550 nm is known"});
    refused("--node hul", {"no node 'hul'", "did you mean 'hull'"});
    refused("--material blak", {"no material 'blak'", "did you mean 'black'"});
    refused("--debias", {"five.exr", "is missing"});
    refused("--wavelengths 500", {"five.exr: no 500 nm", "550"});
    refused(quoted(in.path("absent.exr")), {"absent.exr: file not found"});
    refused("--csv " + quoted(in.path("no/h.csv")), {"h.csv: cannot be written"});
    refused("--csv " + quoted(out), {"would replace"});
    Image sky = five_pixels();
    sky.channel("A") = {0, 0, 0, 0, 0};
    sky.channel("node.id") = {0, 0, 0, 0, 0};
    write_exr(in.path("sky.exr"), sky);
    refused(quoted(in.path("sky.exr")), {"sky.exr: no pixel shows surfaces"});
    refused(quoted(in.path("sky.exr")) + " --node hull", {"sky.exr: no pixel shows node hull"});
    const std::string before = read_text(in.path("five.exr"));
    CHECK(run("hist " + in.five() + " --json " + in.five()).exit_code == 1);
    CHECK(read_text(in.path("five.exr")) == before);
    for (const char* usage : {"", "--bins 0", "--range 1,0 --quantity S0", "--range 0,1",
                              "--range 1 --quantity S0", "--wavelengths -1"})
        CHECK(run("hist " + (*usage ? in.five() : std::string()) + " " + usage).exit_code == 2);
    CHECK(run("hist --quantity S1 --range -0.5,0.5 " + in.five()).exit_code == 0);
}

TEST_CASE("Hist: of a render, debiased DoLP is smaller", "[cli]") {
    const Folder in;
    const std::string image = in.path("panel.exr");
    REQUIRE(
        run(small_render(image, "--quiet --final --no-sky-table --wavelengths 440")).exit_code ==
        0);
    const auto mean = [&](const std::string& options) {
        const std::string out = in.path("m.json");
        REQUIRE(run("hist --quiet --quantity DoLP " + options + quoted(image) + " --json " +
                    quoted(out))
                    .exit_code == 0);
        return nlohmann::json::parse(read_text(out))["histograms"][0]["series"][0]["mean"]
            .get<double>();
    };
    const double raw = mean(""), debiased = mean("--debias ");
    CHECK(debiased < raw);
    CHECK(debiased > 0);
}
