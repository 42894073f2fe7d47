// merge_test.cpp — malus merge as its users meet it.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/merge.h"
#include "malus/io/file.h"
#include "malus/io/film_image.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/program.h"

using namespace malus;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

// Small renders in a folder of their own.
class Renders {
  public:
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::string render(const std::string& name, const std::string& more,
                       const std::string& size = "--width 8 --height 8 --spp 8") const {
        const Outcome result = run(small_render(path(name), "--quiet " + more, size));
        CAPTURE(result.err);
        REQUIRE(result.exit_code == 0);
        return path(name);
    }
    std::string merge(const std::vector<std::string>& images, const std::string& name) const {
        const Outcome result = run(arguments(images, name));
        CAPTURE(result.err);
        REQUIRE(result.exit_code == 0);
        return path(name);
    }
    std::string arguments(const std::vector<std::string>& images, const std::string& name) const {
        std::string all = "merge --quiet";
        for (const std::string& image : images) all += " " + quoted(image);
        return all + " -o " + quoted(path(name));
    }

  private:
    TempFolder folder_;
};

// To 1e-6, and 1e-7 of the channel's largest; errors of DoLP and AoLP, which are small differences of
// covariances, to 1e-5.
void check_same(const Image& a, const Image& b) {
    REQUIRE(a.channels.size() == b.channels.size());
    for (const auto& [name, values] : a.channels) {
        const bool derived = name.starts_with("StdErr_DoLP") || name.starts_with("StdErr_AoLP");
        double largest = 0;
        for (float v : values) largest = std::max(largest, std::abs(double{v}));
        for (std::size_t i = 0; i < values.size(); ++i) {
            CAPTURE(name, i);
            CHECK(double{b.channels.at(name)[i]} ==
                  near(values[i],
                       (derived ? 1e-5 : 1e-6) * std::abs(double{values[i]}) + 1e-7 * largest));
        }
    }
}

}  // namespace

TEST_CASE("Merge: the image is the mean of the renders, and says what it is of", "[cli]") {
    const Renders in;
    const std::string a = in.render("a.exr", "--seed 1"),
                      b = in.render("b.exr", "--seed 22 --final --debias",
                                    "--width 8 --height 8 --spp 40");
    const std::string c = in.path("c.exr");
    const Outcome result = run("merge " + quoted(a) + " " + quoted(b) + " -o " + quoted(c));
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    CHECK(result.err.empty());
    CHECK_THAT(result.out, Contains("2 images, seeds 1, 22; 48 samples a pixel") &&
                               Contains("440 nm S0") && Contains("DoLP"));
    const Image first = read_exr(a), second = read_exr(b), merged = read_exr(c);
    CHECK(merged.channels.size() == first.channels.size());
    Labels labels;
    Film film = film_of(first, labels);
    merge_into(film, film_of(second, labels));
    CHECK(merged.channels == to_image(film, labels).channels);
    // By hand for one number: weights 8 and 40 of 48.
    const auto at = [](const Image& image) { return double{spectral_data(image, "S0", 550)[27]}; };
    CHECK(at(merged) == Approx((8 * at(first) + 40 * at(second)) / 48).epsilon(1e-6));

    CHECK(*merged.text("seed") == "1, 22");
    CHECK(std::get<int>(merged.attributes.at("samplesPerPixel")) == 48);
    CHECK(std::get<3>(merged.attributes.at("mergedFrom")) == std::vector<std::string>{a, b});
    CHECK_THAT(*merged.text("commandLine"), Contains("merge ") && Contains("c.exr"));
    CHECK(*merged.text("dolpEstimator") == "raw");
    for (const char* shared : {"sceneHash", "scene", "sky", "wavelengths", "malusVersion", "view",
                               "stokesReferenceFrame", "maxDepth", "materialNames", "nodeNames"})
        CHECK(merged.attributes.at(shared) == first.attributes.at(shared));
    CHECK(*merged.number("wallTime") ==
          Approx(*first.number("wallTime") + *second.number("wallTime")));

    REQUIRE(run("merge --debias --quiet " + quoted(a) + " " + quoted(b) + " -o " + quoted(c))
                .exit_code == 0);
    CHECK(*read_exr(c).text("dolpEstimator") == "MAS");
    CHECK(read_exr(c).channels == to_image(film, labels, DolpEstimator::kDebiased).channels);
    CHECK(run("info " + quoted(c)).exit_code == 0);
}

