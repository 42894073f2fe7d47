// sky_import_test.cpp — maps in other conventions come back as the light they are of.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/sky_import.h"

#include <functional>
#include <sstream>

#include "malus/core/error.h"
#include "malus/core/frame.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/sky_file.h"
#include "malus/io/spectral_image.h"
#include "malus/scene/sky_description.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using Catch::Contains;

namespace {

const std::vector<double> kOne{550};
constexpr double kSunAzimuth_deg = 200, kSunZenith_deg = 50;  // of smooth_sky()

// Every choice of sense, direction and signs.
std::vector<SkyConventions> all_conventions(double azimuth_zero_deg) {
    std::vector<SkyConventions> all;
    for (AzimuthSense sense : {AzimuthSense::kClockwise, AzimuthSense::kAnticlockwise})
        for (AnglesOf angles : {AnglesOf::kView, AnglesOf::kPropagation})
            for (double s1 : {1.0, -1.0})
                for (double s2_s3 : {1.0, -1.0})
                    all.push_back({to_radians(azimuth_zero_deg), sense, angles, s1, s2_s3, s2_s3});
    return all;
}

// A line as a code of these conventions writes the light S that comes from w: of the two unit
// vectors, view and propagation, the one it means, its azimuth measured from the code's zero.
std::string foreign_line(const SkyConventions& as, const Vec3& w, const reference::Stokes& S) {
    const Vec3 meant = as.angles_of == AnglesOf::kView ? w : -w;
    const double clockwise = to_degrees(azimuth_of(meant) - as.azimuth_zero);
    const double theirs = as.azimuth_sense == AzimuthSense::kClockwise ? clockwise : -clockwise;
    std::ostringstream line;
    line.precision(17);
    line << "550," << to_degrees(zenith_of(meant)) << ',' << theirs - 360 * std::floor(theirs / 360)
         << ',' << S[0] << ',' << as.s1 * S[1] << ',' << as.s2 * S[2] << ',' << as.s3 * S[3];
    return line.str();
}

const std::string kHeader = "wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3\n";

// smooth_sky() at these of our angles, degrees, in the words of another code.
std::string foreign_table(const SkyConventions& as, const std::vector<double>& zeniths,
                          const std::vector<double>& azimuths) {
    const auto sky = smooth_sky(kSunAzimuth_deg);
    std::string text = kHeader;
    for (double z : zeniths)
        for (double a : azimuths) {
            // The zenith has no azimuth of its own; the rows beside it stand for its limit.
            const Vec3 w = direction(to_radians(std::max(z, 1e-7)), to_radians(a));
            text += foreign_line(as, w, sky(w)) + "\n";
        }
    return text;
}

std::vector<double> steps(double first, double step, int count) {
    std::vector<double> values;
    for (int i = 0; i < count; ++i) values.push_back(first + step * i);
    return values;
}

Sky import_text(const std::string& text, const SkyImport& options = {}) {
    const TempFolder folder;
    write_text(folder / "sky.csv", text);
    return import_sky(folder / "sky.csv", options);
}

double distance(const Stokes<double>& a, const Stokes<double>& b) {
    return std::max({std::abs(a.s0 - b.s0), std::abs(a.s1 - b.s1), std::abs(a.s2 - b.s2),
                     std::abs(a.s3 - b.s3)});
}

// The largest distance of the map's nodes that `which` picks from smooth_sky().
double distance_from_truth(
    const Sky& map, const std::function<bool(double z_deg, double a_deg)>& which =
                        [](double, double) { return true; }) {
    const auto sky = smooth_sky(kSunAzimuth_deg);
    double most = 0;
    for (std::size_t z = 0; z < map.zeniths.size(); ++z)
        for (std::size_t a = 0; a < map.azimuths.size(); ++a) {
            if (!which(to_degrees(map.zeniths[z]), to_degrees(map.azimuths[a]))) continue;
            const reference::Stokes S = sky(direction(map.zeniths[z], map.azimuths[a]));
            most = std::max(most, distance(map.at(0, z, a), {S[0], S[1], S[2], S[3]}));
        }
    return most;
}

SkyImport with(const SkyConventions& conventions) {
    SkyImport options;
    options.conventions = conventions;
    options.sun = Sun{to_radians(kSunZenith_deg), to_radians(kSunAzimuth_deg), {}};
    return options;
}

}  // namespace

