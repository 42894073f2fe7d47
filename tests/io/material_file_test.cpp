// material_file_test.cpp — paints from JSON and what is said of broken ones.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/material_file.h"

#include "malus/core/error.h"
#include "malus/io/file.h"
#include "support/catch.h"
#include "support/fixtures.h"

using namespace malus;
using Catch::Contains;

namespace {

const std::string kRow =
    R"({"wavelength_nm": 550, "n": 1.4, "k": 0.1, "B": 0.5, "sigma": 0.3, "rho_d": 0.1, "rho_v": 0})";

std::string file_of(const std::string& rows, const std::string& more = "") {
    return R"({"materials": {"paint": {"source": "test", )" + more + R"("rows": [)" + rows + "]}}}";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
}

MaterialFile read(const std::string& text) {
    const TempFolder folder;
    write_text(folder / "paints.json", text);
    return read_materials(folder / "paints.json");
}

}  // namespace

TEST_CASE("Paints: the shipped file holds the study's table") {
    const MaterialFile file = read_materials(MALUS_SOURCE_DIR "/materials/paints.json");
    REQUIRE(file.materials.size() == 2);
    // Sums over all rows of the study's Table 1.
    double n = 0, k = 0, B = 0, sigma = 0, rho_d = 0, rho_v = 0;
    for (const Material& m : file.materials)
        for (const MaterialRow& row : m.rows) {
            n += row.p.n, k += row.p.k, B += row.p.B;
            sigma += row.p.sigma, rho_d += row.p.rho_d, rho_v += row.p.rho_v;
        }
    CHECK(n == Approx(1.3766 + 1.366 + 1.125 + 1.4330 + 1.2850 + 1.7730));
    CHECK(k == Approx(0.28959 + 0.2746 + 1 + 0.0102 + 0.2923 + 0.4146));
    CHECK(B == Approx(0.173996 + 0.0235 + 0.0068 + 0.5742 + 0.2356 + 0.0706));
    CHECK(sigma == Approx(0.468383 + 0.1288 + 0.0742 + 0.8524 + 0.8057 + 0.7556));
    CHECK(rho_d == Approx(0.042161 - 9.450e-4 + 4.108e-3 + 2.290e-2 + 1.664e-3 + 6.629e-4));
    CHECK(rho_v == Approx(0.001769 - 1.285e-3 - 1.645e-3 + 3.100e-2 + 6.500e-3 + 2.812e-4));
    CHECK(file.materials[0].rows[0].p.tau == Approx(0.22121));
    CHECK(file.materials[1].rows[2].p.tau == Approx(228.6 * kPi / 180));
    // Two green rows have negative ρ.
    CHECK(file.warnings.size() == 2);
    CHECK_THAT(file.warnings[0], Contains("550 nm"));
}

TEST_CASE("Paints: options are read, rows are sorted") {
    const MaterialFile file =
        read(file_of(replaced(kRow, "550", "600") + "," + kRow,
                     R"("slopes": "cauchy", "attenuation": "torrance-sparrow", )"));
    const Material& m = file.materials.at(0);
    CHECK(m.slopes == Slopes::kCauchy);
    CHECK(m.attenuation == Attenuation::kTorranceSparrow);
    CHECK(m.rows[0].wavelength_nm == 550);
    CHECK(m.rows[0].p.inv_omega == 0);
    CHECK(file.warnings.empty());
}

TEST_CASE("Paints: each mistake is one line that names file, material, row and key") {
    const auto bad_row = [](const std::string& from, const std::string& to) {
        return file_of(replaced(kRow, from, to));
    };
    CHECK_THROWS_WITH(read(bad_row("sigma", "sigmma")),
                      Contains("paints.json: paint: row 1: unknown key 'sigmma'; did you mean "
                               "'sigma'?"));
    CHECK_THROWS_WITH(read(bad_row(R"("k": 0.1, )", "")), Contains("row 1: missing key 'k'"));
    CHECK_THROWS_WITH(read(bad_row("1.4", "\"1.4\"")), Contains("'n' must be a number"));
    CHECK_THROWS_WITH(read(bad_row("1.4", "0")), Contains("'n' is 0; it must be > 0"));
    CHECK_THROWS_WITH(read(bad_row("0.1,", "-0.1,")), Contains("'k' is -0.1"));
    CHECK_THROWS_WITH(read(bad_row("0.3", "1e-25")), Contains("'sigma' is 1e-25"));
    CHECK_THROWS_WITH(read(bad_row("0.1,", "1e10,")), Contains("'k' is 1e+10"));
    CHECK_THROWS_WITH(read(bad_row("1.4, \"k\": 0.1", "0.01, \"k\": 0.01")), Contains("|n + ik|"));
    CHECK_THROWS_WITH(read(bad_row("0.3", "0")),
                      Contains("'sigma' is 0; it must be within 1e-06 to 100"));
    CHECK_THROWS_WITH(read(bad_row("1.4", "1e999")), Contains("paints.json"));
    CHECK_THROWS_WITH(read(file_of(kRow + "," + kRow)), Contains("two rows") && Contains("550"));
    CHECK_THROWS_WITH(read(file_of("")), Contains("'rows'"));
    CHECK_THROWS_WITH(read(file_of(kRow, R"("slopes": "gausian", )")),
                      Contains("did you mean 'gaussian'"));
    CHECK_THROWS_WITH(
        read(bad_row(R"("rho_d")", R"("shadowing": {"tau": 1, "Omega": 2}, "rho_d")")),
        Contains("shadowing: missing key 'unit'"));
    CHECK_THROWS_WITH(read(bad_row(R"("n": 1.4)", R"("n": 1.4, "n": 1.5)")),
                      Contains("'n' stands twice"));
    CHECK_THROWS_WITH(read(file_of(replaced(kRow, "\"rho_v\": 0", "\"rho_v\": -0.2"),
                                   R"("negative_volume": "reject", )")),
                      Contains("negative"));
    CHECK_THROWS_WITH(read("{\"materials\": {\"paint\": "), Contains("not valid JSON"));
    CHECK_THROWS_WITH(read("[1, 2]"), Contains("expected an object"));
    CHECK_THROWS_WITH(read("{\"materials\": {}}"), Contains("holds no material"));
    CHECK_THROWS_WITH(read(std::string(300, '[')), Contains("nested"));
    CHECK_THROWS_WITH(read_materials("/nowhere/paints.json"), Contains("file not found"));
}
