// material.h — a paint: Priest-Germer parameters by wavelength, and which paint is where.
//
// Units   nm, rad, sr⁻¹ (priest_germer.h names the parameters).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/optics/priest_germer.h"
#include "malus/scene/scene.h"

namespace malus {

/// The parameters of a paint at one wavelength.
struct MaterialRow {
    double wavelength_nm;
    PriestGermer<double> p;
};

struct Material {
    std::string name;
    std::string place;  ///< "FILE: NAME", for messages
    std::string source;
    Slopes slopes = Slopes::kGaussian;
    Attenuation attenuation = Attenuation::kNone;
    std::vector<MaterialRow> rows;  ///< ascending in wavelength, at least one

    bool covers(double wavelength_nm) const;
};

/// Parameters at one wavelength, linear between rows (τ and Ω in radians). Throws Error outside
/// the rows, and between a row with and one without shadowing, where there is no line to follow.
PriestGermer<double> parameters_at(const Material& material, double wavelength_nm);

/// "Give everything of this name that material": a glTF node (with all below it), mesh or
/// material; "*" is what no other rule names.
struct PaintRule {
    std::string name, material;
};

/// For each instance of the scene the index of its material. A node's rule wins over a mesh's, a
/// mesh's over a glTF material's, any over "*"; without one, a paint with the glTF material's own
/// name. Throws Error for a rule that names nothing and for an instance left without paint.
std::vector<int> assign_paints(const Scene& scene, const std::vector<PaintRule>& rules,
                               const std::vector<Material>& materials);

}  // namespace malus