TEST_CASE("Sky import: tables in all 16 conventions come back node for node") {
    // Azimuth 0 of the file at 37.3°; the nodes stand at pixel centres of 12 × 24.
    const std::vector<double> zeniths = steps(3.75, 7.5, 12), azimuths = steps(7.5, 15, 24);
    for (const SkyConventions& as : all_conventions(37.3)) {
        const Sky map = import_text(foreign_table(as, zeniths, azimuths), with(as));
        CAPTURE(static_cast<int>(as.azimuth_sense), static_cast<int>(as.angles_of), as.s1, as.s2);
        REQUIRE(map.zeniths.size() == 12);
        REQUIRE(map.azimuths.size() == 24);
        CHECK(to_degrees(map.zeniths[0]) == Approx(3.75));
        CHECK(to_degrees(map.azimuths[23]) == Approx(352.5));
        CHECK(distance_from_truth(map) < 1e-12);
        CHECK(map.warnings.empty());
        CHECK(describe_sky(map).doubts.empty());
        // And as floats of a file.
        const TempFolder folder;
        write_sky(folder / "sky.exr", map, {});
        CHECK(distance_from_truth(read_sky(folder / "sky.exr")) < 1e-7);
    }
}

TEST_CASE("Sky import: a resampled map breaks neither at the zenith nor at the seam") {
    // Nodes every degree, zenith and horizon included, in azimuths turned by 37.3°: no node stands
    // at a pixel centre. Bilinear cells of 1°: 2 h²/8 of second derivatives up to 2 is 1.5e-4; that
    // is the largest error anywhere, and it is no larger beside the zenith or the seam.
    for (const SkyConventions& as : all_conventions(37.3)) {
        const Sky map =
            import_text(foreign_table(as, steps(0, 1, 91), steps(37.3 - 360, 1, 360)), with(as));
        REQUIRE(map.zeniths.size() == 90);
        REQUIRE(map.azimuths.size() == 360);
        CHECK(distance_from_truth(map) < 1.5e-4);
        CHECK(distance_from_truth(map, [](double z, double) { return z < 2; }) < 1.5e-4);
        CHECK(distance_from_truth(map, [](double, double a) { return a < 2 || a > 358; }) < 1.5e-4);
        CHECK(describe_sky(map).doubts.empty());
    }
}

TEST_CASE("Sky import: columns 30° apart leave the zenith as it is") {
    // Halfway between columns the meridian frame would lose 1 − cos 30° of the polarization, 0.08.
    // In the fixed frame light 2° off the zenith goes around as z g cos a, g < 1: between columns
    // that is wrong by (30°)²/8 of it, 1.2e-3 g.
    SkyImport options = with({to_radians(37.3), AzimuthSense::kAnticlockwise});
    options.width = 360;
    const Sky map = import_text(
        foreign_table(options.conventions, steps(0, 1, 91), steps(7.3, 30, 12)), options);
    CHECK(distance_from_truth(map, [](double z, double) { return z < 2; }) < 1e-3);
}

