// sky_emitter.h — the sky as the light of a scene: only as fine as the scene's surfaces can tell.
//
// A map of any resolution is averaged onto an equal-area grid: the coarsest that keeps, to kTolerance of
// S0, in S0 and in S1 to S3, the irradiance of level ground and the means under hats as wide as a third
// of the least RMS slope σ (a lobe spreads a reflection over ±2σ) and never wider than 2.2°: scenes see
// parts of the sky past edges. Where none does, finer ones are tried, to the map's own step. Where
// none of them does, or σ/3 is finer than the map, the light is read from the map itself.
// What a camera sees of the sky beside the scene is the map itself: dome().
// Directions are drawn by S0, each wavelength weighing the same.
// Frame   fixed_frame(w). Below the horizon the sky is black.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "scene/equal_area_sky.h"
#include "scene/sky_density.h"

namespace malus {

/// Where a direction lies among the nodes of a SkyEmitter.
struct LightLookup {
    SkyLookup at;
    double pdf = 0;  ///< density of SkyEmitter::sample() there, sr⁻¹
};

/// A direction drawn from the sky, and where it lies.
struct LightSample {
    Vec3 w;
    LightLookup light;
};

class SkyEmitter {
  public:
    static constexpr double kTolerance = 1e-3;

    /// `sharpest_slope`: least RMS slope σ of the surfaces that reflect by facets; infinity where
    /// none does. Throws Error when the sky lacks one of the wavelengths.
    SkyEmitter(const Sky& sky, std::span<const double> wavelengths_nm, double sharpest_slope);

    LightLookup locate(const Vec3& w) const;
    /// From two numbers in (0,1). pdf = 0 where the whole sky is black.
    LightSample sample(double u1, double u2) const;
    /// Component c of a node, as SkyDome::row().
    const float* row(std::uint32_t node, int c) const {
        return grid_ ? grid_->row(node, c) : dome_.row(node, c);
    }

    bool circular() const { return dome_.circular(); }

    const SkyDome& dome() const { return dome_; }
    /// The grid that stands for the map; null where the map itself is read.
    const EqualAreaSky* grid() const { return grid_ ? &*grid_ : nullptr; }
    const SkyDensity& density() const { return density_; }
    const SkyResampling& resampling() const { return resampling_; }

  private:
    SkyLookup lookup(const DomePoint& p) const;
    double brightness(const DomePoint& p, std::span<const double> mean_s0) const;

    SkyDome dome_;
    std::optional<EqualAreaSky> grid_;
    SkyResampling resampling_;
    SkyDensity density_;
};

}  // namespace malus
