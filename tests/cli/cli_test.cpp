// cli_test.cpp — the program as its users meet it: exit codes, messages, files.
// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <thread>

#include "malus/core/frame.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/sky_file.h"
#include "malus/io/spectral_image.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/program.h"

using namespace malus;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

// The pixels of an image that show nothing but a surface.
class Exr {
  public:
    explicit Exr(const std::string& path) : image_(read_exr(path)) {}
    double mean(const std::string& quantity) const {
        const std::vector<float>& data = spectral_data(image_, quantity, 440);
        double sum = 0, count = 0;
        for (std::size_t i = 0; i < data.size(); ++i) {
            if (image_.channels.at("A")[i] < 1) continue;
            sum += static_cast<double>(data[i]);
            count += 1;
        }
        return sum / count;
    }

  private:
    Image image_;
};

// Width and height, from the header that PNG begins with (ISO 15948, 11.2.2).
std::pair<int, int> png_size(const fs::path& path) {
    const std::string bytes = read_text(path);
    REQUIRE(bytes.size() > 24);
    const auto number = [&](std::size_t at) {
        int n = 0;
        for (std::size_t i = at; i < at + 4; ++i)
            n = 256 * n + static_cast<unsigned char>(bytes[i]);
        return n;
    };
    return {number(16), number(20)};
}

}  // namespace

