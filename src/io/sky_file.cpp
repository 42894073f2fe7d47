// sky_file.cpp — sky maps between files and memory, checked on the way in.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/sky_file.h"

#include <algorithm>
#include <array>
#include <sstream>

#include "io/csv.h"
#include "malus/core/error.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/wavelengths.h"

namespace fs = std::filesystem;

namespace malus {
namespace {

// Beyond this floats would overflow on the way to a picture, W m⁻² sr⁻¹ nm⁻¹. (The sun has 3e4.)
constexpr double kBrightest = 1e20;

// Throws unless S is light. Maps are 32-bit floats, so |S| may exceed S0 by their rounding; such a
// vector is brought back onto |S| = S0.
// place() names where S stands; it is called for a message only.
template <class Place>
Stokes<double> checked(const Stokes<double>& S, Place place) {
    if (!std::isfinite(S.s0 + S.s1 + S.s2 + S.s3))
        throw Error(place() + ": a Stokes component is not finite; mend the map");
    if (S.s0 > kBrightest)
        throw Error(place() + ": S0 = " + to_text(S.s0) +
                    " is brighter than anything; mend the map");
    if (S.s0 < 0) throw Error(place() + ": S0 = " + to_text(S.s0) + " is negative; mend the map");
    const double P = std::sqrt(S.s1 * S.s1 + S.s2 * S.s2 + S.s3 * S.s3);
    if (P > S.s0 * (1 + 1e-5))
        throw Error(place() + ": |(S1,S2,S3)| = " + to_text(P) + " exceeds S0 = " + to_text(S.s0) +
                    " (no light is polarized more than wholly); mend the map");
    const double shrink = P > S.s0 ? S.s0 / P : 1;
    return {S.s0, S.s1 * shrink, S.s2 * shrink, S.s3 * shrink};
}

// --- EXR ---------------------------------------------------------------------------------------

// "440nm:1.52;600nm:1.63;" at the sky's wavelengths.
std::vector<double> sun_irradiance(const std::string& text, const Sky& sky,
                                   const std::string& file) {
    const std::string place = file + ": attribute sunIrradiance";
    std::vector<double> irradiance(sky.wavelengths_nm.size(), -1);
    std::istringstream entries(text);
    for (std::string entry; std::getline(entries, entry, ';');) {
        const std::size_t colon = entry.find("nm:");
        if (entry.empty()) continue;
        if (colon == std::string::npos)
            throw Error(place + ": '" + one_line(entry, 40) + "' is not of the form 440nm:1.52");
        const double nm = number_in(std::string_view(entry).substr(0, colon), place);
        const double value = number_in(std::string_view(entry).substr(colon + 3), place);
        if (!(value >= 0)) throw Error(place + ": " + to_text(nm) + " nm is negative");
        if (const auto w = find_wavelength(sky.wavelengths_nm, nm)) irradiance[*w] = value;
    }
    for (std::size_t w = 0; w < irradiance.size(); ++w)
        if (irradiance[w] < 0)
            throw Error(place + ": says nothing of " + to_text(sky.wavelengths_nm[w]) +
                        " nm; add it");
    return irradiance;
}

// +1 when S3 > 0 means right-handed light, as it does for us and where nothing is said.
double handedness(const Image& image, const std::string& file) {
    const std::string* word = image.text("polarisationHandedness");
    if (!word || *word == "right") return 1;
    if (*word == "left") return -1;
    throw Error(file + ": polarisationHandedness is '" + one_line(*word) +
                "'; it must be 'right' or 'left'");
}

void read_sun(const Image& image, Sky& sky, const std::string& file) {
    const float* zenith = image.number("sunZenith");
    const float* azimuth = image.number("sunAzimuth");
    const std::string* irradiance = image.text("sunIrradiance");
    if (!zenith || !azimuth) {
        if (irradiance)
            throw Error(file + ": sunIrradiance without sunZenith and sunAzimuth; add them");
        return;
    }
    sky.sun = Sun{
        to_radians(static_cast<double>(*zenith)), to_radians(static_cast<double>(*azimuth)), {}};
    if (irradiance) sky.sun->irradiance = sun_irradiance(*irradiance, sky, file);
}

Sky from_exr(const fs::path& path) {
    const std::string file = path.string();
    const Image image = read_exr(path);
    Sky sky;
    try {
        sky.wavelengths_nm = stokes_wavelengths(image);
    } catch (const Error& problem) {
        throw Error(file + ": " + problem.what());
    }
    if (sky.wavelengths_nm.empty())
        throw Error(file + ": no channels S0.…nm to S3.…nm; this is not a sky map");
    const double s3_sign = handedness(image, file);
    const std::string* frame = image.text("stokesReferenceFrame");
    if (frame && *frame != "meridian")
        throw Error(file + ": stokesReferenceFrame is '" + one_line(*frame) +
                    "'; a sky map must be in the frame 'meridian'");
    for (int y = 0; y < image.height; ++y)
        sky.zeniths.push_back((y + 0.5) * kPi / 2 / image.height);
    for (int x = 0; x < image.width; ++x) sky.azimuths.push_back((x + 0.5) * 2 * kPi / image.width);
    for (double nm : sky.wavelengths_nm) {
        std::array<const float*, 4> S{};
        for (std::size_t c = 0; c < 4; ++c)
            S[c] = spectral_data(image, "S" + std::to_string(c), nm).data();
        for (std::size_t i = 0; i < image.pixel_count(); ++i) {
            const auto s = [&](std::size_t c) { return static_cast<double>(S[c][i]); };
            sky.nodes.push_back(checked({s(0), s(1), s(2), s3_sign * s(3)}, [&] {
                const auto width = static_cast<std::size_t>(image.width);
                return file + ": " + to_text(nm) + " nm, pixel (" + std::to_string(i % width) +
                       "," + std::to_string(i / width) + ")";
            }));
        }
    }
    read_sun(image, sky, file);
    return sky;
}

// --- CSV ---------------------------------------------------------------------------------------

struct CsvRow {
    double wavelength_nm, zenith_deg, azimuth_deg;
    Stokes<double> S;
    int line;
};

constexpr const char* kCsvHeader = "wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3";

CsvRow parse_row(const std::string& text, int line, const std::string& file) {
    const std::string place = file + ": line " + std::to_string(line);
    std::array<double, 7> x{};
    std::size_t column = 0, start = 0;
    for (;; ++column) {
        const std::size_t end = std::min(text.find(',', start), text.size());
        if (column < x.size())
            x[column] = number_in(std::string_view(text).substr(start, end - start), place);
        if (end == text.size()) break;
        start = end + 1;
    }
    if (column != 6)
        throw Error(place + ": " + std::to_string(column + 1) + " columns instead of 7 (" +
                    kCsvHeader + ")");
    if (!std::isfinite(x[0]) || !(x[0] > 0)) throw Error(place + ": wavelength must be > 0 nm");
    if (!(x[1] >= 0 && x[1] <= 90)) throw Error(place + ": zenith_deg must be within 0 to 90");
    if (!(x[2] >= 0 && x[2] <= 360)) throw Error(place + ": azimuth_deg must be within 0 to 360");
    return {x[0], x[1], x[2], checked({x[3], x[4], x[5], x[6]}, [&] { return place; }), line};
}

std::vector<CsvRow> parse_rows(const std::string& text, const std::string& file) {
    std::vector<CsvRow> rows;
    std::istringstream lines(text);
    bool header = false;
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
        if (line.empty() || line.front() == '#') continue;
        if (!header) {
            std::erase(line, ' ');
            if (line != kCsvHeader)
                throw Error(file + ": line " + std::to_string(number) + ": the header must be " +
                            kCsvHeader);
            header = true;
            continue;
        }
        rows.push_back(parse_row(line, number, file));
    }
    if (rows.empty()) throw Error(file + ": holds no rows; a sky map needs a full grid");
    return rows;
}

// The distinct values of a column, ascending; closer ones than `same` are one.
template <class Column>
std::vector<double> distinct(const std::vector<CsvRow>& rows, double same, Column column) {
    std::vector<double> values;
    for (const CsvRow& row : rows) values.push_back(row.*column);
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end(),
                             [same](double a, double b) { return b - a < same; }),
                 values.end());
    return values;
}

