// scattering_file_test.cpp — scattering matrices from CSV and what is said of broken ones.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/scattering_file.h"

#include "malus/core/error.h"
#include "malus/io/file.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using Catch::Contains;

namespace {

ScatteringTable read(const std::string& text) {
    const TempFolder folder;
    write_text(folder / "matrix.csv", text);
    return read_scattering(folder / "matrix.csv");
}

}  // namespace

TEST_CASE("Scattering file: one matrix for all wavelengths, or one for each") {
    const ScatteringTable one = read(
        "# made by hand\r\nangle_deg, F11,F12,F22,F33\n0,3,0,3,3\n90,1,-0.5,1,0\n180,2,0,2,-2\n");
    REQUIRE(one.size() == 1);
    const std::vector<ScatteringRow>& rows = one.at(0);
    REQUIRE(rows.size() == 3);
    CHECK(rows[1].angle == near(kPi / 2, 1e-12));
    CHECK(rows[1].F.F12 == -0.5);
    CHECK(rows[2].F.F33 == -2);

    const ScatteringTable two = read(
        "wavelength_nm,angle_deg,F11,F12,F22,F33,F34,F44\n"
        "440,0,3,0,3,3,0,3\n440,180,2,0,2,-2,0,-2\n550,0,4,0,4,4,0,4\n550,180,2,0,2,-2,0,-2\n");
    REQUIRE(two.size() == 2);
    CHECK(two.at(550)[0].F.F11 == 4);
}

TEST_CASE("Scattering file: broken tables are refused with their line") {
    const std::string header = "angle_deg,F11,F12,F22,F33\n";
    CHECK_THROWS_WITH(read("angle,F11\n0,1\n"), Contains("line 1") && Contains("header must be"));
    CHECK_THROWS_WITH(read(header + "0,1,0,1\n"), Contains("line 2") && Contains("4 columns"));
    CHECK_THROWS_WITH(read(header + "0,one,0,1,1\n"), Contains("'one' is not a number"));
    CHECK_THROWS_WITH(read(header + "0,1,0,1,1\n180,0,0,0,0\n"),
                      Contains("line 3") && Contains("F11 must be > 0"));
    CHECK_THROWS_WITH(read(header + "0,1,0,1,1\n180,nan,0,0,0\n"), Contains("line 3"));
    CHECK_THROWS_WITH(read(header + "0,1,0,1,1\n180,1,-2,1,1\n"), Contains("|F12| exceeds F11"));
    CHECK_THROWS_WITH(read(header + "1,1,0,1,1\n180,1,0,1,1\n"), Contains("ascend from 0 to 180"));
    CHECK_THROWS_WITH(read(header + "0,1,0,1,1\n90,1,0,1,1\n60,1,0,1,1\n"), Contains("line 4"));
    CHECK_THROWS_WITH(read(header + "0,1,0,1,1\n170,1,0,1,1\n"), Contains("angles end at 170"));
    CHECK_THROWS_WITH(read(header), Contains("holds no rows"));
    CHECK_THROWS_AS(read_scattering("no_such_file.csv"), Error);
}
