// exposure_image.h — an exposure in the channels of an EXR, beside the image developed from it.
//
//   Sum3_S1.440,000000nm    sum of S1 over the samples of replicate 3, W m⁻² sr⁻¹ nm⁻¹
//   Sum3.kept               samples in those sums
//   Sum.taken  Sum.wanted  Sum.covered  Sum.distance  Sum.instance  Sum.votes
//
// Fields  of Exposure (exposure.h), all as floats; counts beyond 2²⁴ are checkpoints or lose their
//         last bits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/io/exr.h"
#include "malus/render/exposure.h"

namespace malus {

/// Is this the name of a channel above, or one of the picture?
bool is_exposure_channel(const std::string& name);
bool is_picture_channel(const std::string& name);

/// Adds the channels; `exposure` must outlive the image.
void add_exposure(Image& image, const Exposure& exposure);

/// Throws Error when the file cannot be read or has no exposure, or one that cannot be.
Exposure read_exposure(const std::filesystem::path& path);

}  // namespace malus
