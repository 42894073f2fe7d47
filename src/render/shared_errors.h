// shared_errors.h — errors of pixels that know little of their own.
//
//   v_i = N_i C_i,  V_i = mean of v_j or S0_i² mean of v_j/S0_j², whichever has the smaller trace
//   C_i ← (v_i + V_i)/(2 N_i) where tr V_i > tr v_i
//
// Where the light T of the open sky is known, samples differ by hidden sky alone. What a few of them miss in
// one pixel they meet in the next: that all are alike says little of their error. So a pixel's covariance of
// one sample, v, which has 7 degrees of freedom at best, is raised toward that of its neighbours. Where a
// paint's narrow lobe ends, pixels are a million times darker than the next: what hides the sky there
// takes no more than the part of their own light that it takes of their neighbours'.
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

/// Of neighbours that have samples and use the table at this wavelength: those that show the same instance.
/// Reorders the list.
void share_errors(Film& film, std::size_t wavelength, std::span<std::size_t> pixels);

}  // namespace malus
