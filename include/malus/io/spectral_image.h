// spectral_image.h — Stokes images by wavelength in the channels of an EXR.
//
//   S0.440,000000nm … S3.…    DoLP.…  AoLP.…  StdErr_S0.… StdErr_S1.… StdErr_S2.… StdErr_S3.…
//   Cov_S0S1.… Cov_S0S2.… Cov_S1S2.…    StdErr_DoLP.…  StdErr_AoLP.…
//   A  Z  material.id  node.id  N.samples  N.replicates    R G B
//
// Units   W m⁻² sr⁻¹ nm⁻¹, Cov its square; DoLP [0,1]; AoLP degrees [0,180); Z metres; ids 0 = sky,
//         else the place in the header's lists materialNames and nodeNames.
// Frame   attribute stokesReferenceFrame: "image" (camera.h) or "meridian" (sky.h).
// Source  layout: Fichet, Pacanowski, Wilkie, JCGT 10(3) (2021).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "malus/io/exr.h"
#include "malus/render/film.h"

namespace malus {

/// "S0.440,000000nm": six decimals and a decimal comma, whatever the locale.
std::string spectral_channel(const std::string& quantity, double wavelength_nm);

/// What a spectral channel name says; nothing if it is not one.
struct SpectralName {
    std::string quantity;
    double wavelength_nm;
};
std::optional<SpectralName> parse_spectral_channel(const std::string& name);

/// Wavelengths for which all of S0..S3 are there, ascending by value, nm. Throws Error (without a
/// file name) for a wavelength that has only some of them.
std::vector<double> stokes_wavelengths(const Image& image);

/// The channel of this quantity and wavelength, found by the wavelength's value. Throws Error
/// (without a file name) if there is none.
const std::vector<float>& spectral_data(const Image& image, const std::string& quantity,
                                        double wavelength_nm);

/// Header entries that say units and signs; `frame` as in the comment above.
void declare_stokes(Image& image, const std::string& frame);

/// Names for the ids of a film's instances.
struct Labels {
    std::vector<std::string> materials, nodes;
    std::vector<int> material_of_instance, node_of_instance;  ///< indices into the names
};

/// What stands in the DoLP channels: P/S0, or debiased_dolp() (film.h).
enum class DolpEstimator { kRaw, kDebiased };

/// A film as an image, for writing: all channels are computed from film and labels, which must outlive
/// it. The header's dolpEstimator says "raw" or "MAS".
Image described(const Film& film, const Labels& labels,
                DolpEstimator estimator = DolpEstimator::kRaw);
/// The same with channels in memory, for reading.
Image to_image(const Film& film, const Labels& labels,
               DolpEstimator estimator = DolpEstimator::kRaw);

}  // namespace malus
