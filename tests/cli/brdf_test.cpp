// brdf_test.cpp — malus brdf as its users meet it.
// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>
#include <sstream>

#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/spectral_image.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/program.h"

using namespace malus;
using Catch::Contains;

namespace {

std::string brdf(const std::string& more, const std::string& name = "green_paint") {
    return "brdf " + name + " --materials " + shipped("materials/paints.json") + " " + more;
}

Outcome done(const std::string& arguments) {
    const Outcome result = run(arguments);
    CAPTURE(arguments, result.err);
    REQUIRE(result.exit_code == 0);
    return result;
}

// Columns of a CSV file by position, without its line of names.
std::vector<std::vector<double>> numbers(const std::string& path) {
    std::istringstream lines(read_text(path));
    std::vector<std::vector<double>> rows;
    std::string line;
    for (std::getline(lines, line); std::getline(lines, line);) {
        std::istringstream cells(line);
        rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');)
            rows.back().push_back(std::stod(cell));
    }
    return rows;
}

}  // namespace

TEST_CASE("BRDF: one geometry is printed, and written as JSON", "[cli]") {
    const TempFolder folder;
    const std::string json = (folder / "at.json").string();
    const Outcome result =
        done(brdf("--wavelengths 550 --incidence-zenith 60 --at 60,180 --json " + quoted(json)));
    CHECK_THAT(result.out, Contains("green_paint") && Contains("550 nm") &&
                               Contains("f00      0.0205") && Contains("DoLP     0.915") &&
                               Contains("AoLP     90 degrees") && Contains("meridian frames") &&
                               Contains("facet frames"));
    const auto all = nlohmann::json::parse(read_text(json));
    CHECK(all.at("material") == "green_paint");
    CHECK(all.at("incidence_zenith_deg") == 60);
    CHECK(all.at("view_azimuth_deg") == 180);
    const auto& at = all.at("values").at(0);
    // P = 0.0235/(2π 0.1288²); R = 0.0910 and DoLP = 0.915 at 60°: the contract of equations.
    CHECK(at.at("facet_distribution_per_sr").get<double>() == near(0.22545, 5e-6));
    CHECK(at.at("f00_per_sr").get<double>() == near(0.22545 * 0.0910, 1.2e-5));
    CHECK(at.at("DoLP").get<double>() == near(0.915, 5e-4));
    CHECK(at.at("AoLP_deg").get<double>() == near(90, 1e-9));
    CHECK(at.at("shadowing").get<double>() == near(1, 1e-12));
    CHECK(at.at("mueller_meridian_per_sr").at(0).at(0) == at.at("f00_per_sr"));
    CHECK(at.at("mueller_meridian_per_sr").at(1).at(0).get<double>() < 0);
    CHECK(at.at("mueller_facet_per_sr").at(1).at(0).get<double>() > 0);
}

TEST_CASE("BRDF: polarized light and other azimuths of the light are taken", "[cli]") {
    const TempFolder folder;
    const std::string json = (folder / "at.json").string();
    const auto value = [&](const std::string& more) {
        done(brdf("--quiet --wavelengths 440 --json " + quoted(json) + " " + more, "black_paint"));
        return nlohmann::json::parse(read_text(json)).at("values").at(0);
    };
    const auto across = value("--at 45,180 --stokes 1,-1,0,0");
    const auto& m = across.at("mueller_meridian_per_sr");
    CHECK(across.at("stokes_per_sr").at(0).get<double>() ==
          Approx(m.at(0).at(0).get<double>() - m.at(0).at(1).get<double>()).epsilon(1e-12));
    CHECK(across.at("stokes_per_sr").at(2).get<double>() ==
          near(m.at(2).at(0).get<double>() - m.at(2).at(1).get<double>(), 1e-15));
    const auto turned_light = value("--at 45,-150 --incidence-azimuth 30 --stokes 1,-1,0,0");
    for (std::size_t i = 0; i < 4; ++i)
        CHECK(turned_light.at("stokes_per_sr").at(i).get<double>() ==
              near(across.at("stokes_per_sr").at(i).get<double>(), 1e-13));
}

