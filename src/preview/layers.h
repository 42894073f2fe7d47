// layers.h — what an image or a picture of the sky says at one wavelength, pixel by pixel.
//
//   of a square of pixels:   S = mean of S_i,   e(S0) = √Σe_i²/n,
//   e(DoLP) = √Σ(S0_i e_i)²/ΣS0_i,   e(AoLP) = √Σ(P_i e_i)²/|Σ(S1_i, S2_i)|,   P = S0 DoLP
//
// Given   errors of pixels that are independent; the mean of n equal ones has 1/√n of theirs.
// Units   S0 W m⁻² sr⁻¹ nm⁻¹; AoLP degrees [0,180); errors are standard errors of the same unit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/io/exr.h"

namespace malus::preview {

/// What AoLP = 0° means: image right, the vertical plane (of a dome), or what the file knows.
enum class AolpZero { kImageRight, kMeridian, kUnknown };

struct Layers {
    int width = 0, height = 0;
    double wavelength_nm = 0;
    AolpZero aolp_zero = AolpZero::kUnknown;
    std::vector<float> s0, dolp, aolp_deg;
    std::vector<float> s1_s0, s2_s0;                             ///< S1/S0, S2/S0; 0 where S0 is 0
    std::vector<float> stderr_s0, stderr_dolp, stderr_aolp_deg;  ///< empty if the image has none
    std::vector<float> coverage;       ///< [0,1]; empty if all pixels count alike
    std::string covered = "surfaces";  ///< what coverage counts, in words

    bool has_errors() const {
        return !stderr_s0.empty() && !stderr_dolp.empty() && !stderr_aolp_deg.empty();
    }
};

/// DoLP and AoLP are the image's own, or computed from its Stokes vectors. Throws Error (without a
/// file name) when a channel is missing.
Layers read_layers(const Image& image, double wavelength_nm);

/// Each square of `times` × `times` pixels as one; squares at the right and lower edges are smaller. DoLP
/// and AoLP are those of the mean Stokes vector, coverage is the mean.
Layers reduced(const Layers& layers, int times);

}  // namespace malus::preview
