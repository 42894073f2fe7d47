// sky_import.cpp — columns by their names, pictures by their edges, then our conventions.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/sky_import.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "io/csv.h"
#include "io/sky_grid.h"
#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/io/sky_file.h"
#include "malus/optics/wavelengths.h"

namespace fs = std::filesystem;

namespace malus {
namespace {

// --- numbers by wavelength ---------------------------------------------------------------------

std::optional<double> value_at(const BySpectrum& values, double nm) {
    for (const auto& [key, value] : values)
        if (std::abs(key - nm) < kSameWavelength_nm) return value;
    const auto all = values.find(0);
    return all != values.end() ? std::optional(all->second) : std::nullopt;
}

// Throws unless there is a number for each wavelength and none besides.
void check_covers(const BySpectrum& values, const Sky& sky, const std::string& place) {
    for (double nm : sky.wavelengths_nm)
        if (!value_at(values, nm))
            throw Error(place + ": says nothing of " + to_text(nm) + " nm; add it");
    for (const auto& [nm, value] : values)
        if (nm != 0 && !find_wavelength(sky.wavelengths_nm, nm))
            throw Error(place + ": the map has no " + to_text(nm) + " nm; it has " +
                        to_text(sky.wavelengths_nm) + " nm");
}

Stokes<double> scaled(const Stokes<double>& S, const BySpectrum& scale, double nm) {
    return scale.empty() ? S : value_at(scale, nm).value_or(1) * S;
}

// --- CSV ---------------------------------------------------------------------------------------

enum Column { kWavelength, kZenith, kAzimuth, kS0, kS1, kS2, kS3, kColumns };

// Our name, and what other codes say.
constexpr std::array<std::array<std::string_view, 3>, kColumns> kNames{{{"wavelength", "lambda"},
                                                                        {"zenith", "theta", "vza"},
                                                                        {"azimuth", "phi", "vaa"},
                                                                        {"s0", "i"},
                                                                        {"s1", "q"},
                                                                        {"s2", "u"},
                                                                        {"s3", "v"}}};

// Where the columns of a table stand.
struct Layout {
    std::array<std::optional<std::size_t>, kColumns> at;
    std::size_t count = 0;
    std::vector<std::string> unused;
};

// "Zenith [deg]" as "zenith".
std::string plain(std::string_view name) {
    std::string text;
    for (char c : name)
        if (c != ' ' && c != '\t' && c != '"')
            text += c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
    for (std::string_view ending : {"_deg", "(deg)", "[deg]", "_nm", "(nm)", "[nm]"})
        if (text.ends_with(ending)) text.resize(text.size() - ending.size());
    return text;
}

std::optional<std::size_t> column_named(const std::string& name) {
    for (std::size_t c = 0; c < kColumns; ++c)
        for (std::string_view known : kNames[c])
            if (!name.empty() && name == known) return c;
    return std::nullopt;
}

// "zenith or theta or vza"
std::string names_of(std::size_t column) {
    std::string text;
    for (std::string_view name : kNames[column])
        if (!name.empty()) text += (text.empty() ? "" : " or ") + std::string(name);
    return text;
}

Layout layout_of(const std::string& header, const std::string& place, bool wavelength_given) {
    Layout layout;
    for (std::string_view cell : csv_cells(header)) {
        const auto column = column_named(plain(cell));
        if (!column)
            layout.unused.push_back(one_line(std::string(cell), 40));
        else if (layout.at[*column])
            throw Error(place + ": two columns for " + names_of(*column) + "; keep one");
        else
            layout.at[*column] = layout.count;
        ++layout.count;
    }
    if (wavelength_given && layout.at[kWavelength])
        throw Error(place +
                    ": there is a column for the wavelength already; leave out --wavelength");
    for (std::size_t c = wavelength_given ? kZenith : kWavelength; c < kS3; ++c)
        if (!layout.at[c])
            throw Error(place + ": no column " + names_of(c) +
                        (c == kWavelength ? "; add it or give --wavelength"
                                          : "; name the columns in the first line"));
    return layout;
}

SkyRow parse_row(const std::string& line, int number, const Layout& layout,
                 const SkyImport& options, const std::string& file) {
    const auto place = [&] { return csv_place(file, number); };
    const std::vector<std::string_view> cells = csv_cells(line);
    if (cells.size() != layout.count)
        throw Error(place() + ": " + std::to_string(cells.size()) + " columns instead of " +
                    std::to_string(layout.count));
    const auto value = [&](Column c, double absent) {
        return layout.at[c] ? number_in(cells[*layout.at[c]], place()) : absent;
    };
    const double nm = value(kWavelength, options.wavelength_nm.value_or(0));
    if (!(nm > 0) || !std::isfinite(nm)) throw Error(place() + ": wavelength must be > 0 nm");
    const double zenith = value(kZenith, 0), azimuth = value(kAzimuth, 0);
    if (!(zenith >= 0 && zenith <= 180))
        throw Error(place() + ": zenith angle " + to_text(zenith) +
                    " must be within 0 to 180 degrees");
    if (!(std::abs(azimuth) <= 360))
        throw Error(place() + ": azimuth " + to_text(azimuth) +
                    " must be within -360 to 360 degrees");
    const Stokes<double> S{value(kS0, 0), value(kS1, 0), value(kS2, 0), value(kS3, 0)};
    return {nm, zenith, azimuth, checked_light(scaled(S, options.scale, nm), place), number};
}

// The table in its own conventions.
Sky from_table(const fs::path& path, const SkyImport& options) {
    const std::string file = path.string();
    std::optional<Layout> layout;
    std::vector<SkyRow> rows;
    for_each_csv_line(read_text(path), [&](const std::string& line, int number) {
        if (layout)
            rows.push_back(parse_row(line, number, *layout, options, file));
        else
            layout = layout_of(line, csv_place(file, number), options.wavelength_nm.has_value());
    });
    Sky sky = sky_from_rows(std::move(rows), file);
    std::string unused;
    for (const std::string& name : layout->unused) unused += (unused.empty() ? "" : ", ") + name;
    if (!unused.empty()) sky.warnings.push_back(file + ": columns not used: " + unused);
    return sky;
}

// --- EXR ---------------------------------------------------------------------------------------

// The picture in its own conventions.
Sky from_picture(const fs::path& path, const SkyImport& options) {
    Sky sky = read_sky(path);
    for (std::size_t i = 0; i < sky.nodes.size(); ++i) {
        const std::size_t w = i / (sky.zeniths.size() * sky.azimuths.size());
        sky.nodes[i] = checked_light(scaled(sky.nodes[i], options.scale, sky.wavelengths_nm[w]),
                                     [&] { return path.string() + ": scaled"; });
    }
    const bool propagation = options.conventions.angles_of == AnglesOf::kPropagation;
    const std::array<double, 2> span =
        options.zenith_span.value_or(std::array<double, 2>{propagation ? kPi : 0, kPi / 2});
    const double rows = static_cast<double>(sky.zeniths.size());
    for (std::size_t z = 0; z < sky.zeniths.size(); ++z)
        sky.zeniths[z] = span[0] + (static_cast<double>(z) + 0.5) / rows * (span[1] - span[0]);
    return sky;
}

// --- both --------------------------------------------------------------------------------------

void mirror(Sky& sky, const std::string& file) {
    constexpr double kRounding = 1e-6;
    for (double a : sky.azimuths)
        if (a < -kRounding || a > kPi + kRounding)
            throw Error(file + ": azimuth " + to_text(std::round(to_degrees(a) * 1e6) / 1e6) +
                        " is beyond the half from 0 to 180 degrees that is to be mirrored; leave "
                        "out --mirror");
    sky = with_mirror_image(sky);
}

void declare_sun(Sky& sky, const SkyImport& options, const std::string& file) {
    if (options.sun) {
        const std::vector<double> irradiance =
            sky.sun ? sky.sun->irradiance : std::vector<double>{};
        sky.sun = Sun{options.sun->zenith, options.sun->azimuth, irradiance};
    }
    if (options.sun_irradiance.empty()) return;
    if (!sky.sun)
        throw Error(file +
                    ": no sun is declared whose irradiance could be given; give "
                    "--sun-zenith and --sun-azimuth");
    check_covers(options.sun_irradiance, sky, "--sun-irradiance");
    sky.sun->irradiance.clear();
    for (double nm : sky.wavelengths_nm)
        sky.sun->irradiance.push_back(*value_at(options.sun_irradiance, nm));
    for (double irradiance : sky.sun->irradiance)
        if (!(irradiance >= 0 && irradiance <= kMostIrradiance))
            throw Error("--sun-irradiance: " + to_text(irradiance) +
                        " is not within 0 to 1e15 W m^-2 nm^-1");
}

Sky above_horizon(const Sky& map, const SkyConventions& conventions, const std::string& file) {
    Sky ours = in_our_conventions(map, conventions);
    if (ours.zeniths.empty())
        throw Error(file + ": every direction lies below the horizon; the angles may be those of " +
                    (conventions.angles_of == AnglesOf::kView ? "propagation" : "view") +
                    " (--direction)");
    if (const std::size_t below = map.zeniths.size() - ours.zeniths.size(); below > 0)
        ours.warnings.push_back(file + ": " + std::to_string(below) + " of " +
                                std::to_string(map.zeniths.size()) +
                                " zenith angles lie below the horizon and are left out");
    return ours;
}

}  // namespace

Sky import_sky(const fs::path& path, const SkyImport& options) {
    const std::string file = path.string();
    Sky map = is_csv(path) ? from_table(path, options) : from_picture(path, options);
    if (!options.scale.empty()) check_covers(options.scale, map, "--scale");
    if (options.half_dome == HalfDome::kMirrored) mirror(map, file);
    Sky ours = above_horizon(map, options.conventions, file);
    for (const std::string& gap : gaps_in(ours, file)) ours.warnings.push_back(gap);
    declare_sun(ours, options, file);
    const MapSize like = grid_like(ours);
    ours = at_pixel_centres(ours, {options.height > 0 ? options.height : like.zeniths,
                                   options.width > 0 ? options.width : like.azimuths});
    ours.source = file;
    return ours;
}

}  // namespace malus
