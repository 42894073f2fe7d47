// scores.h — deviations of pictures in units of their error bars.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "malus/render/film.h"
#include "malus/scene/camera.h"
#include "malus/scene/material.h"

namespace malus {

/// A number of a pixel and its standard error.
struct Quantity {
    const char* name;
    std::function<double(const PixelStokes&)> value, error;
    bool polarization = false;  ///< DoLP or AoLP: nothing to judge where light is unpolarized
    bool angle = false;         ///< rad, π is 0

    double off(const PixelStokes& found, const PixelStokes& right) const {
        const double difference = value(found) - value(right);
        return angle ? std::remainder(difference, kPi) : difference;
    }
};

/// S0, S1, S2, S3, DoLP and AoLP.
const std::vector<Quantity>& quantities();

/// z-scores of one quantity.
struct Scores {
    double count = 0, sum = 0, squares = 0, covered = 0;

    /// `within`: what 95 % of such scores stay within.
    void add(double z, double within) {
        count += 1, sum += z, squares += z * z, covered += std::abs(z) < within ? 1 : 0;
    }
    double mean() const { return sum / count; }
    double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
    double coverage() const { return covered / count; }
};

/// What 95 % of Student's t stay within: 97.5 % quantile by Cornish and Fisher's expansion (Abramowitz
/// & Stegun 26.7.5), to 1e-3 from 7 degrees of freedom on.
double student95(double degrees);

/// What each pixel of panel_scene() shows under smooth_sky(), by quadrature.
PixelStokes panel_reference(const Material& paint, double wavelength_nm, const Camera& camera);

}  // namespace malus
