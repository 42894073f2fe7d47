// compare_test.cpp — malus compare as its users meet it: verdicts, exit codes, folders.
// SPDX-License-Identifier: Apache-2.0
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "malus/io/exr.h"
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

constexpr const char* kUsual = "--wavelengths 440,600 --width 24";

// Renders of the corner in black paint, 24 x 16 pixels at 440 and 600 nm.
class Renders {
  public:
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::string at(const std::string& name) const { return quoted(path(name)); }
    std::string render(const std::string& name, int seed,
                       const std::string& options = kUsual) const {
        fs::create_directories(fs::path(path(name)).parent_path());
        const Outcome result = run(
            "render " + shipped("scenes/corner.gltf") + " --sky " +
            shipped("skies/rayleigh_60.exr") + " --materials " + shipped("materials/paints.json") +
            " --assign ground=black_paint --assign wall=black_paint --final --height 16"
            " --spp 64 --quiet --no-sky-table --seed " +
            std::to_string(seed) + " " + options + " -o " + at(name));
        CAPTURE(result.err);
        REQUIRE(result.exit_code == 0);
        return at(name);
    }
    // With the blue light of one pixel three times as bright.
    std::string spoil(const std::string& name, const std::string& as) const {
        Image image = read_exr(path(name));
        for (const char* s : {"S0", "S1", "S2", "S3"})
            image.channel(spectral_channel(s, 440))[8 * 24 + 5] *= 3;
        fs::create_directories(fs::path(path(as)).parent_path());
        write_exr(path(as), image);
        return at(as);
    }

  private:
    TempFolder folder_;
};

const Json& quantity(const Json& result, const std::string& name, double nm) {
    for (const Json& q : result.at("quantities"))
        if (q.at("quantity") == name && q.at("wavelength_nm") == nm) return q;
    FAIL("no quantity " << name);
    return result;
}

}  // namespace

TEST_CASE("Compare: the verdict stands in the last line, and the exit code says it", "[cli]") {
    const Renders in;
    const std::string a = in.render("a.exr", 1), b = in.render("b.exr", 2),
                      spoiled = in.spoil("b.exr", "spoiled.exr");
    const Outcome same = run("compare " + a + " " + b);
    CHECK(same.exit_code == 0);
    CHECK(same.err.empty());
    CHECK_THAT(same.out, Contains("same: nothing beyond the error bars") && Contains("Hellinger"));
    const Outcome different = run("compare " + a + " " + spoiled);
    CHECK(different.exit_code == 3);
    CHECK_THAT(different.out,
               Contains("different: S0 440 nm differs by") && Contains("at pixel (5,8)"));
    const Outcome quiet = run("compare --quiet " + a + " " + spoiled);
    CHECK(quiet.exit_code == 3);
    CHECK(quiet.out.empty());
    // The other wavelength is as it was, and so is DoLP.
    CHECK(run("compare --quiet --wavelengths 600 " + a + " " + spoiled).exit_code == 0);
    // Of the same random numbers limits decide: 2/3 of the brighter one is the difference.
    const std::string limits =
        "compare --quiet --wavelengths 440 " + in.at("b.exr") + " " + spoiled;
    CHECK(run(limits).exit_code == 3);
    CHECK(run(limits + " --max-relative 0.666").exit_code == 3);
    CHECK(run(limits + " --max-relative 0.667").exit_code == 0);

    const Outcome json = run("compare --json " + a + " " + spoiled);
    CHECK(json.exit_code == 3);
    const Json all = Json::parse(json.out);
    CHECK(all.at("verdict") == "different");
    CHECK(all.at("errors") == "independent");
    CHECK(all.at("quantities").size() == 12);
    const Json& s0 = quantity(all, "S0", 440);
    CHECK(s0.at("differs") == true);
    CHECK(s0.at("pixel_test").at("at") == Json{{"x", 5}, {"y", 8}});
    CHECK(s0.at("pixel_test").at("t").get<double>() >
          s0.at("pixel_test").at("limit").get<double>());
    CHECK(quantity(all, "DoLP", 440).at("differs") == false);
    // The difference that the files hold.
    const Image first = read_exr(in.path("a.exr")), second = read_exr(in.path("spoiled.exr"));
    double largest = 0;
    for (std::size_t i = 0; i < first.pixel_count(); ++i)
        largest = std::max(largest, std::abs(double{spectral_data(first, "S0", 440)[i]} -
                                             double{spectral_data(second, "S0", 440)[i]}));
    CHECK(s0.at("largest").get<double>() == Approx(largest).epsilon(1e-6));
}