TEST_CASE("Help: every command explains itself, fast", "[cli]") {
    for (const char* command :
         {"", "render", "sky", "sky make", "sky info", "sky import", "materials", "materials check",
          "info", "preview", "merge", "hist", "report", "brdf", "detect", "compare"}) {
        const Outcome result = run(std::string(command) + " --help");
        CAPTURE(command);
        CHECK(result.exit_code == 0);
        CHECK_THAT(result.out, Contains("Usage") || Contains("usage"));
    }
    CHECK_THAT(run("render --help").out,
               Contains("degrees") && Contains("nm") && Contains("--max-depth") && Contains("64"));
    CHECK(run("--version").out == "0.1.0\n");
    // Linking OpenImageIO by mistake would cost 300 ms and more; the best of several starts.
    double best = 1e9;
    for (int i = 0; i < 10; ++i) {
        const auto start = std::chrono::steady_clock::now();
        run("--help");
        best = std::min(
            best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    CHECK(best < 0.05);
}

TEST_CASE("Usage: wrong options exit with 2", "[cli]") {
    CHECK(run("").exit_code == 2);
    CHECK(run("rendr").exit_code == 2);
    CHECK_THAT(run("rendr").err, Contains("did you mean 'render'"));
    CHECK(run("render").exit_code == 2);
    CHECK(run("render --spp many").exit_code == 2);
    CHECK(run("render --width 0").exit_code == 2);
    CHECK(run("render --camera a --view-zenith 3").exit_code == 2);
    CHECK(run("render --view-zenith nan").exit_code == 2);
    CHECK(run("render --seed -1").exit_code == 2);
    CHECK(run("preview").exit_code == 2);
}

TEST_CASE("Render: an image with every channel and attribute of the format", "[cli]") {
    const TempFolder folder;
    const std::string image = (folder / "an image.exr").string();
    const Outcome result =
        run(small_render(image, "--stats " + quoted((folder / "stats.json").string()) +
                                    " --seed 5 --wavelengths 600,440"));
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    CHECK_THAT(result.out,
               Contains("rays/s") && Contains("440 nm") && Contains("0 samples refused"));
    const Image exr = read_exr(image);
    for (const char* nm : {"440,000000nm", "600,000000nm"})
        for (const char* quantity :
             {"S0", "S1", "S2", "S3", "DoLP", "AoLP", "StdErr_S0", "StdErr_DoLP", "StdErr_AoLP"})
            CHECK(exr.channels.count(std::string(quantity) + "." + nm) == 1);
    for (const char* channel : {"A", "Z", "material.id", "node.id", "N.samples", "R", "G", "B"})
        CHECK(exr.channels.count(channel) == 1);
    CHECK(*exr.text("malusVersion") == "0.1.0");
    CHECK_THAT(*exr.text("commandLine"), Contains("--seed 5") && Contains("an image.exr"));
    CHECK(*exr.text("seed") == "5");
    CHECK(exr.number("wallTime") != nullptr);
    CHECK(*exr.number("sunZenith") == 60);
    CHECK(*exr.number("sunAzimuth") == 135);
    CHECK(exr.number("viewZenith") != nullptr);
    CHECK(exr.text("stokesReferenceFrame") != nullptr);
    const std::string stats = read_text(folder / "stats.json");
    for (const char* key : {"version",
                            "scene",
                            "wavelengths_nm",
                            "width",
                            "height",
                            "spp",
                            "max_depth",
                            "seed",
                            "threads",
                            "wall_s",
                            "load",
                            "build",
                            "render",
                            "write",
                            "paths",
                            "rays",
                            "rays_per_s",
                            "rejected_samples",
                            "peak_memory_mib",
                            "sky_grid",
                            "error",
                            "rms_S0_relative",
                            "rms_DoLP",
                            "p95_DoLP",
                            "stopped_by"})
        CHECK_THAT(stats, Contains("\"" + std::string(key) + "\""));
}

TEST_CASE("Render: the program's pixels are those of the reference", "[cli]") {
    // panel.gltf under a CSV map of an analytic sky, seen from an odd azimuth.
    const TempFolder folder;
    const auto sky =
        reference::rayleigh_sky(direction(to_radians(50), to_radians(200)), 1.0, 0.8, 0.15);
    std::ofstream csv(folder / "sky.csv");
    csv.precision(10);
    csv << "wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3\n";
    for (int z = 1; z < 180; z += 2)
        for (int a = 0; a < 360; ++a) {
            const auto S = sky(direction(to_radians(z / 2.0), to_radians(a)));
            csv << "440," << z / 2.0 << ',' << a << ',' << S[0] << ',' << S[1] << ',' << S[2] << ','
                << S[3] << '\n';
        }
    csv.close();
    const std::string image = (folder / "image.exr").string();
    REQUIRE(run("render " + shipped("scenes/panel.gltf") + " --sky " +
                quoted((folder / "sky.csv").string()) + " --materials " +
                shipped("materials/paints.json") + " --assign panel=black_paint -o " +
                quoted(image) +
                " --view-zenith 50 --view-azimuth 67 --width 40 --height 40 --spp 512")
                .exit_code == 0);
    const Exr exr(image);
    const Camera camera = look_at({0, 0, 0}, 50, 67, 1);
    const reference::Integral expected = reference::panel(
        reference_paint(black_paint(), 440), {0, 1, 0}, -camera.forward, camera.right, sky, 1e-6);
    for (std::size_t c = 0; c < 4; ++c) {
        CAPTURE(c, expected.value[c]);
        CHECK(exr.mean("S" + std::to_string(c)) ==
              near(expected.value[c], 0.002 * expected.value[0]));
    }
}

TEST_CASE("Render: outputs do not replace inputs, devices or each other", "[cli]") {
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string();
    fs::copy_file(MALUS_SOURCE_DIR "/skies/rayleigh_60.exr", folder / "sky.exr");
    const std::string sky = (folder / "sky.exr").string();
    const Outcome same =
        run("render " + shipped("scenes/panel.gltf") + " --sky " + quoted(sky) + " --materials " +
            shipped("materials/paints.json") + " -o " + quoted(sky));
    CHECK(same.exit_code == 1);
    CHECK_THAT(same.err, Contains("would replace"));
    CHECK(read_text(sky) == read_text(MALUS_SOURCE_DIR "/skies/rayleigh_60.exr"));
    CHECK(run(small_render(image, "--stats " + quoted(image))).exit_code == 1);
    CHECK_THAT(run(small_render((folder / "image.png").string())).err, Contains("name it .exr"));
    REQUIRE(::mkfifo((folder / "pipe.exr").c_str(), 0600) == 0);
    CHECK_THAT(run(small_render((folder / "pipe.exr").string())).err, Contains("a pipe"));
    fs::create_symlink(folder / "real.exr", folder / "link.exr");
    write_text(folder / "real.exr", "old");
    CHECK(run(small_render((folder / "link.exr").string())).exit_code == 0);
    CHECK(fs::is_symlink(folder / "link.exr"));
    CHECK(read_exr(folder / "real.exr").width == 8);
}

TEST_CASE("Render: the same pixels at one and at two threads", "[cli]") {
    const TempFolder folder;
    const std::string one = (folder / "one.exr").string(), two = (folder / "two.exr").string();
    REQUIRE(run(small_render(one, "--threads 1", "--width 40 --height 40")).exit_code == 0);
    REQUIRE(run(small_render(two, "--threads 2", "--width 40 --height 40")).exit_code == 0);
    CHECK(read_exr(one).channels == read_exr(two).channels);
}

TEST_CASE("Render: a quiet run says nothing, options may come from a file", "[cli]") {
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string();
    const Outcome quiet = run(small_render(image, "--quiet"));
    CHECK(quiet.exit_code == 0);
    CHECK(quiet.out.empty());
    CHECK(quiet.err.empty());
    for (const char* section : {"", "[render]\n"}) {
        write_text(folder / "options.toml", std::string(section) + "seed = 9\nmargin = 0.2\n");
        const std::string config = "--config " + quoted((folder / "options.toml").string());
        REQUIRE(run(small_render(image, config)).exit_code == 0);
        CHECK(*read_exr(image).text("seed") == "9");
    }
    REQUIRE(
        run("--config " + quoted((folder / "options.toml").string()) + " " + small_render(image))
            .exit_code == 0);
    write_text(folder / "sky.toml", "width = 12\n");
    REQUIRE(run("sky make -o " + quoted((folder / "sky.exr").string()) + " --config " +
                quoted((folder / "sky.toml").string()))
                .exit_code == 0);
    CHECK(read_exr(folder / "sky.exr").width == 12);
    write_text(folder / "options.toml", "sppp = 9\n");
    const std::string config = "--config " + quoted((folder / "options.toml").string());
    CHECK(run(small_render(image, config)).exit_code == 2);
}

TEST_CASE("Render: bad input is one line with place, problem and remedy", "[cli]") {
    const TempFolder folder;
    const fs::path image = folder / "image.exr";
    const auto with = [&](const std::string& scene, const std::string& sky,
                          const std::string& materials, const std::string& more = "") {
        return "render " + quoted(scene) + " --quiet --sky " + quoted(sky) + " --materials " +
               quoted(materials) + " -o " + quoted(image.string()) + " --width 4 --height 4 " +
               more;
    };
    const std::string scene = MALUS_SOURCE_DIR "/scenes/panel.gltf";
    const std::string sky = MALUS_SOURCE_DIR "/skies/rayleigh_60.exr";
    const std::string paints = MALUS_SOURCE_DIR "/materials/paints.json";
    const std::string absent = (folder / "absent").string();

    check_fails(with(absent + ".gltf", sky, paints), image, {"absent.gltf"});
    check_fails(with(scene, absent + ".exr", paints), image, {"absent.exr: file not found"});
    check_fails(with(scene, sky, absent + ".json"), image, {"absent.json: file not found"});
    write_text(folder / "broken.json", "{\"materials\": ");
    check_fails(with(scene, sky, (folder / "broken.json").string()), image,
                {"broken.json: not valid JSON", "mend"});
    check_fails(with(scene, sky, paints), image, {"'panel'", "--assign"});
    check_fails(with(scene, sky, paints, "--assign '*=gren_paint'"), image,
                {"unknown material", "did you mean 'green_paint'?"});
    check_fails(with(scene, sky, paints, "--assign 'pannel=green_paint'"), image,
                {"did you mean 'panel'?"});
    check_fails(with(scene, sky, paints, "--assign '*=green_paint' --wavelengths 500"), image,
                {"rayleigh_60.exr: no light at 500 nm", "440, 550, 600"});
    check_fails(with(scene, sky, paints, "--assign '*=green_paint' --wavelengths 440,600,440"),
                image, {"--wavelengths: 440 nm stands twice"});
    write_text(folder / "infrared.csv",
               "wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3\n900,45,0,1,0,0,0\n");
    check_fails(with(scene, (folder / "infrared.csv").string(), paints, "--assign '*=green_paint'"),
                image, {"infrared.csv", "none of its wavelengths"});
    check_fails(with(scene, (folder / "infrared.csv").string(), paints,
                     "--assign '*=green_paint' --wavelengths 900"),
                image, {"green_paint: no data at 900 nm", "440 to 600"});
    write_text(folder / "empty.gltf", R"({"asset": {"version": "2.0"}, "nodes": [{"name": "n"}]})");
    check_fails(with((folder / "empty.gltf").string(), sky, paints), image,
                {"empty.gltf", "triangle"});
    check_fails(with(scene, sky, paints, "--assign '*=green_paint' --camera nose"), image,
                {"no camera 'nose'"});
    check_fails(with(scene, sky, paints, "--assign '*=green_paint' --look-at pane"), image,
                {"did you mean 'panel'?"});

    const std::string unwritable = (folder / "no/folder/image.exr").string();
    const Outcome result = run(small_render(unwritable, "--quiet"));
    CHECK(result.exit_code == 1);
    CHECK(result.one_line());
    CHECK_THAT(result.err, Contains("image.exr: cannot be written") && Contains("folder"));
}

TEST_CASE("Render: every hostile glTF file is refused in one line or rendered", "[cli]") {
    if (std::string(MALUS_SHARED_DATA).empty()) {
        WARN("no shared reference data beside this checkout; skipped");
        return;
    }
    const fs::path root = fs::path(MALUS_SHARED_DATA) / "gltf";
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string();
    std::ifstream table(root / "expected.csv");
    int refused = 0, rendered = 0;
    std::string line;
    std::getline(table, line);
    while (std::getline(table, line)) {
        const std::size_t comma = line.find(',');
        const std::string file = line.substr(0, comma);
        const std::string expect = line.substr(comma + 1, line.find(',', comma + 1) - comma - 1);
        if (expect.starts_with("OK") && fs::file_size(root / file) > 1000000) continue;
        fs::remove(image);
        const Outcome result = run(
            "render " + quoted((root / file).string()) + " --quiet --sky " +
            shipped("skies/rayleigh_60.exr") + " --materials " + shipped("materials/paints.json") +
            " --assign '*=black_paint' --width 6 --height 6 --spp 8 -o " + quoted(image));
        CAPTURE(file, result.err);
        if (expect == "REJECT") CHECK(result.exit_code == 1);
        if (expect.starts_with("OK")) CHECK(result.exit_code == 0);
        CHECK((result.exit_code == 0 || (result.exit_code == 1 && result.one_line())));
        CHECK(fs::exists(image) == (result.exit_code == 0));
        ++(result.exit_code == 0 ? rendered : refused);
    }
    CHECK(refused > 40);
    CHECK(rendered > 20);
}

TEST_CASE("Ctrl-C: before each pixel has samples the render ends in one line and leaves no file",
          "[cli]") {
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string();
    const std::string err = (folder / "err").string();
    // 2.25 million pixels: 8 samples of each take 8 s and more.
    const std::string command =
        quoted(MALUS_PROGRAM) + " " +
        small_render(image, "", "--width 1500 --height 1500 --spp 64 --wavelengths 440");
    const int status = std::system(("timeout -s INT 1 " + command + " 2>" + quoted(err)).c_str());
    // timeout reports 124 when it had to send its signal.
    CHECK(WEXITSTATUS(status) == 124);
    CHECK_THAT(read_text(err), Contains("not written") && Contains("stopped"));
    CHECK(std::distance(fs::directory_iterator(fs::path(image).parent_path()), {}) == 1);
}

TEST_CASE(
    "Ctrl-C: the image has the samples that were taken, and --resume goes on to the same bits",
    "[cli]") {
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string();
    const std::string whole = (folder / "whole.exr").string();
    const std::string err = (folder / "err").string();
    const std::string size = "--width 16 --height 12 --spp 32768";
    const std::string command = "timeout --preserve-status -s INT 1 " + quoted(MALUS_PROGRAM) + " ";
    const int status = std::system(
        (command + small_render(image, "", size) + " >/dev/null 2>" + quoted(err)).c_str());
    CHECK(WEXITSTATUS(status) == 0);
    CHECK_THAT(read_text(err), Contains("stopped by a signal") && Contains("--resume"));
    const Image stopped = read_exr(image);
    CHECK(*stopped.text("stoppedBy") == "signal");
    for (float n : stopped.channels.at("N.samples")) CHECK((n >= 8 && n < 32768));
    for (std::size_t i = 0; i < stopped.pixel_count(); ++i)
        CHECK(
            (stopped.channels.at("A")[i] == 0 || spectral_data(stopped, "StdErr_S0", 440)[i] > 0));
    REQUIRE(run(small_render(image, "--resume " + quoted(image), size)).exit_code == 0);
    REQUIRE(run(small_render(whole, "", size)).exit_code == 0);
    CHECK(read_exr(image).channels == read_exr(whole).channels);
    // One pixel of very many samples ends as soon.
    const std::string pixel = small_render(image, "", "--width 1 --height 1 --spp 8000000");
    CHECK(WEXITSTATUS(std::system((command + pixel + " >/dev/null 2>&1").c_str())) == 0);
}

TEST_CASE("Resume: adds samples as if the render had never stopped, in place by default", "[cli]") {
    const TempFolder folder;
    const std::string part = (folder / "part.exr").string(),
                      whole = (folder / "whole.exr").string();
    const std::string scene = "render " + shipped("scenes/target_a.glb") + " --sky " +
                              shipped("skies/rayleigh_60.exr") + " --materials " +
                              shipped("materials/paints.json") +
                              " --width 24 --height 18 --seed 5 --quiet";
    REQUIRE(run(scene + " --spp 24 -o " + quoted(part)).exit_code == 0);
    REQUIRE(run(scene + " --spp 40 --threads 1 --resume " + quoted(part)).exit_code == 0);
    REQUIRE(run(scene + " --spp 1000 --resume " + quoted(part) + " -o " + quoted(part)).exit_code ==
            0);
    REQUIRE(run(scene + " --spp 1000 -o " + quoted(whole)).exit_code == 0);
    const Image a = read_exr(part), b = read_exr(whole);
    CHECK(a.channels == b.channels);
    CHECK(a.channels.at("N.samples")[0] == 1008);
}

TEST_CASE("Resume: what does not belong to the image is refused, and it stays as it was", "[cli]") {
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string(), out = (folder / "out.exr").string();
    REQUIRE(run(small_render(image, "--quiet")).exit_code == 0);
    const std::string before = read_text(image);
    const auto refused = [&](const std::string& more, const std::string& size,
                             const std::vector<std::string>& words) {
        check_fails(small_render(out, "--resume " + quoted(image) + " --quiet " + more, size), out,
                    words);
    };
    const std::string same = "--width 8 --height 8 --spp 16";
    refused("", "--width 8 --height 8 --spp 16 --no-sky-table",
            {"image.exr", "--resume", "without", "--no-sky-table"});
    refused("", "--width 8 --height 9 --spp 16", {"image.exr", "--resume", "8 x 9", "8 x 8"});
    refused("", "--width 8 --height 8 --spp 8", {"each pixel has 8 samples", "--spp"});
    refused("--seed 3", same, {"has seed 0", "--seed", "merge"});
    refused("--replicates 16", same, {"has 8 replicates", "--replicates"});
    refused("--max-depth 3", same, {"another --max-depth", "3, 2"});
    refused("--view-zenith 31", same, {"another view"});
    refused("--no-sun", same, {"another sky"});
    refused("--assign panel=black_paint", same, {"other paints"});
    refused("--wavelengths 440", same, {"other wavelengths", "440 nm, 440, 550, 600 nm"});
    CHECK(read_text(image) == before);
    REQUIRE(run(small_render(image, "--quiet", "--width 8 --height 8 --spp 24")).exit_code == 0);
    const std::string sums = read_text(image + ".sums");
    REQUIRE(run(small_render(image, "--quiet")).exit_code == 0);
    write_text(image + ".sums", sums);
    refused("", same, {"image.exr.sums are of another render", "anew"});
    fs::remove(image + ".sums");
    refused("", same, {"image.exr.sums: file not found"});
    REQUIRE(run(small_render(image, "--final --quiet")).exit_code == 0);
    CHECK_FALSE(fs::exists(image + ".sums"));
    refused("", same, {"no sums", "--final", "anew"});
    write_text(image, "not an image");
    refused("", same, {"not an OpenEXR file"});
    CHECK(run("render " + shipped("scenes/panel.gltf") + " --sky x --materials y").exit_code == 2);
}

TEST_CASE("Time limit: the command ends on time with an image of what it got", "[cli]") {
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string();
    const std::string stats = (folder / "stats.json").string();
    const auto start = std::chrono::steady_clock::now();
    REQUIRE(run(small_render(image, "--time-limit 3 --stats " + quoted(stats),
                             "--width 200 --height 200"))
                .exit_code == 0);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    // 2 % on a quiet machine; tests share theirs, and what writing will take is foreseen then with
    // the load of the moment.
    CHECK(seconds < 3.3);
    CHECK(seconds > 2.2);
    CHECK_THAT(read_text(stats), Contains("\"stopped_by\": \"time-limit\""));
    CHECK(*read_exr(image).text("stoppedBy") == "time-limit");
    CHECK(std::distance(fs::directory_iterator(fs::path(image).parent_path()), {}) == 3);
    // Each pixel gets its first samples, however short the time.
    REQUIRE(run(small_render(image, "--time-limit 0.001", "--width 20 --height 20")).exit_code ==
            0);
    const Image first = read_exr(image);
    for (float n : first.channels.at("N.samples")) CHECK(n >= 8);
}

TEST_CASE("Target error: met in 95 % of the pixels with a surface, as the image itself says",
          "[cli]") {
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string();
    const std::string scene = "render " + shipped("scenes/target_b.glb") + " --sky " +
                              shipped("skies/rayleigh_60.exr") + " --materials " +
                              shipped("materials/paints.json") + " --wavelengths 440,600";
    const Outcome result =
        run(scene + " --width 40 --height 30 --target-error 0.05 -o " + quoted(image));
    REQUIRE(result.exit_code == 0);
    CHECK_THAT(result.out, Contains("target error reached") && Contains("samples a pixel"));
    const Image read = read_exr(image);
    CHECK(*read.text("stoppedBy") == "target-error");
    double surface = 0, met = 0;
    for (std::size_t i = 0; i < read.pixel_count(); ++i) {
        if (!(read.channels.at("A")[i] > 0)) continue;
        bool good = true;
        for (double nm : {440.0, 600.0}) {
            const float s0 = spectral_data(read, "S0", nm)[i];
            good &= spectral_data(read, "StdErr_DoLP", nm)[i] <= 0.05f;
            good &= spectral_data(read, "StdErr_S0", nm)[i] <= 0.05f * s0;
        }
        surface += 1, met += good;
    }
    CHECK(surface > 500);
    CHECK(met / surface > 0.949);
    // The cap comes first where it is low.
    const std::string stats = (folder / "stats.json").string();
    REQUIRE(run(scene + " --width 40 --height 30 --target-error 0.001 --spp 64 --quiet --stats " +
                quoted(stats) + " -o " + quoted(image))
                .exit_code == 0);
    CHECK_THAT(read_text(stats), Contains("\"stopped_by\": \"spp\""));
    const Image capped = read_exr(image);
    for (float n : capped.channels.at("N.samples")) CHECK(n <= 64);
}

TEST_CASE("Sky and info: a sky is made and described", "[cli]") {
    const TempFolder folder;
    const std::string sky = (folder / "sky.exr").string();
    REQUIRE(run("sky make -o " + quoted(sky) +
                " --wavelengths 600,450 --sun-zenith 30 --sun-azimuth 90 --max-dolp 0.7 --width 72 "
                "--height 18")
                .exit_code == 0);
    const Outcome info = run("info " + quoted(sky));
    CHECK(info.exit_code == 0);
    CHECK_THAT(info.out, Contains("450, 600 nm") && Contains("sun at zenith 30, azimuth 90") &&
                             Contains("DoLP up to 0.7"));
    CHECK_THAT(*read_exr(sky).text("skyModel"), Contains("0.7"));
    CHECK(run("info " + shipped("scenes/target_a.glb")).exit_code == 0);
    CHECK_THAT(run("info " + shipped("materials/paints.json")).out, Contains("green_paint"));
    CHECK(run("info " + quoted(sky + "x")).exit_code == 1);
    const Outcome check = run("materials check " + shipped("materials/paints.json"));
    CHECK(check.exit_code == 0);
    CHECK_THAT(check.out,
               Contains("550 nm") && Contains("negative in 96 %") && Contains("reciprocity: kept"));
}

TEST_CASE("Info: the DoLP of a picture is that of its mean Stokes vector", "[cli]") {
    // Two pixels of DoLP 0.4 across each other, and one that shows no surface.
    Film film(3, 1, {550});
    film.coverage = {1, 1, 0};
    film.stokes[0].mean = {2, 0.8, 0, 0};
    film.stokes[1].mean = {2, -0.6, 0, 0};
    film.stokes[2].mean = {2, 0, 2, 0};
    film.instance = {0, 0, -1};
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string();
    write_exr(image, to_image(film, {{"paint"}, {"node"}, {0}, {0}}));
    CHECK_THAT(run("info " + quoted(image)).out, Contains("mean S0 2, its DoLP 0.05,"));
}

TEST_CASE("Skies: each shipped map is what the command in its header makes", "[cli]") {
    const TempFolder folder;
    for (const char* name : {"rayleigh_30", "rayleigh_60", "rayleigh_80", "hazy_60"}) {
        const std::string file = MALUS_SOURCE_DIR "/skies/" + std::string(name) + ".exr";
        const Image shipped_map = read_exr(file);
        // "malus sky make -o FILE OPTION…"
        std::string command = *shipped_map.text("commandLine");
        const std::string output = "-o skies/" + std::string(name) + ".exr";
        REQUIRE_THAT(command, Contains("sky make " + output));
        const std::string made = (folder / "made.exr").string();
        command.replace(command.find(output), output.size(), "-o " + quoted(made));
        REQUIRE(run(command.substr(command.find("sky make"))).exit_code == 0);
        const Image made_map = read_exr(made);
        CAPTURE(name);
        REQUIRE(made_map.channels.size() == shipped_map.channels.size());
        for (const auto& [channel, values] : shipped_map.channels) {
            double largest = 0;
            const std::vector<float>& again = made_map.channels.at(channel);
            REQUIRE(again.size() == values.size());
            for (std::size_t i = 0; i < values.size(); ++i)
                largest = std::max(largest, static_cast<double>(std::abs(again[i] - values[i])));
            CHECK(largest < 1e-6);
        }
        CHECK(made_map.text("sunIrradiance") != nullptr);
    }
}

TEST_CASE("Sky make: aerosol dims the sun and the polarization, a low sun is said to be too low",
          "[cli]") {
    const TempFolder folder;
    const std::string out = (folder / "sky.exr").string();
    const std::string small = "sky make --wavelengths 550 --width 36 --height 9 -o " + quoted(out);
    const auto sun = [&](const std::string& more) {
        const Outcome made = run(small + more);
        CAPTURE(made.err);
        REQUIRE(made.exit_code == 0);
        const Sky sky = read_sky(out);
        return sky.sun->irradiance[0];
    };
    const double clear = sun("");
    // Sun at 60°: 2 × 0.3, whatever the aerosol scatters.
    CHECK(sun(" --aerosol-depth 0.3") / clear == Approx(std::exp(-0.6)).epsilon(1e-5));
    CHECK_THAT(*read_exr(out).text("skyModel"), Contains("aerosol mixed with the air") &&
                                                    Contains("optical depth 0.3") &&
                                                    Contains("g 0.7"));
    const std::string table = (folder / "matrix.csv").string();
    write_text(table, "angle_deg,F11,F12,F22,F33\n0,9,0,9,9\n90,1,-0.4,1,0\n180,2,0,2,-2\n");
    CHECK(sun(" --aerosol-depth 0.3 --aerosol-place below --aerosol-matrix " + quoted(table)) /
              clear ==
          Approx(std::exp(-0.6)).epsilon(1e-5));
    CHECK_THAT(*read_exr(out).text("skyModel"),
               Contains("aerosol below the air") && Contains("matrix matrix.csv"));
    fs::remove(out);
    check_fails(small + " --aerosol-depth 0.3 --aerosol-matrix " + quoted(table + "x"), out,
                {"matrix.csvx"});
    write_text(table, "angle_deg,F11,F12,F22,F33\n0,9,0,9,9\n90,1,-0.4,1,0\n");
    check_fails(small + " --aerosol-depth 0.3 --aerosol-matrix " + quoted(table), out,
                {"matrix.csv", "angles end at 90"});
    CHECK(run(small + " --aerosol-depth -1").exit_code == 2);
    CHECK(run(small + " --asymmetry 0.8").exit_code == 2);  // of which aerosol?

    // A table's own numbers: a sun of π through air of depth 0.25 at 60°.
    CHECK(sun(" --optical-depth 0.25 --depolarization 0 --solar-irradiance 3.14159265") ==
          Approx(kPi * std::exp(-0.5)).epsilon(1e-6));
    CHECK_THAT(*read_exr(out).text("skyModel"),
               Contains("optical depth 0.25") && Contains("depolarization 0"));

    CHECK_THAT(run(small + " --aerosol-depth 0.3 --aerosol-place sideways").err,
               Contains("mixed") && Contains("below"));
    CHECK(run(small + " --sun-zenith 80").err.empty());
    CHECK(run(small + " --sun-zenith 85 --quiet").err.empty());
    const Outcome low = run(small + " --sun-zenith 85");
    CHECK(low.exit_code == 0);
    CHECK(low.one_line());
    CHECK_THAT(low.err, Contains("85 degrees from the zenith") && Contains("82"));
}

TEST_CASE("Render: --no-sun leaves the sky alone", "[cli]") {
    const TempFolder folder;
    const std::string lit = (folder / "lit.exr").string(), sky = (folder / "sky.exr").string();
    REQUIRE(run(small_render(lit)).exit_code == 0);
    REQUIRE(run(small_render(sky, "--no-sun")).exit_code == 0);
    // At 440 nm green paint is nearly Lambertian: the sun at 60° brings E cos 60° = 0.56 of the 0.76
    // that level ground receives.
    CHECK(Exr(sky).mean("S0") / Exr(lit).mean("S0") == Approx(0.20 / 0.76).epsilon(0.2));
}

TEST_CASE("Render: --debias lowers DoLP where it is noise, and says so", "[cli]") {
    const TempFolder folder;
    const std::string raw = (folder / "raw.exr").string(), mas = (folder / "mas.exr").string();
    REQUIRE(run(small_render(raw)).exit_code == 0);
    REQUIRE(run(small_render(mas, "--debias")).exit_code == 0);
    CHECK(*read_exr(raw).text("dolpEstimator") == "raw");
    CHECK(*read_exr(mas).text("dolpEstimator") == "MAS");
    CHECK(Exr(mas).mean("DoLP") < Exr(raw).mean("DoLP"));
    CHECK(Exr(mas).mean("S1") == Exr(raw).mean("S1"));
}

TEST_CASE("Sky info: a map is described, and doubted where its sun is not", "[cli]") {
    const TempFolder folder;
    const std::string sky = shipped("skies/rayleigh_60.exr");
    const Outcome info = run("sky info " + sky);
    CAPTURE(info.out);
    CHECK(info.exit_code == 0);
    CHECK(info.err.empty());
    CHECK_THAT(info.out, Contains("180 azimuths x 45 zenith angles") &&
                             Contains("sun at zenith 60, azimuth 135 degrees") &&
                             Contains("550 nm") && Contains("irradiance") &&
                             Contains("degrees above the sun") && Contains("none found") &&
                             !Contains("doubt"));
    CHECK_THAT(run("sky info --sun-zenith 60 --sun-azimuth 90 " + sky).out,
               Contains("doubt 440 nm: the declared sun is not in the map's plane of symmetry"));
    CHECK(run("sky info --sun-zenith 60 " + sky).exit_code == 2);
    CHECK(run("sky info").exit_code == 2);
    const std::string csv = (folder / "sky.csv").string();
    write_text(csv, "wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3\n900,45,0,1,0,0,0\n");
    const Outcome bare = run("sky info " + quoted(csv));
    CHECK(bare.exit_code == 0);
    CHECK_THAT(bare.out, Contains("note  no sun is declared") && Contains("few nodes") &&
                             Contains("cover 45 to 45 of 0 to 90") && !Contains("Babinet"));
    const Outcome image = run("sky info " + shipped("scenes/panel.gltf"));
    CHECK(image.exit_code == 1);
    CHECK(image.one_line());
}

TEST_CASE("Sky import: a table of another code becomes a map, and a wrong switch is noted",
          "[cli]") {
    // Azimuths anticlockwise from the sun, which stands at zenith 50°, azimuth 200°; the sign of Q
    // reversed, as Natraj, Li & Yung (2009) have it.
    const TempFolder folder;
    const auto sky =
        reference::rayleigh_sky(direction(to_radians(50), to_radians(200)), 1.0, 0.8, 0);
    std::string table = "# I/F0\ntheta,phi,I,Q,U,depolarization\n";
    for (double z = 2.5; z < 90; z += 5)
        for (double phi = 0; phi < 360; phi += 5) {
            const auto S = sky(direction(to_radians(z), to_radians(200 - phi)));
            for (double x : {z, phi, S[0], -S[1], S[2]}) table += std::to_string(x) + ",";
            table += "none\n";
        }
    const std::string csv = (folder / "table.csv").string(), map = (folder / "sky.exr").string();
    write_text(csv, table);
    const std::string common = "sky import " + quoted(csv) + " -o " + quoted(map) +
                               " --wavelength 550 --azimuth-zero 200 --sun-zenith 50 "
                               "--sun-azimuth 200 --sun-irradiance 550:1.5 --scale 550:2";
    const Outcome right = run(common + " --azimuth-sense anticlockwise --s1 reversed");
    CAPTURE(right.err);
    REQUIRE(right.exit_code == 0);
    CHECK(right.one_line());
    CHECK_THAT(right.err, Contains("note: ") && Contains("columns not used: depolarization"));
    CHECK(right.out.empty());
    const Image image = read_exr(map);
    CHECK(image.width == 72);
    CHECK(image.height == 18);
    CHECK(*image.text("sunIrradiance") == "550nm:1.5;");
    CHECK_THAT(*image.text("skyModel"), Contains("imported from table.csv"));
    // At the centre of a pixel, halfway between nodes 5° apart: within 2 h²/8 of second derivatives.
    const auto S = sky(direction(to_radians(42.5), to_radians(102.5)));
    const std::size_t pixel = 8 * 72 + 20;
    CHECK(static_cast<double>(spectral_data(image, "S0", 550)[pixel]) == near(2 * S[0], 8e-3));
    CHECK(static_cast<double>(spectral_data(image, "S1", 550)[pixel]) == near(2 * S[1], 8e-3));
    CHECK(static_cast<double>(spectral_data(image, "S2", 550)[pixel]) == near(2 * S[2], 8e-3));
    CHECK_THAT(run("sky info " + quoted(map)).out, !Contains("doubt"));
    const Outcome wrong = run(common + " --s1 reversed");
    CHECK(wrong.exit_code == 0);
    CHECK_THAT(wrong.err, Contains("S2 reversed or azimuths the other way round the sun"));
    CHECK_THAT(run("sky info " + quoted(map)).out, Contains("doubt 550 nm: polarization is not"));
    // Options of the other kind of file are not passed over.
    const std::string again = (folder / "again.exr").string();
    check_fails("sky import " + quoted(map) + " -o " + quoted(again) + " --wavelength 550", again,
                {"--wavelength", "tables"});
    check_fails("sky import " + quoted(csv) + " -o " + quoted(again) + " --zenith-span 0,90", again,
                {"--zenith-span", "pictures"});
    check_fails("sky import " + quoted(map) + " -o " + quoted(again) + " --zenith-span 40,40",
                again, {"both edges are the same"});
}

TEST_CASE("Sky import: bad input and usage", "[cli]") {
    const TempFolder folder;
    const fs::path map = folder / "sky.exr";
    const std::string csv = (folder / "table.csv").string();
    write_text(csv, "wavelength,zenith,azimuth,S0,S1,S2\n550,45,0,1,0,0\n");
    const auto with = [&](const std::string& more) {
        return "sky import " + quoted(csv) + " -o " + quoted(map.string()) + " " + more;
    };
    check_fails(with("--direction propagation"), map, {"table.csv", "below the horizon", "view"});
    check_fails(with("--scale 440:2"), map, {"--scale: says nothing of 550 nm"});
    check_fails(with("--scale 550:2,550:3"), map, {"--scale", "again"});
    check_fails("sky import " + quoted(csv) + " -o " + quoted((folder / "sky.csv").string()), map,
                {"name it .exr"});
    check_fails(
        "sky import " + quoted((folder / "none.csv").string()) + " -o " + quoted(map.string()), map,
        {"none.csv: file not found"});
    check_fails("sky import " + quoted(csv) + " -o " + quoted((folder / "no/sky.exr").string()),
                map, {"sky.exr: cannot be written"});
    write_text(csv, "wavelength,zenith,azimuth,S0,S1,S2\n550,45,0,1,0,0\n550,50,0,1,2,0\n");
    check_fails(with(""), map, {"table.csv: line 3", "exceeds S0"});
    CHECK(std::distance(fs::directory_iterator(fs::path(csv).parent_path()), {}) == 1);
    for (const char* usage :
         {"--s1 minus", "--azimuth-sense left", "--azimuth-zero nan", "--sun-zenith 30",
          "--scale x", "--scale 550:-1", "--zenith-span 0", "--sun-irradiance 550:", "--width 0"})
        CHECK(run(with(usage)).exit_code == 2);
    CHECK(run("sky import").exit_code == 2);
    // A map may not replace what it is made of.
    REQUIRE(run("sky make -o " + quoted(map.string()) + " --width 8 --height 2").exit_code == 0);
    const Outcome same = run("sky import " + quoted(map.string()) + " -o " + quoted(map.string()));
    CHECK(same.exit_code == 1);
    CHECK(same.one_line());
}

TEST_CASE("Preview: pictures of each quantity, of a part of them, and of their errors", "[cli]") {
    const TempFolder folder;
    const std::string image = (folder / "image.exr").string();
    REQUIRE(run(small_render(image)).exit_code == 0);
    const Outcome result =
        run("preview " + quoted(image) + " -o " + quoted((folder / "").string()));
    CAPTURE(result.err);
    CHECK(result.exit_code == 0);
    for (const char* quantity : {"S0", "DoLP", "AoLP", "S1_S0", "S2_S0", "combined", "StdErr_S0",
                                 "StdErr_DoLP", "StdErr_AoLP"}) {
        const fs::path png = folder / ("image_" + std::string(quantity) + "_440nm.png");
        CAPTURE(quantity);
        CHECK(fs::exists(png));
        CHECK(read_text(png).substr(1, 3) == "PNG");
        fs::remove(png);
    }
    CHECK_THAT(result.out, Contains("(blue) over 0 (white) to") && Contains("hue AoLP"));
    // A part of them; errors make the sheet higher.
    const std::string part = "preview " + quoted(image) + " --panels S1_S0,DoLP -o ";
    REQUIRE(run(part + quoted((folder / "").string())).exit_code == 0);
    CHECK(fs::exists(folder / "image_S1_S0_440nm.png"));
    CHECK_FALSE(fs::exists(folder / "image_S0_440nm.png"));
    CHECK_FALSE(fs::exists(folder / "image_StdErr_S0_440nm.png"));
    const fs::path low = folder / "low.png", high = folder / "high.png";
    REQUIRE(run(part + quoted(low.string())).exit_code == 0);
    REQUIRE(run(part + quoted(high.string()) + " --errors").exit_code == 0);
    CHECK(png_size(high).second > 1.5 * png_size(low).second);
    CHECK(png_size(high).first > png_size(low).first);  // three errors, two pictures
    CHECK(run(part + quoted(low.string()) + " --panels S7").exit_code == 2);

    // A large image: full size by itself, a third of it on the sheet.
    Image large;
    large.width = 1300, large.height = 10;
    for (const auto& [s, value] : {std::pair("S0", 1.f), {"S1", 0.5f}, {"S2", 0.5f}, {"S3", 0.f}})
        large.channel(spectral_channel(s, 440)).assign(large.pixel_count(), value);
    write_exr(folder / "large.exr", large);
    REQUIRE(run("preview --panels S0 " + quoted((folder / "large.exr").string())).exit_code == 0);
    CHECK(png_size(folder / "large_S0_440nm.png") == std::pair(1300, 10));
    CHECK(png_size(folder / "large_sheet.png").first < 600);
    const Outcome bad = run("preview " + quoted((folder / "absent.exr").string()));
    CHECK(bad.exit_code == 1);
    CHECK(bad.one_line());
}

TEST_CASE("Preview: a sky map, EXR or CSV, as a dome with its neutral points", "[cli]") {
    const TempFolder folder;
    const std::string exr = (folder / "sky.exr").string();
    REQUIRE(
        run("sky make -o " + quoted(exr) + " --wavelengths 440,550 --sun-azimuth 135").exit_code ==
        0);
    const Outcome dome = run("preview " + quoted(exr) + " --wavelengths 550");
    CAPTURE(dome.out, dome.err);
    CHECK(dome.exit_code == 0);
    CHECK(dome.err.empty());
    for (const char* picture :
         {"sky_S0_550nm.png", "sky_DoLP_550nm.png", "sky_AoLP_550nm.png", "sky_sheet.png"})
        CHECK(read_text(folder / picture).substr(1, 3) == "PNG");
    CHECK_FALSE(fs::exists(folder / "sky_S0_440nm.png"));
    CHECK_THAT(dome.out, Contains("Babinet 13.5 degrees above the sun") &&
                             Contains("Brewster 15.9 degrees below") &&
                             Contains("from the vertical plane"));

    const std::string csv = (folder / "measured.CSV").string();
    std::ofstream(csv) << "wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3\n"
                          "440,30,0,1,0.1,0,0\n440,30,180,1,0.1,0,0\n"
                          "440,80,0,2,0.1,0,0\n440,80,180,2,0.1,0,0\n";
    const std::string sheet = (folder / "only.png").string();
    const Outcome measured = run("preview " + quoted(csv) + " -o " + quoted(sheet));
    CHECK(measured.exit_code == 0);
    CHECK(read_text(sheet).substr(1, 3) == "PNG");
    CHECK_FALSE(fs::exists(folder / "measured_S0_440nm.png"));
    // It says nothing of the sun, and something of its gaps.
    CHECK(measured.out.find("Babinet") == std::string::npos);
    CHECK_THAT(measured.err, Contains("note") && Contains("no azimuth between"));
}

TEST_CASE("Preview: a sky map that is none is refused in one line", "[cli]") {
    const TempFolder folder;
    const std::string csv = (folder / "sky.csv").string(), png = (folder / "sky.png").string();
    std::ofstream(csv) << "wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3\n440,30,0,1,2,0,0\n";
    check_fails("preview " + quoted(csv) + " -o " + quoted(png), png, {"sky.csv", "exceeds S0"});
    check_fails(
        "preview " + shipped("skies/rayleigh_60.exr") + " --wavelengths 500 -o " + quoted(png), png,
        {"rayleigh_60.exr", "no 500 nm", "440, 550, 600"});
}
