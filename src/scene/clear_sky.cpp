// clear_sky.cpp — a clear sky of air: optical properties, and the map that the transfer of light gives.
//
//   F = (78.084 F_N2 + 20.946 F_O2 + 0.934 F_Ar + 0.036 F_CO2)/100,   ρ = 6 (F − 1)/(3 + 7 F)
//   F_N2 = 1.034 + 3.17e-4/λ²,  F_O2 = 1.096 + 1.385e-3/λ² + 1.448e-4/λ⁴,  F_Ar = 1,  F_CO2 = 1.15
//
// Units   λ in micrometres in formulas; radiance W m⁻² sr⁻¹ nm⁻¹.
// Source  sky.h; radiative_transfer.h.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/frame.h"
#include "malus/scene/sky.h"
#include "scene/radiative_transfer.h"

namespace malus {
namespace {

// Irradiance of the sun outside the atmosphere, W m⁻² nm⁻¹: π B(λ, T) (R/au)².
double solar_irradiance(double wavelength_nm) {
    constexpr double kPlanck = 6.62607015e-34, kLight = 299792458.0, kBoltzmann = 1.380649e-23;
    constexpr double kTemperature = 5772.0, kRadius = 6.957e8, kAstronomicalUnit = 1.495978707e11;
    const double l = wavelength_nm * 1e-9;
    const double radiance = 2 * kPlanck * kLight * kLight / std::pow(l, 5) /
                            std::expm1(kPlanck * kLight / (l * kBoltzmann * kTemperature));
    return kPi * radiance * sqr(kRadius / kAstronomicalUnit) * 1e-9;
}

void scale_polarization(std::vector<Stokes<double>>& nodes, double max_dolp) {
    double most = 0;
    for (const Stokes<double>& S : nodes) most = std::max(most, dolp(S));
    if (most == 0) return;
    const double scale = max_dolp / most;
    for (Stokes<double>& S : nodes) S = {S.s0, scale * S.s1, scale * S.s2, S.s3};
}

}  // namespace

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
                   int azimuths) {
    Sky sky;
    sky.wavelengths_nm.assign(wavelengths_nm.begin(), wavelengths_nm.end());
    std::vector<double> mu;
    for (int i = 0; i < zeniths; ++i) {
        sky.zeniths.push_back((i + 0.5) * kPi / 2 / zeniths);
        mu.push_back(std::cos(sky.zeniths.back()));
    }
    for (int i = 0; i < azimuths; ++i) sky.azimuths.push_back((i + 0.5) * 2 * kPi / azimuths);
    sky.sun = Sun{model.sun_zenith, model.sun_azimuth, {}};
    for (double nm : wavelengths_nm) {
        const RayleighLayer air{rayleigh_optical_depth(nm, model.pressure_hpa),
                                rayleigh_depolarization(nm), model.ground_albedo};
        const double E0 = solar_irradiance(nm);
        for (const SkyModes& row : light_at_ground(air, std::cos(model.sun_zenith), mu))
            for (double a : sky.azimuths) sky.nodes.push_back(E0 * row.at(a - model.sun_azimuth));
    }
    if (model.max_dolp) scale_polarization(sky.nodes, *model.max_dolp);
    return sky;
}

}  // namespace malus