TEST_CASE("Compare: a folder of renders against a folder of references", "[cli]") {
    const Renders in;
    in.render("new/a.exr", 1), in.render("old/a.exr", 2);
    in.render("new/b.exr", 3);
    in.spoil("new/b.exr", "old/b.exr");
    const Outcome one = run("compare " + in.at("new") + " --baseline " + in.at("old"));
    CHECK(one.exit_code == 3);
    CHECK_THAT(one.out, Contains("a.exr  same: ") && Contains("b.exr  different: ") &&
                            Contains("different: 1 of 2 images differ"));
    in.render("old/b.exr", 4);
    const Outcome none = run("compare " + in.at("new") + " --baseline " + in.at("old"));
    CHECK(none.exit_code == 0);
    CHECK_THAT(none.out, Contains("same: 0 of 2 images differ"));

    in.render("old/c.exr", 5), in.render("new/d.exr", 6);
    const Outcome json = run("compare --json " + in.at("new") + " --baseline " + in.at("old"));
    CHECK(json.exit_code == 3);
    const Json all = Json::parse(json.out);
    CHECK(all.at("differing") == 2);
    CHECK(all.at("files").at(0).at("verdict") == "same");
    CHECK(all.at("files").at(0).at("comparison").at("quantities").size() == 12);
    CHECK(all.at("files").at(2).at("why") == "missing among the renders");
    CHECK(all.at("files").at(3).at("why") == "no reference of this name");
    // One that cannot be read is a difference, and the others are compared all the same.
    write_text(in.path("old/a.exr"), "no image");
    const Outcome broken = run("compare " + in.at("new") + " --baseline " + in.at("old"));
    CHECK(broken.exit_code == 3);
    CHECK_THAT(broken.out, Contains("b.exr  same: ") && Contains("differ"));
}

TEST_CASE("Compare: names that are no UTF-8 do not spoil the JSON", "[cli]") {
    const Renders in;
    const std::string a = in.render("a.exr", 1);
    fs::create_directories(in.path("new")), fs::create_directories(in.path("old"));
    fs::copy(in.path("a.exr"), in.path("new/b\xff.exr"));
    fs::copy(in.path("a.exr"), in.path("old/b\xff.exr"));
    const Outcome result = run("compare --json " + in.at("new") + " --baseline " + in.at("old"));
    CAPTURE(result.err);
    CHECK(result.exit_code == 0);
    const std::string name = Json::parse(result.out).at("files").at(0).at("file");
    CHECK_THAT(name, Catch::StartsWith("b") && Catch::EndsWith(".exr"));
}

TEST_CASE("Compare: a result that cannot be written is no success", "[cli]") {
    const Renders in;
    const std::string a = in.render("a.exr", 1), b = in.render("b.exr", 2);
    for (const std::string& arguments : {"compare " + a + " " + b, std::string("--help")}) {
        const int status = std::system(
            (quoted(MALUS_PROGRAM) + " " + arguments + " >/dev/full 2>" + quoted(in.path("err")))
                .c_str());
        REQUIRE(WIFEXITED(status));
        CHECK(WEXITSTATUS(status) == 1);
        CHECK(read_text(in.path("err")) ==
              "malus: standard output: not written in full (No space left on device); free space "
              "there, or write elsewhere\n");
    }
}

TEST_CASE("Compare: what cannot be compared is refused in one line", "[cli]") {
    const Renders in;
    const std::string a = in.render("a.exr", 1);
    const auto refused = [&](const std::string& arguments, const std::vector<std::string>& words) {
        const Outcome result = run("compare " + arguments);
        CAPTURE(arguments, result.err);
        CHECK(result.exit_code == 1);
        CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
        for (const std::string& word : words) CHECK_THAT(result.err, Contains(word));
    };
    refused(a + " " + in.render("small.exr", 2, "--wavelengths 440,600 --width 12"),
            {"small.exr (second image): cannot be compared with",
             "another size (24 x 16 pixels, 12 x 16 pixels)"});
    refused(
        a + " " + in.render("side.exr", 2, "--wavelengths 440,600 --width 24 --view-azimuth 10"),
        {"another view of the scene"});
    const std::string red = in.render("red.exr", 2, "--wavelengths 600 --width 24");
    refused(a + " " + red,
            {"other wavelengths (440, 600, the other 600 nm); choose --wavelengths"});
    CHECK(run("compare --quiet --wavelengths 600 " + a + " " + red).exit_code == 0);
    refused(a + " " + shipped("skies/rayleigh_60.exr"),
            {"rayleigh_60.exr (second image): cannot be compared"});
    refused(a + " " + in.at("absent.exr"), {"absent.exr: file not found"});
    refused(a + " --baseline " + in.at("absent"), {"cannot be read as a folder"});
    fs::create_directory(in.path("empty"));
    refused(
        quoted(fs::path(in.path("a.exr")).parent_path().string()) + " --baseline " + in.at("empty"),
        {"holds no image"});
    for (const std::string& wrong :
         {std::string(), a, in.at("empty") + " " + in.at("empty"),
          a + " " + a + " --baseline " + in.at("empty"), a + " " + a + " --false-alarm-rate 2",
          a + " " + a + " --false-alarm-rate 0", a + " " + a + " --max-dolp nan"})
        CHECK(run("compare " + wrong).exit_code == 2);
}
