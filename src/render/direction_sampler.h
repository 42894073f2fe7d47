// direction_sampler.h — draws directions of light for a surface, for all wavelengths at once.
//
//   pdf(wi) = q_vol cosθi/π + Σ_j q_j p_j(wi)                                              [sr⁻¹]
//   Gaussian slopes: facets as the sensor sees them (visible normals of the Beckmann distribution
//     D of roughness α = √2 σ):  p_j = D(h) / (4 A(wo)),  A = ∫ max(0, wo·h) D(h) dω_h
//   Cauchy slopes:  p_j = P(h) / (4 (wo·h) ∫P dΩ)
//
// One mixture serves all wavelengths: roughnesses within a fifth of each other share a lobe, and q
// follows, root mean square over the wavelengths, the fraction of its light that each part reflects
// at this view. f/pdf of every wavelength is then bounded wherever its own lobe's would be.
// Frame   directions are local: z is the shading normal.
// Source  Walter et al., Microfacet Models for Refraction (EGSR 2007); Heitz & d'Eon, Importance
//         Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals (EGSR 2014).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "malus/optics/priest_germer.h"
#include "render/gaussian.h"
#include "render/lanes.h"

namespace malus {

/// The lobes of a paint; built once a render, shared by threads.
class DirectionSampler {
    static constexpr std::size_t kMostLobes = 8;
    // Of volume and lobes in the mixture; their sum is 1.
    struct Shares {
        double volume = 0;
        std::array<double, kMostLobes> lobe{};
    };

  public:
    /// `rows`: the paint's parameters at each wavelength of the render.
    DirectionSampler(std::span<const PriestGermer<double>> rows, Slopes slopes);

    /// Does the paint reflect anything at any wavelength?
    bool black() const { return black_; }

    /// The mixture as seen from one direction (R = double) or several side by side (R = Reals).
    template <class R>
    class View {
      public:
        /// wo: local, wo.z > 0.
        View(const DirectionSampler& sampler, const Vector3<R>& wo);
        /// A direction wi from three numbers in (0,1); may lie below the surface (wi.z ≤ 0),
        /// where f = 0 and the sample counts as nothing.
        Vector3<R> sample(const R& u_lobe, const R& u1, const R& u2) const;
        /// Density of sample() at wi, sr⁻¹.
        R pdf(const Vector3<R>& wi) const;

      private:
        const DirectionSampler& sampler_;
        Vector3<R> wo_;
        R volume_share_;
        std::array<R, kMostLobes> lobe_share_;
        // Of each Gaussian lobe: e^{−x²}/√π and erfc(x) at minus the steepest slope seen, and A(wo).
        std::array<GaussTail<R>, kMostLobes> at_last_;
        std::array<R, kMostLobes> visible_area_;
    };

  private:
    static constexpr std::size_t kViews = 33;  // nodes of shares_ over cosθo

    Shares shares_for(std::span<const PriestGermer<double>> rows, double cos_o) const;
    std::size_t lobe_of(double sigma) const;

    Slopes slopes_;
    bool black_ = true;
    std::vector<double> sigmas_;           // of the lobes, from the roughest down
    std::array<Shares, kViews> shares_{};  // of the mixture, by cosθo
};

}  // namespace malus
