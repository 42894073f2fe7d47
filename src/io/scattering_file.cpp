// scattering_file.cpp — tables of scattering matrices, checked on the way in.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/scattering_file.h"

#include <cmath>
#include <optional>

#include "io/csv.h"
#include "malus/core/error.h"
#include "malus/core/vec.h"
#include "malus/io/file.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

constexpr const char* kHeader = "angle_deg,F11,F12,F22,F33";

struct Layout {
    std::size_t first = 0;    // column of the angle
    std::size_t columns = 0;  // of a row
};

Layout layout_of(std::string header, const std::string& place) {
    std::erase(header, ' ');
    for (const char* start : {"", "wavelength_nm,"})
        for (const char* end : {"", ",F34,F44"})
            if (header == start + std::string(kHeader) + end)
                return {*start ? 1u : 0u, 5u + (*start ? 1 : 0) + (*end ? 2 : 0)};
    throw Error(place + ": the header must be " + kHeader +
                ", with wavelength_nm before or F34,F44 behind if wanted");
}

ScatteringElements checked(const ScatteringElements& F, const std::string& place) {
    if (!(F.F11 > 1e-30 && F.F11 < 1e30))
        throw Error(place + ": F11 must be > 0, and within 1e-30 to 1e30; mend the table");
    for (const auto& [name, x] : {std::pair{"F12", F.F12}, {"F22", F.F22}, {"F33", F.F33}})
        if (!(std::abs(x) <= F.F11 * (1 + 1e-6)))
            throw Error(place + ": |" + name +
                        "| exceeds F11 (no particle does that; are the other "
                        "elements given as in F11's unit?); mend the table");
    return F;
}

}  // namespace

ScatteringTable read_scattering(const std::filesystem::path& path) {
    const std::string file = path.string();
    ScatteringTable table;
    std::optional<Layout> layout;
    for_each_csv_line(read_text(path), [&](const std::string& line, int number) {
        const std::string place = csv_place(file, number);
        if (!layout) {
            layout = layout_of(line, place);
            return;
        }
        const std::vector<double> x = csv_numbers(line, layout->columns, place);
        const double nm = layout->first == 1 ? x[0] : 0;
        if (layout->first == 1 && !(nm > 0 && std::isfinite(nm)))
            throw Error(place + ": wavelength must be > 0 nm");
        const double angle_deg = x[layout->first];
        std::vector<ScatteringRow>& rows = table[nm];
        if (rows.empty() ? angle_deg != 0
                         : !(angle_deg > to_degrees(rows.back().angle) && angle_deg <= 180))
            throw Error(place + ": angles must ascend from 0 to 180 degrees for each wavelength");
        const double* F = &x[layout->first + 1];
        rows.push_back({to_radians(angle_deg), checked({F[0], F[1], F[2], F[3]}, place)});
    });
    if (table.empty())
        throw Error(file +
                    ": holds no rows; a scattering matrix needs angles from 0 to 180 degrees");
    for (const auto& [nm, rows] : table)
        if (std::abs(to_degrees(rows.back().angle) - 180) > 1e-6)
            throw Error(file + ": angles end at " + to_text(to_degrees(rows.back().angle)) +
                        " degrees; give them up to 180");
    return table;
}

}  // namespace malus
