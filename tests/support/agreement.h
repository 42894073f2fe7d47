// agreement.h — how near a picture comes to the reference, beside how near its error bars let it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/render/film.h"
#include "support/reference.h"

namespace malus {

/// The pixels of a picture that shows the same radiance everywhere, as one pixel: their mean and
/// the covariance of that mean.
PixelStokes as_one_pixel(const Film& film, std::size_t wavelength);

struct Agreement {
    double stokes;     ///< largest deviation of S0 to S3, relative to S0
    double dolp;       ///< deviation of DoLP
    double aolp_deg;   ///< deviation of AoLP on the circle; 0 where DoLP ≤ 1 %
    double reference;  ///< the reference's own error, relative to S0
    struct Noise {     ///< one standard error of each
        double stokes, dolp, aolp_deg;
    } noise;
};
Agreement agreement(const PixelStokes& found, const reference::Integral& expected);

}  // namespace malus
