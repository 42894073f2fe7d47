// shared_errors.h — errors of pixels that know little of their own.
//
//   v_i = N_i C_i,  V = mean of v_i,  C_i ← (v_i + V)/(2 N_i) where tr V > tr v_i
//
// Where the light T of the open sky is known, samples differ by hidden sky alone. What a few of them miss in
// one pixel they meet in the next: that all are alike says little of their error. So a pixel's covariance of
// one sample, v, which has 7 degrees of freedom at best, is raised toward that of its neighbours.
// Source  shrinkage of variances toward their mean, as in Smyth, Stat. Appl. Genet. Mol. Biol. 3 (2004),
//         but never down: neighbours may be more certain than a pixel at a shadow's edge.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "malus/render/film.h"

namespace malus {

/// One wavelength of a pixel, and its samples N.
struct SharedError {
    PixelStokes* pixel;
    double samples;
};

/// Of neighbours that show one surface.
void share_errors(std::span<const SharedError> pixels);

/// Of neighbours that have samples: those that show the same instance, at each wavelength. Reorders the list.
void share_errors(Film& film, std::span<std::size_t> pixels);

}  // namespace malus
