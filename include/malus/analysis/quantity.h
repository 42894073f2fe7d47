// quantity.h — what an image says of one quantity at one wavelength: a number a pixel, and its error.
//
//   S1/S0, S2/S0, S3/S0: q = Si/S0,  var q = (Cii − 2q C0i + q² C00)/S0²   (first order)
//
// Units   W m⁻² sr⁻¹ nm⁻¹ (S0 to S3), degrees [0,180) (AoLP), 1 (DoLP and ratios). Errors are
//         standard errors of the same unit; of AoLP 90° where nothing is known.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "malus/io/exr.h"
#include "malus/io/film_image.h"

namespace malus {

/// Rows from the top, as the image's channels.
struct Quantity {
    std::string name;
    double wavelength_nm = 0;
    std::vector<float> value;
    std::vector<float> error;  ///< empty if the image does not know
    double period = 0;         ///< 180 for angles, which are alike on both sides of it; else 0
};

/// "S0" … "S3", "DoLP", "AoLP" (computed from S0 to S3 where the image has no such channel), "S1/S0",
/// "S2/S0", "S3/S0" (0 where S0 is 0), or the name before the dot of any other channel of a wavelength,
/// such as "StdErr_DoLP". Of "S3/S0" no error is known. Throws Error (without a file name) if there
/// is no such channel.
Quantity read_quantity(const Image& image, const std::string& name, double wavelength_nm);

/// a − b; of angles the shorter way round, in [−period/2, period/2).
double difference(double a, double b, double period);

/// Those of the image's wavelengths that are asked for, all for none asked. Throws Error (without a
/// file name) for one that the image does not have, or if it has none.
std::vector<double> wavelengths_of(const Image& image, const std::vector<double>& asked_nm);
std::vector<double> wavelengths_of(const std::vector<double>& available_nm,
                                   const std::vector<double>& asked_nm);

/// Takes from DoLP what noise adds to it on average (debiased_dolp()), whatever estimator the image
/// has, by the covariances of `film`, that of the same image.
void debias(Quantity& dolp, const Film& film);

}  // namespace malus