std::size_t index_of(const std::vector<double>& values, double x, double same) {
    const auto found = std::lower_bound(values.begin(), values.end(), x - same);
    return static_cast<std::size_t>(found - values.begin());
}

Sky from_csv(const fs::path& path) {
    const std::string file = path.string();
    constexpr double kSameAngle = 1e-6;  // degrees
    std::vector<CsvRow> rows = parse_rows(read_text(path), file);
    Sky sky;
    sky.wavelengths_nm = distinct(rows, kSameWavelength_nm, &CsvRow::wavelength_nm);
    const std::vector<double> zeniths = distinct(rows, kSameAngle, &CsvRow::zenith_deg);
    std::vector<double> azimuths = distinct(rows, kSameAngle, &CsvRow::azimuth_deg);
    // 0° and 360° are one direction: where a file gives both, 360° is left out.
    if (azimuths.size() > 1 && azimuths.front() < kSameAngle &&
        azimuths.back() > 360 - kSameAngle) {
        azimuths.pop_back();
        std::erase_if(rows, [&](const CsvRow& row) { return row.azimuth_deg > 360 - kSameAngle; });
    }
    const std::size_t count = sky.wavelengths_nm.size() * zeniths.size() * azimuths.size();
    if (count > 4 * rows.size() + 1000)
        throw Error(file + ": " + std::to_string(rows.size()) + " rows cannot fill the grid of " +
                    std::to_string(count) + " nodes that their angles span; give a full grid");
    std::vector<int> line_of(count, 0);
    sky.nodes.resize(count);
    for (const CsvRow& row : rows) {
        const std::size_t i =
            (index_of(sky.wavelengths_nm, row.wavelength_nm, kSameWavelength_nm) * zeniths.size() +
             index_of(zeniths, row.zenith_deg, kSameAngle)) *
                azimuths.size() +
            index_of(azimuths, row.azimuth_deg, kSameAngle);
        if (line_of[i] != 0)
            throw Error(file + ": line " + std::to_string(row.line) + ": same node as line " +
                        std::to_string(line_of[i]) + "; keep one");
        line_of[i] = row.line;
        sky.nodes[i] = row.S;
    }
    for (std::size_t i = 0; i < count; ++i)
        if (line_of[i] == 0)
            throw Error(file + ": a gap in the grid: no row for " +
                        to_text(sky.wavelengths_nm[i / (zeniths.size() * azimuths.size())]) +
                        " nm, zenith " + to_text(zeniths[i / azimuths.size() % zeniths.size()]) +
                        ", azimuth " + to_text(azimuths[i % azimuths.size()]) + "; add it");
    for (double z : zeniths) sky.zeniths.push_back(to_radians(z));
    for (double a : azimuths) sky.azimuths.push_back(to_radians(a));
    return sky;
}