TEST_CASE("BRDF: CSV and EXR agree and peak with 0.22 at specular, the plots are a picture",
          "[cli]") {
    const TempFolder folder;
    const std::string csv = (folder / "t.csv").string(), exr = (folder / "t.exr").string(),
                      png = (folder / "t.png").string();
    const Outcome result = done(brdf("--wavelengths 550,440 --csv " + quoted(csv) + " --exr " +
                                     quoted(exr) + " --png " + quoted(png)));
    CHECK_THAT(result.out, Contains("specular azimuth 180") &&
                               Contains("550 nm: P up to 0.2255 at zenith 45, azimuth 180"));
    const Image image = read_exr(exr);
    CHECK(image.width == 360);
    CHECK(image.height == 91);
    CHECK(stokes_wavelengths(image) == std::vector<double>{440, 550});
    CHECK(*image.text("material") == "green_paint");
    CHECK(*image.number("incidenceZenith") == 45);
    const auto rows = numbers(csv);
    REQUIRE(rows.size() == 2 * 360 * 91);
    double peak = 0;
    std::size_t differ = 0;
    for (const auto& x : rows) {
        const auto pixel = static_cast<std::size_t>(x[1] * 360 + x[2]);
        if (x[0] == 550) peak = std::max(peak, x[3]);
        const char* channels[] = {"P", "SO", "G", "F00", "S0", "S1", "S2", "S3", "DoLP", "AoLP"};
        for (std::size_t c = 0; c < 10; ++c)
            differ +=
                spectral_data(image, channels[c], x[0])[pixel] != static_cast<float>(x[3 + c]);
    }
    CHECK(differ == 0);
    CHECK(peak == near(0.22545, 5e-6));
    CHECK(read_text(png).substr(1, 3) == "PNG");
    // Other commands take the image.
    CHECK_THAT(done("info " + quoted(exr)).out, Contains("360 x 91 pixels") && Contains("440 nm"));
}

TEST_CASE("BRDF: --step, the rows' wavelengths, notes and names after --materials", "[cli]") {
    const TempFolder folder;
    const std::string csv = (folder / "t.csv").string();
    const Outcome all = done(brdf("--step 7.5 --csv " + quoted(csv)));
    CHECK(numbers(csv).size() == 3 * 13 * 48);
    CHECK_THAT(all.err, Contains("550 nm") && Contains("negative"));
    const Outcome between = done("brdf --materials " + shipped("materials/paints.json") +
                                 " black_paint --step 15 --wavelengths 500 --csv " + quoted(csv));
    CHECK_THAT(between.err, Contains("500 nm are interpolated"));
    CHECK_THAT(between.err, !Contains("green"));
    const Outcome quiet = done(brdf("--quiet --step 15 --csv " + quoted(csv)));
    CHECK(quiet.out.empty());
    CHECK(quiet.err.empty());
}

TEST_CASE("BRDF: what is wrong is one line, and nothing is written", "[cli]") {
    const TempFolder folder;
    const std::string csv = (folder / "t.csv").string();
    const auto refused = [&](const std::string& more, const std::vector<std::string>& words,
                             const std::string& name = "green_paint") {
        check_fails(brdf("--csv " + quoted(csv) + " " + more, name), csv, words);
    };
    refused("", {"unknown material 'gren_paint'", "did you mean 'green_paint'"}, "gren_paint");
    refused("--wavelengths 700", {"paints.json: green_paint", "no data at 700 nm", "440 to 600"});
    refused("--wavelengths 440,440", {"440 nm stands twice"});
    refused("--step 7", {"--step: 90 degrees", "such as 1 or 5"});
    refused("--stokes 1,1,1,0", {"--stokes", "more than fully polarized", "1.4142"});
    refused("--stokes 0,0,0,0", {"--stokes: S0 is 0"});
    refused("--stokes nan,0,0,0", {"--stokes: S0 is nan"});
    write_text(folder / "more.json", read_text(MALUS_SOURCE_DIR "/materials/paints.json"));
    refused("--materials " + quoted((folder / "more.json").string()),
            {"more.json: green_paint: a material of this name stands in", "paints.json", "rename"});
    refused("--materials " + quoted((folder / "none.json").string()),
            {"none.json", "file not found"});
    check_fails(brdf("--csv " + quoted((folder / "no/t.csv").string())), folder / "no",
                {"there is no folder"});
    check_fails(brdf("--exr " + quoted((folder / "t.png").string())), folder / "t.png",
                {"name it .exr"});
    check_fails(brdf("--csv " + quoted(csv) + " --png " + quoted(csv)), csv, {"t.csv"});
    for (const char* usage :
         {"", "--csv t.csv --incidence-zenith 90", "--csv t.csv --incidence-zenith nan",
          "--at 90,0", "--at nan,0", "--at 30,400", "--at 30", "--csv t.csv --stokes 1,0,0",
          "--csv t.csv --step 0", "--csv t.csv --json t.json"}) {
        CAPTURE(usage);
        CHECK(run(brdf(usage)).exit_code == 2);
    }
    CHECK(run("brdf --materials " + shipped("materials/paints.json") + " --at 30,0").exit_code ==
          2);
    CHECK_THAT(run("brfd").err, Contains("did you mean 'brdf'"));
}
