// rayleigh_sky.cpp — a clear sky of air that scatters sunlight once.
//
//   I(w) = E0 · ¾(1 + cos²Θ)/(4π) · μ0/(μ0 − μ) · (e^{−τ/μ0} − e^{−τ/μ}),  μ = cos z, μ0 = cos z_sun
//   DoLP = p_max sin²Θ/(1 + cos²Θ), E-vector perpendicular to the plane of sun and view
//
// Range   μ → μ0 is a removable singularity: τ e^{−τ/μ}/μ; at the horizon μ → 0: e^{−τ/μ0}.
// Source  Chandrasekhar, Radiative Transfer (1960), §9 and §17; Bodhaine et al., J. Atmos. Oceanic
//         Technol. 16, 1854 (1999), eq. 30.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/frame.h"
#include "malus/scene/sky.h"

namespace malus {
namespace {

// Optical depth of the whole atmosphere at sea level, 45° latitude, 360 ppm CO2; λ in micrometres.
double rayleigh_optical_depth(double wavelength_nm) {
    const double l2 = sqr(wavelength_nm * 1e-3);
    return 0.0021520 * (1.0455996 - 341.29061 / l2 - 0.90230850 * l2) /
           (1 + 0.0027059889 / l2 - 85.968563 * l2);
}

// Irradiance of the sun outside the atmosphere, W m⁻² nm⁻¹: π B(λ, T) (R/au)².
double solar_irradiance(double wavelength_nm) {
    constexpr double kPlanck = 6.62607015e-34, kLight = 299792458.0, kBoltzmann = 1.380649e-23;
    constexpr double kTemperature = 5772.0, kRadius = 6.957e8, kAstronomicalUnit = 1.495978707e11;
    const double l = wavelength_nm * 1e-9;
    const double radiance = 2 * kPlanck * kLight * kLight / std::pow(l, 5) /
                            std::expm1(kPlanck * kLight / (l * kBoltzmann * kTemperature));
    return kPi * radiance * sqr(kRadius / kAstronomicalUnit) * 1e-9;
}

// μ0/(μ0 − μ) (e^{−τ/μ0} − e^{−τ/μ}): sunlight scattered toward the ground along μ.
double scattered_once(double tau, double mu0, double mu) {
    if (mu <= 0) return std::exp(-tau / mu0);
    const double d = tau / mu - tau / mu0;  // = τ (μ0 − μ)/(μ μ0)
    const double slope = std::abs(d) < 1e-8 ? 1 : -std::expm1(-d) / d;
    return std::exp(-tau / mu0) * slope * tau / mu;
}

}  // namespace

Sky make_rayleigh_sky(const RayleighSky& model, std::span<const double> wavelengths_nm, int zeniths,
                      int azimuths) {
    Sky sky;
    sky.wavelengths_nm.assign(wavelengths_nm.begin(), wavelengths_nm.end());
    for (int i = 0; i < zeniths; ++i) sky.zeniths.push_back((i + 0.5) * kPi / 2 / zeniths);
    for (int i = 0; i < azimuths; ++i) sky.azimuths.push_back((i + 0.5) * 2 * kPi / azimuths);
    sky.sun = Sun{model.sun_zenith, model.sun_azimuth, {}};
    const Vec3 sun = direction(model.sun_zenith, model.sun_azimuth);
    for (double nm : wavelengths_nm) {
        const double tau = rayleigh_optical_depth(nm), E0 = solar_irradiance(nm);
        for (double z : sky.zeniths)
            for (double a : sky.azimuths) {
                const Vec3 w = direction(z, a);
                const double cos2 = sqr(dot(w, sun)), sin2 = dot(cross(sun, w), cross(sun, w));
                const double I = E0 * 0.75 * (1 + cos2) / (4 * kPi) *
                                 scattered_once(tau, std::cos(model.sun_zenith), std::cos(z));
                const double p = model.max_dolp * sin2 / (1 + cos2);
                // Fully S1 > 0 about the E-vector, then measured in the meridian frame.
                const Vec3 e = sin2 > 0 ? normalize(cross(sun, w)) : any_perpendicular(w);
                const Beam<double> light{{I, p * I, 0, 0}, {-w, e}};
                sky.nodes.push_back(measured_in(light, meridian_frame(w)).stokes);
            }
    }
    return sky;
}

}  // namespace malus
