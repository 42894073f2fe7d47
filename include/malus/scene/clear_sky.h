// clear_sky.h — the sky that sunlight makes in clear or hazy air over even ground.
//
//   air       optical depth: Bodhaine et al., J. Atmos. Oceanic Technol. 16, 1854 (1999), eq. 30;
//             depolarization: King factors of Bates (1984), as there in eq. 5, 6 and 23
//   aerosol   τ(λ) = τ_550 (λ/550 nm)^−α (Ångström)
//   light     the vector equation of transfer, all orders of scattering (scene/radiative_transfer.h)
//
// Units   W m⁻² sr⁻¹ nm⁻¹, nm, hPa; angles in rad.
// Range   a flat atmosphere: sun and view within about 82° of the zenith; 280 to 4000 nm.
//         No gases that absorb (ozone: up to 4 % at 600 nm), no clouds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>

#include "malus/scene/scattering.h"
#include "malus/scene/sky.h"

namespace malus {

/// Scattering matrices of a file by wavelength, nm; one for all under 0.
using ScatteringTable = std::map<double, std::vector<ScatteringRow>>;

enum class AerosolPlace { kMixed, kBelow };  ///< evenly through the air, or in a layer below it

struct Aerosol {
    double optical_depth_550 = 0;
    double angstrom_exponent = 1.3;
    double single_scattering_albedo = 0.96;
    double asymmetry = 0.70, polarization = 0.45;  ///< of henyey_greenstein_matrix(); |g| ≤ 0.9
    ScatteringTable table;                         ///< stands in for it if not empty
    AerosolPlace place = AerosolPlace::kMixed;
};

struct ClearSky {
    double sun_zenith = to_radians(60), sun_azimuth = to_radians(180);  ///< zenith < π/2
    double ground_albedo = 0.2;                                         ///< Lambertian, [0, 1]
    double pressure_hpa = 1013.25;                                      ///< at the ground
    /// Instead of the air's own, at all wavelengths: to compare with tables of other codes.
    std::optional<double> optical_depth, depolarization;
    std::optional<double> solar_irradiance;  ///< above the air, instead of the table's
    Aerosol aerosol;
    /// Scales the polarization so that the largest DoLP of the map is this, [0, 1]; as air has it
    /// without.
    std::optional<double> max_dolp;
};

/// Sampled at zenith × azimuth pixel centres, with the sun's disc as it looks from the ground. Throws
/// Error for a wavelength beyond the table of the sun, or of the aerosol's matrix.
/// progress: called now and then with the share that is done.
Sky make_clear_sky(const ClearSky& model, std::span<const double> wavelengths_nm, int zeniths,
                   int azimuths, const std::function<void(double)>& progress = {});

/// Of clean dry air (360 ppm CO2).
double rayleigh_optical_depth(double wavelength_nm, double pressure_hpa = 1013.25);
/// Of natural light scattered by 90°.
double rayleigh_depolarization(double wavelength_nm);
/// On a plane that faces the sun, above the air, 1 au away, W m⁻² nm⁻¹: skies/solar_irradiance.csv,
/// linear between its rows. Throws Error outside of them.
double solar_irradiance(double wavelength_nm);

}  // namespace malus