TEST_CASE("Merge: any grouping gives the same image", "[cli]") {
    const Renders in;
    std::vector<std::string> images;
    for (const char* seed : {"1", "2", "3"})
        images.push_back(in.render("render" + std::string(seed) + ".exr",
                                   "--replicates 4 --seed " + std::string(seed),
                                   "--width 8 --height 8 --spp " + std::string(seed) + "6"));
    const Image all = read_exr(in.merge(images, "all.exr"));
    const std::string left = in.merge({images[0], images[1]}, "left.exr");
    const std::string right = in.merge({images[1], images[2]}, "right.exr");
    const Image a = read_exr(in.merge({left, images[2]}, "a.exr"));
    const Image b = read_exr(in.merge({images[0], right}, "b.exr"));
    CHECK(*a.text("seed") == "1, 2, 3");
    CHECK(*b.text("seed") == "1, 2, 3");
    CHECK(a.attributes.at("samplesPerPixel") == all.attributes.at("samplesPerPixel"));
    check_same(all, a);
    check_same(all, b);
}

TEST_CASE("Merge: what does not belong together is refused in one line, and nothing is written",
          "[cli]") {
    const Renders in;
    const std::string a = in.render("a.exr", "--seed 1"), b = in.render("b.exr", "--seed 2");
    const std::string before = read_text(a);
    const auto refused = [&](const std::vector<std::string>& images,
                             const std::vector<std::string>& words) {
        check_fails(in.arguments(images, "c.exr"), in.path("c.exr"), words);
    };
    refused({a, a}, {"a.exr: it has seed 1 as", "a.exr has", "another --seed"});
    const std::string ab = in.merge({a, b}, "ab.exr");
    refused({ab, in.render("d.exr", "--seed 2")}, {"d.exr: it has seed 2 as", "ab.exr has"});

    const auto other = [&](const std::string& more, const std::vector<std::string>& words,
                           const std::string& size = "--width 8 --height 8 --spp 8") {
        std::vector<std::string> all{"other.exr: it is of ", "than ", "a.exr", "merge renders of"};
        all.insert(all.end(), words.begin(), words.end());
        refused({a, in.render("other.exr", "--seed 3 " + more, size)}, all);
    };
    other("", {"another size (8 x 9 pixels, 8 x 8 pixels)"}, "--width 8 --height 9 --spp 8");
    other("--wavelengths 440", {"other wavelengths", "440 nm, 440, 550, 600 nm"});
    other("--assign panel=black_paint", {"other paints", "paintsHash"});
    other("--no-sun", {"another sky", "skyHash"});
    other("--view-zenith 31", {"another view", "viewHash"});
    other("--max-depth 3", {"another --max-depth", "3, 2"});
    const std::string corner = in.path("corner.exr");
    REQUIRE(run("render " + shipped("scenes/corner.gltf") + " --quiet --sky " +
                shipped("skies/rayleigh_60.exr") + " --materials " +
                shipped("materials/paints.json") +
                " --assign '*=green_paint' --width 8 "
                "--height 8 --spp 8 --seed 3 -o " +
                quoted(corner))
                .exit_code == 0);
    refused({a, corner}, {"corner.exr: it is of another scene", "sceneHash"});
    CHECK(read_text(a) == before);
}