TEST_CASE("Sky import: the wrong switch is told") {
    const SkyConventions right{
        to_radians(37.3), AzimuthSense::kAnticlockwise, AnglesOf::kPropagation, -1, -1, -1};
    const std::string text = foreign_table(right, steps(2.5, 5, 18), steps(2.5, 5, 72));
    const auto doubt = [&](const SkyConventions& wrong) {
        const SkyDescription description = describe_sky(import_text(text, with(wrong)));
        REQUIRE(description.doubts.size() == 1);
        return description.doubts[0];
    };
    CHECK(describe_sky(import_text(text, with(right))).doubts.empty());
    SkyConventions wrong = right;
    wrong.azimuth_zero = to_radians(90);
    CHECK_THAT(doubt(wrong), Contains("not in the map's plane of symmetry"));
    wrong = right, wrong.azimuth_sense = AzimuthSense::kClockwise;
    CHECK_THAT(doubt(wrong), Contains("not in the map's plane of symmetry"));
    wrong = right, wrong.s1 = 1;
    CHECK_THAT(doubt(wrong), Contains("with S1 reversed it is 0"));
    wrong = right, wrong.s2 = wrong.s3 = 1;
    CHECK_THAT(doubt(wrong), Contains("with S2 reversed"));
    wrong = right, wrong.angles_of = AnglesOf::kView;
    CHECK_THROWS_WITH(import_text(text, with(wrong)),
                      Contains("every direction lies below the horizon") &&
                          Contains("propagation (--direction)"));
    // Counted from the sun, the wrong sense is the wrong sign of S2: a mirror image.
    const SkyConventions from_sun{to_radians(kSunAzimuth_deg)};
    const std::string relative = foreign_table(from_sun, steps(2.5, 5, 18), steps(2.5, 5, 72));
    wrong = from_sun, wrong.azimuth_sense = AzimuthSense::kAnticlockwise;
    CHECK_THAT(describe_sky(import_text(relative, with(wrong))).doubts.at(0),
               Contains("azimuths the other way round the sun it is 0"));
}

TEST_CASE("Sky import: columns of other codes, in any order, some missing, some more") {
    SkyImport options;
    options.wavelength_nm = 450;
    options.scale = {{450, 2.0}};
    std::string text = "# a code\nI, Q ,altitude,vaa,U,VZA [deg]\n";
    for (int z : {90, 0, 45})
        for (int a : {-180, -90, 0, 90, 180})
            text += std::to_string(z + 1) + ",0.25,0," + std::to_string(a) + ",-0.5," +
                    std::to_string(z) + "\n";
    options.height = 2, options.width = 4;
    const Sky map = import_text(text, options);
    CHECK(map.wavelengths_nm == std::vector<double>{450});
    REQUIRE(map.nodes.size() == 8);
    // Halfway between the rows: S0 = 2 (1 + z).
    CHECK(map.at(0, 0, 2).s0 == Approx(2 * (1 + 22.5)));
    CHECK(map.at(0, 1, 2).s0 == Approx(2 * (1 + 67.5)));
    CHECK(map.at(0, 1, 2).s3 == 0);
    REQUIRE(map.warnings.size() == 1);
    CHECK_THAT(map.warnings[0], Contains("columns not used: altitude"));
    // Azimuths ±180° are one; without a size the map is as fine as the nodes.
    options.height = options.width = 0;
    CHECK(import_text(text, options).azimuths.size() == 4);
    CHECK(import_text(text, options).zeniths.size() == 2);
}

TEST_CASE("Sky import: half a dome is mirrored at the sun's vertical") {
    SkyImport options = with({to_radians(kSunAzimuth_deg), AzimuthSense::kAnticlockwise});
    const std::string half =
        foreign_table(options.conventions, steps(2.5, 5, 18), steps(kSunAzimuth_deg - 180, 5, 37));
    options.half_dome = HalfDome::kMirrored;
    // smooth_sky() has an even S3, no sky of the kind that is mirrored.
    std::string even = kHeader;
    std::istringstream lines(half.substr(kHeader.size()));
    for (std::string line; std::getline(lines, line);)
        even += line.substr(0, line.rfind(',')) + ",0\n";
    const Sky map = import_text(even, options);
    REQUIRE(map.azimuths.size() == 72);
    const auto sky = smooth_sky(kSunAzimuth_deg);
    for (std::size_t a = 0; a < 72; ++a) {
        const reference::Stokes S = sky(direction(map.zeniths[7], map.azimuths[a]));
        // Bilinear cells of 5°: 2 h²/8 of second derivatives up to 2.
        CHECK(distance(map.at(0, 7, a), {S[0], S[1], S[2], 0}) < 4e-3);
    }
    CHECK(describe_sky(map).doubts.empty());
    // Circular light turns over: here +0.5 on the half that is given.
    std::string circular = kHeader;
    for (const char* a : {"0", "90", "180"})
        circular += "550,45," + std::string(a) + ",1,0,0.25," +
                    (std::string(a) == "90" ? "0.5" : "0") + "\n";
    SkyImport plain;
    plain.half_dome = HalfDome::kMirrored;
    plain.width = 4, plain.height = 1;
    const Sky round = import_text(circular, plain);
    CHECK(round.at(0, 0, 0).s3 == Approx(0.25));
    CHECK(round.at(0, 0, 3).s3 == Approx(-0.25));
    CHECK_THROWS_WITH(import_text(circular + "550,45,270,1,0,0,0\n", plain),
                      Contains("azimuth 270 is beyond the half") && Contains("--mirror"));
}

