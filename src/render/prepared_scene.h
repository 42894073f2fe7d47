// prepared_scene.h — what the path loop reads, laid out for it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "malus/render/render.h"
#include "malus/scene/sun_disc.h"
#include "render/accel.h"
#include "render/direction_sampler.h"
#include "render/lanes.h"
#include "scene/sky_emitter.h"

namespace malus {

/// A paint at the wavelengths of a render: parameters in rows for vector registers.
class Surface {
  public:
    Surface(const Material& material, std::span<const double> wavelengths_nm);

    Slopes slopes() const { return slopes_; }
    Attenuation attenuation() const { return attenuation_; }
    const DirectionSampler& directions() const { return directions_; }
    /// Least RMS slope of the wavelengths that reflect by facets; infinity where none does.
    double sharpest_slope() const { return sharpest_slope_; }
    /// Is its sharpest lobe narrower than what the sky's light differs over?
    bool sharp() const { return sharpest_slope_ < 0.25; }
    /// Parameters at wavelengths 2 pair and 2 pair + 1.
    const PreparedPriestGermer<Lanes>& lanes(std::size_t pair) const { return rows_[pair]; }

  private:
    Slopes slopes_;
    Attenuation attenuation_;
    DirectionSampler directions_;
    double sharpest_slope_;
    std::vector<PreparedPriestGermer<Lanes>> rows_;
};

struct PreparedScene::Impl {
    Scene scene;
    std::vector<int> paints;  // per instance, index into surfaces
    std::vector<double> wavelengths_nm;
    std::vector<Surface> surfaces;
    SkyEmitter sky;
    SunDisc sun;
    Accel accel;  // refers to scene

    Impl(Scene s, std::vector<int> p, const std::vector<Material>& materials, const Sky& map,
         std::vector<double> nm);

    const Surface& surface_of(int instance) const {
        return surfaces[static_cast<std::size_t>(paints[static_cast<std::size_t>(instance)])];
    }
};

}  // namespace malus
