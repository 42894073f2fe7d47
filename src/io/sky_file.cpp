// sky_file.cpp — sky maps between files and memory, checked on the way in.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/sky_file.h"

#include <array>
#include <sstream>

#include "io/csv.h"
#include "io/sky_grid.h"
#include "malus/core/error.h"
#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/wavelengths.h"

namespace fs = std::filesystem;

namespace malus {
namespace {

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
        if (!(value >= 0 && value <= kMostIrradiance))
            throw Error(place + ": at " + to_text(nm) + " nm it must be within 0 to 1e15");
        const auto w = find_wavelength(sky.wavelengths_nm, nm);
        if (w && irradiance[*w] >= 0)
            throw Error(place + ": gives " + to_text(nm) + " nm twice; keep one");
        if (w) irradiance[*w] = value;
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
    for (const char* name : {"sunZenith", "sunAzimuth"})
        if (image.attributes.contains(name) && !image.number(name))
            throw Error(file + ": attribute " + name + " must be a float");
    if (image.attributes.contains("sunIrradiance") && !image.text("sunIrradiance"))
        throw Error(file + ": attribute sunIrradiance must be a string like 440nm:1.52;");
    const float* zenith = image.number("sunZenith");
    const float* azimuth = image.number("sunAzimuth");
    const std::string* irradiance = image.text("sunIrradiance");
    if ((zenith == nullptr) != (azimuth == nullptr))
        throw Error(file + ": sunZenith and sunAzimuth belong together; add the other");
    if (!zenith) {
        if (irradiance)
            throw Error(file + ": sunIrradiance without sunZenith and sunAzimuth; add them");
        return;
    }
    if (!(*zenith >= 0 && *zenith <= 180))
        throw Error(file + ": sunZenith must be within 0 to 180 degrees");
    if (!(std::abs(*azimuth) <= 360))
        throw Error(file + ": sunAzimuth must be within -360 to 360 degrees");
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
            sky.nodes.push_back(checked_light({s(0), s(1), s(2), s3_sign * s(3)}, [&] {
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

constexpr const char* kCsvHeader = "wavelength_nm,zenith_deg,azimuth_deg,S0,S1,S2,S3";

SkyRow parse_row(const std::string& text, int line, const std::string& file) {
    const std::string place = csv_place(file, line);
    const std::vector<double> x = csv_numbers(text, 7, place, kCsvHeader);
    if (!std::isfinite(x[0]) || !(x[0] > 0)) throw Error(place + ": wavelength must be > 0 nm");
    if (!(x[1] >= 0 && x[1] <= 90)) throw Error(place + ": zenith_deg must be within 0 to 90");
    if (!(x[2] >= 0 && x[2] <= 360)) throw Error(place + ": azimuth_deg must be within 0 to 360");
    return {x[0], x[1], x[2], checked_light({x[3], x[4], x[5], x[6]}, [&] { return place; }), line};
}

Sky from_csv(const fs::path& path) {
    const std::string file = path.string();
    std::vector<SkyRow> rows;
    bool header = false;
    for_each_csv_line(read_text(path), [&](std::string line, int number) {
        if (header) {
            rows.push_back(parse_row(line, number, file));
            return;
        }
        std::erase(line, ' ');
        if (line != kCsvHeader)
            throw Error(csv_place(file, number) + ": the header must be " + kCsvHeader);
        header = true;
    });
    return sky_from_rows(std::move(rows), file);
}

}  // namespace

bool is_csv(const fs::path& path) {
    std::string ending = path.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return ending == ".csv";
}

Sky read_sky(const fs::path& path) {
    Sky sky = is_csv(path) ? from_csv(path) : from_exr(path);
    sky.source = path.string();
    sky.warnings = gaps_in(sky, path.string());
    return sky;
}

void write_sky(const fs::path& path, const Sky& sky,
               const std::map<std::string, std::string>& attributes) {
    for (std::size_t i = 0; i < sky.nodes.size(); ++i)
        if (const std::string fault = fault_of(sky.nodes[i]); !fault.empty())
            throw Error(
                path.string() + ": not written: " +
                to_text(sky.wavelengths_nm[i / (sky.zeniths.size() * sky.azimuths.size())]) +
                " nm, node " + std::to_string(i % (sky.zeniths.size() * sky.azimuths.size())) +
                ": " + fault);
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
