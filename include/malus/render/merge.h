// merge.h — pictures of the same scene with other random numbers, as one picture.
//
//   w_i = N_i / ΣN     S = Σ w_i S_i     C = Σ w_i² C_i     1/R = Σ w_i²/R_i        in each pixel
//   A = Σ w_i A_i      Z = Σ w_i A_i Z_i / A
//
// Weights  go by samples N, not by estimated errors: a picture that missed rare light is dark and
//          looks sure of itself, and would pull such a mean down. Where renders chose N by what
//          they saw, the mean by N still nears the right one as pictures are added, since
//          E ΣN S = E ΣN times it (Wald's identity); the plain mean of the S_i does not.
// Groups  Σ N S, Σ N² C and Σ N²/R are sums: merged pictures can be merged, in any order.
// Degrees of freedom of the error bars: Σ (R_i − 1) where all N_i are the same, fewer where they
//         differ (Welch and Satterthwaite).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/render/film.h"

namespace malus {

/// Adds `other` to the picture in `film`. A pixel without samples takes no part; ids stay, unless
/// `other` has more samples there. Throws Error when size or wavelengths differ, or a pixel's
/// samples are too many to count.
void merge_into(Film& film, const Film& other);

}  // namespace malus