// What a map leaves out of the dome, in words.
std::vector<std::string> gaps(const Sky& sky, const std::string& file) {
    std::vector<std::string> found;
    const auto degrees = [](double x) { return to_text(std::round(to_degrees(x) * 100) / 100); };
    if (sky.zeniths.front() > to_radians(15) || sky.zeniths.back() < to_radians(75))
        found.push_back(file + ": zenith angles cover " + degrees(sky.zeniths.front()) + " to " +
                        degrees(sky.zeniths.back()) +
                        " of 0 to 90 degrees; beyond, the sky is taken as at their edge");
    for (std::size_t i = 0; i < sky.azimuths.size() && sky.azimuths.size() > 1; ++i) {
        const std::size_t next = (i + 1) % sky.azimuths.size();
        const double gap = sky.azimuths[next] - sky.azimuths[i] + (next == 0 ? 2 * kPi : 0);
        if (gap > to_radians(100))
            found.push_back(file + ": no azimuth between " + degrees(sky.azimuths[i]) + " and " +
                            degrees(sky.azimuths[next]) + " degrees; interpolated across");
    }
    return found;
}

}  // namespace

Sky read_sky(const fs::path& path) {
    std::string ending = path.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    Sky sky = ending == ".csv" ? from_csv(path) : from_exr(path);
    sky.source = path.string();
    sky.warnings = gaps(sky, path.string());
    return sky;
}

void write_sky(const fs::path& path, const Sky& sky,
               const std::map<std::string, std::string>& attributes) {
    Image image;
    image.width = static_cast<int>(sky.azimuths.size());
    image.height = static_cast<int>(sky.zeniths.size());
    declare_stokes(image, "meridian");
    for (const auto& [name, value] : attributes) image.attributes[name] = value;
    if (sky.sun) {
        image.attributes["sunZenith"] = static_cast<float>(to_degrees(sky.sun->zenith));
        const double azimuth = to_degrees(sky.sun->azimuth);
        image.attributes["sunAzimuth"] =
            static_cast<float>(azimuth - 360 * std::floor(azimuth / 360));
        std::string irradiance;
        for (std::size_t w = 0; w < sky.sun->irradiance.size(); ++w)
            irradiance +=
                to_text(sky.wavelengths_nm[w]) + "nm:" + to_text(sky.sun->irradiance[w]) + ";";
        if (!irradiance.empty()) image.attributes["sunIrradiance"] = irradiance;
    }
    for (std::size_t w = 0; w < sky.wavelengths_nm.size(); ++w) {
        std::array<float*, 4> S{};
        for (std::size_t c = 0; c < 4; ++c)
            S[c] = image.channel(spectral_channel("S" + std::to_string(c), sky.wavelengths_nm[w]))
                       .data();
        for (std::size_t i = 0; i < image.pixel_count(); ++i) {
            const Stokes<double>& node = sky.nodes[w * image.pixel_count() + i];
            S[0][i] = static_cast<float>(node.s0);
            S[1][i] = static_cast<float>(node.s1);
            S[2][i] = static_cast<float>(node.s2);
            S[3][i] = static_cast<float>(node.s3);
        }
    }
    write_exr(path, image);
}

}  // namespace malus
