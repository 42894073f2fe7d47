// film_image.h — the channels of a rendered image, back to the film that they were written from.
//
// The inverse of to_image (spectral_image.h) to the precision of floats. What is derived (DoLP,
// AoLP, their errors, R G B) is not read. An instance of such a film is a pair of material and node.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/io/spectral_image.h"

namespace malus {

/// Instances are numbered as in `labels`, to which names and instances that are new are added.
/// Throws Error (without a file name) when something is missing, or holds what no render writes:
/// numbers that are not finite, negative errors, ids without a name.
Film film_of(const Image& image, Labels& labels);

}  // namespace malus
