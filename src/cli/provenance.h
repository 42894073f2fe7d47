// provenance.h — header entries by which renders are known to belong together.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/io/exr.h"

namespace malus::cli {

struct Inputs;

/// Adds sceneHash, paintsHash, skyHash and viewHash (fingerprint.h).
void add_fingerprints(Image& image, const Inputs& inputs);

/// The seeds of a render, or of all renders that were merged to it. Throws Error (without a file
/// name) when the header lacks them, or anything by which renders are compared.
std::vector<std::string> seeds_of(const Image& header);

/// In what two images cannot be of one render, for a message: "another sky (header skyHash)". Empty
/// when size, wavelengths, scene, paints, sky, view, depth and version agree.
std::string first_difference(const Image& a, const Image& b);

}  // namespace malus::cli