TEST_CASE("Merge: files that are no whole renders are refused in one line", "[cli]") {
    const Renders in;
    const std::string a = in.render("a.exr", "--seed 1"), b = in.render("b.exr", "--seed 2");
    const auto refused = [&](const std::string& image, const std::vector<std::string>& words) {
        check_fails(in.arguments({a, image}, "c.exr"), in.path("c.exr"), words);
    };
    const auto spoiled = [&](auto spoil) {
        Image image = read_exr(b);
        spoil(image);
        write_exr(in.path("spoiled.exr"), image);
        return in.path("spoiled.exr");
    };
    refused(MALUS_SOURCE_DIR "/skies/rayleigh_60.exr",
            {"rayleigh_60.exr: cannot be merged", "no wavelengths", "not written by malus render"});
    for (const char* entry : {"skyHash", "seed", "samplesPerPixel", "malusVersion"})
        refused(spoiled([&](Image& i) { i.attributes.erase(entry); }),
                {"spoiled.exr", "the header has no " + std::string(entry)});
    refused(spoiled([](Image& i) { i.attributes["malusVersion"] = "0.0.1"; }),
            {"another version of malus", "0.0.1, 0.1.0"});
    refused(spoiled([](Image& i) { i.attributes["seed"] = "2; 3"; }), {"seed '2; 3'"});
    refused(spoiled([](Image& i) { i.channels.erase("N.replicates"); }),
            {"channel 'N.replicates' is missing", "anew"});
    refused(spoiled([](Image& i) { i.channel("S1.550,000000nm")[9] = NAN; }),
            {"spoiled.exr", "'S1.550,000000nm' holds nan at pixel (1,1)", "anew"});
    refused(spoiled([](Image& i) { i.channel("StdErr_S0.440,000000nm")[0] = -1; }),
            {"'StdErr_S0.440,000000nm' holds -1"});
    refused(spoiled([](Image& i) {
                for (const char* s : {"S0", "S1", "S2", "S3"})
                    i.channels.erase(spectral_channel(s, 600));
            }),
            {"spoiled.exr", "differ in size or wavelengths"});
    refused(in.path("absent.exr"), {"absent.exr: file not found"});
    write_text(in.path("text.exr"), "not an image");
    refused(in.path("text.exr"), {"text.exr: not an OpenEXR file"});
    const std::string cut = in.render("short.exr", "--seed 4");
    fs::resize_file(cut, fs::file_size(cut) / 2);
    refused(in.path("short.exr"), {"short.exr: cannot be read"});
}

TEST_CASE("Merge: usage, and outputs that would replace an input", "[cli]") {
    const Renders in;
    const std::string a = in.render("a.exr", "--seed 1"), b = in.render("b.exr", "--seed 2");
    CHECK(run("merge").exit_code == 2);
    CHECK(run("merge " + quoted(a) + " " + quoted(b)).exit_code == 2);
    CHECK(run(in.arguments({a}, "c.exr")).exit_code == 2);
    CHECK_FALSE(fs::exists(in.path("c.exr")));
    const std::string before = read_text(a);
    const Outcome same = run(in.arguments({a, b}, "a.exr"));
    CHECK(same.exit_code == 1);
    CHECK(same.one_line());
    CHECK_THAT(same.err, Contains("would replace"));
    CHECK(read_text(a) == before);
    check_fails(in.arguments({a, b}, "c.png"), in.path("c.png"), {"name it .exr"});
    check_fails(in.arguments({a, b}, "no/c.exr"), in.path("no/c.exr"), {"there is no folder"});
    // A merged image cannot be gone on with, but looked at.
    const std::string c = in.merge({a, b}, "c.exr");
    check_fails(small_render(in.path("d.exr"), "--quiet --resume " + quoted(c),
                             "--width 8 --height 8 --spp 64"),
                in.path("d.exr"), {"c.exr", "no sums", "merged"});
    CHECK(run("preview " + quoted(c)).exit_code == 0);
}
