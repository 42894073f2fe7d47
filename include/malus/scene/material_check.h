// material_check.h — is a paint physical? What its rows reflect in all, and where they break rules.
//
//   R(θi) = ∫ f00 cosθo dωo    directional-hemispherical reflectance for unpolarized light
//         = ∫ P SO [G] ½(Rs+Rp) cosβ/cosθi dω_h  +  2π ∫ f_vol cosθo d(cosθo)
//
// Units   degrees, sr⁻¹; R is a fraction and may exceed 1: the model diverges at grazing.
// Error   of R: the change on doubling the midpoint rules, which bounds what is left.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/scene/material.h"

namespace malus {

struct Reflectance {
    double zenith_deg;  ///< of the light; by reciprocity also of the sensor under an even sky
    double value, error;
};

/// What was found of one row.
struct RowCheck {
    double wavelength_nm;
    std::vector<Reflectance> reflectance;  ///< at 0, 15, 30, 45, 60, 75, 80, 85 and 89 degrees
    double least_f00;                      ///< of the row as printed, without the clamp, sr⁻¹
    double share_negative;     ///< of directions (uniform in solid angle) in which it is negative
    double most_dop;           ///< of what leaves, for light of DoP ≤ 1 coming in
    double reciprocity_error;  ///< largest |M(wo→wi) − D Mᵀ D| / m00
};
RowCheck check_row(const Material& material, const MaterialRow& row);

/// R at one angle of incidence.
Reflectance reflectance(const Material& material, const MaterialRow& row, double zenith_deg);

/// The findings in words, a line each: what they mean and what can be done.
std::vector<std::string> verdicts(const Material& material, const RowCheck& check);

}  // namespace malus