TEST_CASE("Sky import: an EXR of any size, its edges, handedness and sun") {
    const TempFolder folder;
    const auto sky = smooth_sky(kSunAzimuth_deg);
    // A whole sphere of propagation angles, anticlockwise: 0° at the top goes straight up.
    const SkyConventions as{
        to_radians(30), AzimuthSense::kAnticlockwise, AnglesOf::kPropagation, 1, -1, 1};
    Image image;
    image.width = 72, image.height = 36;
    for (int c = 0; c < 4; ++c) image.channel("S" + std::to_string(c) + ".550nm");
    for (int y = 0; y < 36; ++y)
        for (int x = 0; x < 72; ++x) {
            const double azimuth = as.azimuth_zero - to_radians((x + 0.5) * 5);
            const Vec3 k = direction(to_radians((y + 0.5) * 5), azimuth);
            const reference::Stokes S = k.y < 0 ? sky(-k) : reference::Stokes{};
            const auto i = static_cast<std::size_t>(y * 72 + x);
            image.channel("S0.550nm")[i] = static_cast<float>(S[0]);
            image.channel("S1.550nm")[i] = static_cast<float>(S[1]);
            image.channel("S2.550nm")[i] = static_cast<float>(-S[2]);
            image.channel("S3.550nm")[i] = static_cast<float>(-S[3]);
        }
    image.attributes["polarisationHandedness"] = "left";
    image.attributes["sunZenith"] = static_cast<float>(kSunZenith_deg);
    image.attributes["sunAzimuth"] = static_cast<float>(30 - kSunAzimuth_deg + 360);
    image.attributes["sunIrradiance"] = "550nm:1.5;";
    write_exr(folder / "sphere.exr", image);
    SkyImport options;
    options.conventions = as;
    options.zenith_span = {0, kPi};
    const Sky map = import_sky(folder / "sphere.exr", options);
    REQUIRE(map.zeniths.size() == 18);
    REQUIRE(map.azimuths.size() == 72);
    CHECK(distance_from_truth(map) < 1e-7);
    REQUIRE(map.warnings.size() == 1);
    CHECK_THAT(map.warnings[0], Contains("18 of 36 zenith angles lie below the horizon"));
    REQUIRE(map.sun);
    CHECK(to_degrees(map.sun->azimuth) == Approx(kSunAzimuth_deg));
    CHECK(map.sun->irradiance == std::vector<double>{1.5});
    CHECK(describe_sky(map).doubts.empty());
    // Without its edges the picture is the dome, overhead at the top.
    SkyImport dome;
    dome.conventions.angles_of = AnglesOf::kPropagation;
    write_sky(folder / "dome.exr", sample_sky(sky, kOne, 12, 24), {});
    const Sky turned = import_sky(folder / "dome.exr", dome);
    const Sky direct = read_sky(folder / "dome.exr");
    CHECK(to_degrees(turned.zeniths[0]) == Approx(3.75));
    CHECK(turned.at(0, 3, 0).s2 == direct.at(0, 3, 12).s2);
}

