// exposure_file.h — what a render needs to go on, in a file beside its image: OUT.exr.sums.
//
//   Sum3_S1.440,000000nm    sum of S1 over the samples of replicate 3, W m⁻² sr⁻¹ nm⁻¹
//   Sum3_open.440,000000nm  its share of the open sky (sky_table.h), a multiple of 1/255
//   Sum3.kept               samples in those sums
//   Sum.taken  Sum.wanted  Sum.covered  Sum.distance  Sum.instance  Sum.votes
//
// Form    OpenEXR without compression: 20 bytes a pixel, wavelength and replicate, which
//         compression would make hardly smaller and take long for.
// Fields  of Exposure (exposure.h), all as floats, which hold counts up to 2²⁴ exactly.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "malus/render/exposure.h"

namespace malus {

/// "OUT.exr.sums"
std::filesystem::path sums_path(const std::filesystem::path& image);

/// 16 hexadecimal digits by which image and sums are known to belong together.
std::string fingerprint(const Exposure& exposure);

/// Appears whole or not at all; throws Error.
void write_exposure(const std::filesystem::path& path, const Exposure& exposure);

/// Throws Error when the file cannot be read, or its sums cannot be any render's.
Exposure read_exposure(const std::filesystem::path& path);

}  // namespace malus
