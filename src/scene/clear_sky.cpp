// clear_sky.cpp — optical properties of air and aerosol, and the map that the transfer of light gives.
//
//   F = (78.084 F_N2 + 20.946 F_O2 + 0.934 F_Ar + 0.036 F_CO2)/100,   ρ = 6 (F − 1)/(3 + 7 F)
//   F_N2 = 1.034 + 3.17e-4/λ²,  F_O2 = 1.096 + 1.385e-3/λ² + 1.448e-4/λ⁴,  F_Ar = 1,  F_CO2 = 1.15
//
// Units   λ in micrometres in formulas.
// Source  clear_sky.h.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/clear_sky.h"

#include <algorithm>
#include <charconv>

#include "malus/core/error.h"
#include "malus/core/frame.h"
#include "malus/optics/wavelengths.h"
#include "scene/radiative_transfer.h"

namespace malus {
namespace {

constexpr std::string_view kSolarTable =
#include "solar_irradiance.inc"  // the CSV file as a string
    ;

struct SpectrumRow {
    double wavelength_nm, irradiance;
};

std::vector<SpectrumRow> parse_solar_table() {
    std::vector<SpectrumRow> rows;
    for (std::size_t begin = 0, end = 0; begin < kSolarTable.size(); begin = end + 1) {
        end = std::min(kSolarTable.find('\n', begin), kSolarTable.size());
        const char* const last = kSolarTable.data() + end;
        SpectrumRow row{};
        const auto nm = std::from_chars(kSolarTable.data() + begin, last, row.wavelength_nm);
        if (nm.ec != std::errc() || nm.ptr == last || *nm.ptr != ',') continue;  // comment, header
        if (std::from_chars(nm.ptr + 1, last, row.irradiance).ec == std::errc())
            rows.push_back(row);
    }
    return rows;
}

void scale_polarization(std::vector<Stokes<double>>& nodes, double max_dolp) {
    double most = 0;
    for (const Stokes<double>& S : nodes) most = std::max(most, dolp(S));
    if (most == 0) return;
    const double scale = max_dolp / most;
    for (Stokes<double>& S : nodes) S = {S.s0, scale * S.s1, scale * S.s2, S.s3};
}

ScatteringMatrix aerosol_matrix(const Aerosol& aerosol, double wavelength_nm) {
    if (aerosol.table.empty())
        return henyey_greenstein_matrix(aerosol.asymmetry, aerosol.polarization);
    for (const auto& [nm, rows] : aerosol.table)
        if (nm == 0 || std::abs(nm - wavelength_nm) < kSameWavelength_nm)
            return tabulated_matrix(rows);
    std::vector<double> known;
    for (const auto& [nm, rows] : aerosol.table) known.push_back(nm);
    throw Error("aerosol: the scattering matrix has no wavelength " + to_text(wavelength_nm) +
                " nm; it has " + to_text(known) + " nm");
}

Atmosphere atmosphere(const ClearSky& model, double wavelength_nm) {
    const Scatterer air{
        model.optical_depth.value_or(rayleigh_optical_depth(wavelength_nm, model.pressure_hpa)), 1,
        rayleigh_matrix(model.depolarization.value_or(rayleigh_depolarization(wavelength_nm)))};
    const Aerosol& aerosol = model.aerosol;
    if (aerosol.optical_depth_550 == 0) return {{{air}}, model.ground_albedo};
    const Scatterer haze{
        aerosol.optical_depth_550 * std::pow(wavelength_nm / 550, -aerosol.angstrom_exponent),
        aerosol.single_scattering_albedo, aerosol_matrix(aerosol, wavelength_nm)};
    if (aerosol.place == AerosolPlace::kMixed) return {{{air, haze}}, model.ground_albedo};
    return {{{air}, {haze}}, model.ground_albedo};
}

}  // namespace

double solar_irradiance(double wavelength_nm) {
    static const std::vector<SpectrumRow> rows = parse_solar_table();
    if (!(wavelength_nm >= rows.front().wavelength_nm &&
          wavelength_nm <= rows.back().wavelength_nm))
        throw Error("sun: " + to_text(wavelength_nm) + " nm lies outside the table of its light, " +
                    to_text(rows.front().wavelength_nm) + " to " +
                    to_text(rows.back().wavelength_nm) + " nm");
    const auto above =
        std::upper_bound(rows.begin() + 1, rows.end() - 1, wavelength_nm,
                         [](double nm, const SpectrumRow& row) { return nm < row.wavelength_nm; });
    const SpectrumRow &a = *(above - 1), &b = *above;
    const double t = (wavelength_nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm);
    return (1 - t) * a.irradiance + t * b.irradiance;
}

double rayleigh_optical_depth(double wavelength_nm, double pressure_hpa) {
    const double l2 = sqr(wavelength_nm * 1e-3);
    return pressure_hpa / 1013.25 * 0.0021520 * (1.0455996 - 341.29061 / l2 - 0.90230850 * l2) /
           (1 + 0.0027059889 / l2 - 85.968563 * l2);
}

double rayleigh_depolarization(double wavelength_nm) {
    const double l2 = sqr(wavelength_nm * 1e-3);
    const double nitrogen = 1.034 + 3.17e-4 / l2;
    const double oxygen = 1.096 + 1.385e-3 / l2 + 1.448e-4 / (l2 * l2);
    const double king = (78.084 * nitrogen + 20.946 * oxygen + 0.934 + 0.036 * 1.15) / 100;
    return 6 * (king - 1) / (3 + 7 * king);
}

Sky make_clear_sky(const ClearSky& model, std::span<const double> wavelengths_nm, int zeniths,
                   int azimuths, const std::function<void(double)>& progress) {
    Sky sky;
    sky.wavelengths_nm.assign(wavelengths_nm.begin(), wavelengths_nm.end());
    std::vector<double> mu, from_sun;
    for (int i = 0; i < zeniths; ++i) {
        sky.zeniths.push_back((i + 0.5) * kPi / 2 / zeniths);
        mu.push_back(std::cos(sky.zeniths.back()));
    }
    for (int i = 0; i < azimuths; ++i) {
        sky.azimuths.push_back((i + 0.5) * 2 * kPi / azimuths);
        from_sun.push_back(sky.azimuths.back() - model.sun_azimuth);
    }
    sky.sun = Sun{model.sun_zenith, model.sun_azimuth, {}};
    for (double nm : wavelengths_nm) {
        const double E0 = model.solar_irradiance ? *model.solar_irradiance : solar_irradiance(nm);
        const GroundLight light =
            light_at_ground(atmosphere(model, nm), std::cos(model.sun_zenith), mu, from_sun);
        for (const Stokes<double>& S : light.sky) sky.nodes.push_back(E0 * S);
        sky.sun->irradiance.push_back(E0 * light.direct);
        if (progress)
            progress(static_cast<double>(sky.sun->irradiance.size()) /
                     static_cast<double>(wavelengths_nm.size()));
    }
    if (model.max_dolp) scale_polarization(sky.nodes, *model.max_dolp);
    return sky;
}

}  // namespace malus