TEST_CASE("Sky import: our own map is unchanged, its sun and scale can be said anew") {
    const TempFolder folder;
    Sky sky = sample_sky(smooth_sky(), {440, 600}, 9, 12);
    sky.sun = Sun{1, 2, {1.5, 1.25}};
    write_sky(folder / "sky.exr", sky, {});
    const Sky map = import_sky(folder / "sky.exr", {});
    const Sky direct = read_sky(folder / "sky.exr");
    REQUIRE(map.nodes.size() == direct.nodes.size());
    for (std::size_t i = 0; i < map.nodes.size(); ++i)
        CHECK(distance(map.nodes[i], direct.nodes[i]) == 0);
    CHECK(map.sun->irradiance == direct.sun->irradiance);
    SkyImport options;
    options.scale = {{440, 2}, {600, 4}};
    options.sun = Sun{0.5, 0.25, {}};
    options.sun_irradiance = {{440, 3}, {600, 5}};
    const Sky bright = import_sky(folder / "sky.exr", options);
    CHECK(bright.at(0, 4, 4).s2 == 2 * direct.at(0, 4, 4).s2);
    CHECK(bright.at(1, 4, 4).s0 == 4 * direct.at(1, 4, 4).s0);
    CHECK(bright.sun->zenith == 0.5);
    CHECK(bright.sun->irradiance == std::vector<double>{3, 5});
}

TEST_CASE("Sky import: each mistake is one line with place and remedy") {
    const std::string good = "550,10,0,1,0,0,0\n";
    const auto fails = [](const std::string& text, const SkyImport& options = {}) {
        try {
            import_text(text, options);
        } catch (const Error& error) {
            CHECK_THAT(std::string(error.what()), !Contains("\n"));
            return std::string(error.what());
        }
        return std::string("nothing");
    };
    CHECK_THAT(fails("wavelength,zenith,azimuth,S0,S1\n"),
               Contains("sky.csv: line 1: no column s2 or u") && Contains("name the columns"));
    CHECK_THAT(fails("zenith,azimuth,S0,S1,S2\n"), Contains("give --wavelength"));
    CHECK_THAT(fails("wavelength,zenith,azimuth,I,S0,S1,S2\n"),
               Contains("two columns for s0 or i; keep one"));
    SkyImport nm;
    nm.wavelength_nm = 450;
    CHECK_THAT(fails(kHeader + good, nm), Contains("leave out --wavelength"));
    CHECK_THAT(fails(kHeader), Contains("no rows"));
    CHECK_THAT(fails(kHeader + "550,181,0,1,0,0,0\n"),
               Contains("sky.csv: line 2: zenith angle 181 must be within 0 to 180"));
    CHECK_THAT(fails(kHeader + "550,10,400,1,0,0,0\n"), Contains("line 2: azimuth 400"));
    CHECK_THAT(fails(kHeader + "550,10,nan,1,0,0,0\n"), Contains("line 2: azimuth"));
    CHECK_THAT(fails(kHeader + "550,10,-300,1,0,0,0\n550,10,100,1,0,0,0\n"),
               Contains("more than a turn"));
    CHECK_THAT(fails(kHeader + "-5,10,0,1,0,0,0\n"), Contains("wavelength must be > 0 nm"));
    CHECK_THAT(fails(kHeader + "550,10,0,1,0,0\n"), Contains("6 columns instead of 7"));
    CHECK_THAT(fails(kHeader + "550,10,0,one,0,0,0\n"), Contains("'one' is not a number"));
    CHECK_THAT(fails(kHeader + "550,10,0,-1,0,0,0\n"), Contains("line 2") && Contains("negative"));
    CHECK_THAT(fails(kHeader + "550,10,0,1,0.8,0.8,0\n"),
               Contains("line 2") && Contains("exceeds S0"));
    CHECK_THAT(fails(kHeader + good + good), Contains("same node as line 2"));
    CHECK_THAT(fails(kHeader + good + "550,20,90,1,0,0,0\n"), Contains("gap in the grid"));
    SkyImport scale;
    scale.scale = {{440, 2}};
    CHECK_THAT(fails(kHeader + good, scale), Contains("--scale: says nothing of 550 nm; add it"));
    scale.scale = {{550, 2}, {600, 3}};
    CHECK_THAT(fails(kHeader + good, scale),
               Contains("--scale: the map has no 600 nm; it has 550 nm"));
    scale.scale = {{0, 1e300}};
    CHECK_THAT(fails(kHeader + good, scale), Contains("line 2") && Contains("brighter"));
    SkyImport disc;
    disc.sun_irradiance = {{550, 1.5}};
    CHECK_THAT(fails(kHeader + good, disc), Contains("--sun-zenith and --sun-azimuth"));
}
