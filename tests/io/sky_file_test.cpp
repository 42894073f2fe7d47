// sky_file_test.cpp — sky maps as EXR and CSV, and what is said of broken ones.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/sky_file.h"

#include <sstream>

#include "malus/core/error.h"
#include "malus/core/frame.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/spectral_image.h"
#include "malus/scene/clear_sky.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using Catch::Contains;

namespace {

const std::string kHeader = "wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3\n";

Sky read_csv(const std::string& text) {
    const TempFolder folder;
    write_text(folder / "sky.csv", text);
    return read_sky(folder / "sky.csv");
}

std::string full_grid() {
    std::ostringstream text;
    text << "# a comment\n" << kHeader;
    // Any order: azimuth outermost, downward.
    for (int a : {270, 180, 90, 0})
        for (int z : {90, 0, 45})
            for (double nm : {600.0, 440.5})
                text << nm << ',' << z << ',' << a << ',' << nm + z + a / 1000.0 << ",1,-2,0.5\n";
    return text.str();
}

}  // namespace

TEST_CASE("Sky CSV: a full grid in any order lands at its nodes") {
    const Sky sky = read_csv(full_grid());
    CHECK(sky.wavelengths_nm == std::vector<double>{440.5, 600});
    REQUIRE(sky.zeniths.size() == 3);
    REQUIRE(sky.azimuths.size() == 4);
    CHECK(to_degrees(sky.zeniths[1]) == Approx(45));
    CHECK(to_degrees(sky.azimuths[3]) == Approx(270));
    CHECK(sky.at(1, 1, 2).s0 == Approx(600 + 45 + 0.18));
    CHECK(sky.at(0, 2, 0).s0 == Approx(440.5 + 90));
    CHECK(sky.at(0, 0, 0).s2 == -2);
}

TEST_CASE("Sky CSV: what a map leaves out of the dome is said") {
    std::string quarter = kHeader;
    for (const char* z : {"0", "45", "60"})
        for (const char* a : {"0", "45", "90"})
            quarter += "550," + std::string(z) + "," + a + ",1,0,0,0\n";
    const Sky sky = read_csv(quarter);
    REQUIRE(sky.warnings.size() == 2);
    CHECK_THAT(sky.warnings[0], Contains("cover 0 to 60 of 0 to 90"));
    CHECK_THAT(sky.warnings[1], Contains("between 90 and 0"));
    CHECK(read_csv(full_grid()).warnings.empty());
}

TEST_CASE("Sky CSV: 360° is 0°") {
    std::string text = kHeader;
    for (const char* a : {"0", "180", "360"})
        text += "550,10," + std::string(a) + ",1,0,0,0\n550,80," + std::string(a) + ",1,0,0,0\n";
    CHECK(read_csv(text).azimuths.size() == 2);
    // Also where a row has only one of them.
    text.replace(text.find("550,10,0,"), 9, "550,10,0.0000000001,");
    text.erase(text.find("550,80,0,"), 17);
    CHECK(read_csv(text).azimuths.size() == 2);
}

TEST_CASE("Sky CSV: each mistake is one line with the row") {
    const std::string good = "550,10,0,1,0,0,0\n";
    CHECK_THROWS_WITH(read_csv(kHeader + good + "550,10,90,-1,0,0,0\n"),
                      Contains("sky.csv: line 3") && Contains("negative"));
    CHECK_THROWS_WITH(read_csv(kHeader + good + "550,10,90,1,0.8,0.8,0\n"),
                      Contains("line 3") && Contains("exceeds S0"));
    CHECK_THROWS_WITH(read_csv(kHeader + good + "550,10,90,1e39,0,0,0\n"), Contains("brighter"));
    CHECK_THROWS_WITH(read_csv(kHeader + good + "550,10,90,nan,0,0,0\n"),
                      Contains("line 3") && Contains("not finite"));
    CHECK_THROWS_WITH(read_csv(kHeader + good + "550,10,90,1,0,0\n"), Contains("6 columns"));
    CHECK_THROWS_WITH(read_csv(kHeader + good + "550,10,90,one,0,0,0\n"),
                      Contains("'one' is not a number"));
    CHECK_THROWS_WITH(read_csv(kHeader + good + "550,91,0,1,0,0,0\n"), Contains("zenith_deg"));
    CHECK_THROWS_WITH(read_csv(kHeader + good + good), Contains("same node as line 2"));
    CHECK_THROWS_WITH(read_csv(kHeader + good + "550,20,90,1,0,0,0\n"),
                      Contains("gap in the grid"));
    CHECK_THROWS_WITH(read_csv("zenith,azimuth\n1,2\n"), Contains("header must be"));
    CHECK_THROWS_WITH(read_csv(kHeader), Contains("no rows"));
}

TEST_CASE("Sky EXR: what is written is what is read, sun included") {
    const TempFolder folder;
    ClearSky model;
    Sky sky = make_clear_sky(model, std::vector<double>{440, 600}, 9, 12);
    sky.sun->irradiance = {1.5, 1.25};
    write_sky(folder / "sky.exr", sky, {{"skyModel", "test"}});
    const Sky back = read_sky(folder / "sky.exr");
    CHECK(back.wavelengths_nm == sky.wavelengths_nm);
    REQUIRE(back.nodes.size() == sky.nodes.size());
    for (std::size_t i = 0; i < sky.nodes.size(); ++i) {
        CHECK(back.nodes[i].s0 == Approx(sky.nodes[i].s0).epsilon(1e-6));
        CHECK(back.nodes[i].s2 == near(sky.nodes[i].s2, 1e-8));
    }
    CHECK(back.zeniths[3] == Approx(sky.zeniths[3]));
    REQUIRE(back.sun);
    CHECK(to_degrees(back.sun->zenith) == Approx(60));
    CHECK(back.sun->irradiance == sky.sun->irradiance);
}

TEST_CASE("Sky EXR: channel names of other writers and their errors") {
    const TempFolder folder;
    Image image;
    image.width = 4, image.height = 2;
    for (const char* c : {"S0", "S1", "S2"}) image.channel(std::string(c) + ".550,5nm");
    write_exr(folder / "three.exr", image);
    CHECK_THROWS_WITH(read_sky(folder / "three.exr"),
                      Contains("three.exr") && Contains("'S3.550,500000nm' is missing"));
    image.channel("S3.550,5nm");
    for (float& s : image.channel("S0.550,5nm")) s = 1;
    write_exr(folder / "four.exr", image);
    CHECK(read_sky(folder / "four.exr").wavelengths_nm == std::vector<double>{550.5});
    image.channel("S1.550,5nm")[5] = 2;
    write_exr(folder / "over.exr", image);
    CHECK_THROWS_WITH(read_sky(folder / "over.exr"), Contains("pixel (1,1)"));
    image.channel("S1.550,5nm")[5] = 0;
    image.channel("S3.550,5nm")[5] = 0.5;
    image.attributes["polarisationHandedness"] = "left";
    write_exr(folder / "left.exr", image);
    CHECK(read_sky(folder / "left.exr").nodes[5].s3 == Approx(-0.5));
    image.attributes["polarisationHandedness"] = "both";
    write_exr(folder / "both.exr", image);
    CHECK_THROWS_WITH(read_sky(folder / "both.exr"), Contains("'right' or 'left'"));
    Image grey;
    grey.width = grey.height = 1;
    grey.channel("Y");
    write_exr(folder / "grey.exr", grey);
    CHECK_THROWS_WITH(read_sky(folder / "grey.exr"), Contains("not a sky map"));
    write_text(folder / "text.exr", "hello");
    CHECK_THROWS_WITH(read_sky(folder / "text.exr"), Contains("not an OpenEXR file"));
    CHECK_THROWS_WITH(read_sky(folder / "absent.exr"), Contains("file not found"));
}

TEST_CASE("Sky EXR: a sun that cannot be is refused with what to mend") {
    const TempFolder folder;
    Sky sky = make_clear_sky({}, std::array{550.0, 600.0}, 4, 8);
    write_sky(folder / "sky.exr", sky, {});
    const Image good = read_exr(folder / "sky.exr");
    const auto check = [&](const std::string& name, const Attribute& value,
                           const std::string& message) {
        Image image = good;
        image.attributes[name] = value;
        write_exr(folder / "bad.exr", image);
        CAPTURE(name);
        CHECK_THROWS_WITH(read_sky(folder / "bad.exr"), Contains(message));
    };
    check("sunZenith", 1e8f, "sunZenith must be within 0 to 180 degrees");
    check("sunZenith", NAN, "sunZenith must be");
    check("sunAzimuth", INFINITY, "sunAzimuth must be within");
    check("sunIrradiance", std::string("550nm:inf;600nm:1;"),
          "at 550 nm it must be within 0 to 1e15");
    check("sunIrradiance", std::string("550nm:-1;600nm:1;"), "must be within 0");
    check("sunIrradiance", std::string("550nm:1;550nm:2;600nm:1;"), "gives 550 nm twice");
    check("sunIrradiance", 1.5f, "must be a string");
    check("sunZenith", 60, "must be a float");
    check("sunIrradiance", std::string("550nm:1;"), "says nothing of 600 nm");
    check("sunIrradiance", std::string("550:1;600nm:1;"), "not of the form");
    check("sunIrradiance", std::string("550nm:one;600nm:1;"), "'one' is not a number");
}

TEST_CASE("Sky EXR: a file cut off anywhere is refused, never half read") {
    const TempFolder folder;
    write_sky(folder / "sky.exr", make_clear_sky({}, std::vector<double>{440}, 9, 12), {});
    const std::string whole = read_text(folder / "sky.exr");
    for (std::size_t length = 0; length + 1 < whole.size(); length += 97) {
        write_text(folder / "cut.exr", whole.substr(0, length));
        CHECK_THROWS_AS(read_sky(folder / "cut.exr"), Error);
    }
}
