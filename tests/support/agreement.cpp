// agreement.cpp — deviations from the reference and their standard errors.
// SPDX-License-Identifier: Apache-2.0
#include "support/agreement.h"

namespace malus {

PixelStokes as_one_pixel(const Film& film, std::size_t wavelength) {
    const double share = 1 / static_cast<double>(film.pixel_count());
    PixelStokes one;
    std::array<double, 7> covariance{};
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        const PixelStokes& pixel = film.at(i, wavelength);
        one.mean = one.mean + share * pixel.mean;
        for (std::size_t e = 0; e < covariance.size(); ++e)
            covariance[e] += share * share * static_cast<double>(pixel.covariance[e]);
    }
    for (std::size_t e = 0; e < covariance.size(); ++e)
        one.covariance[e] = static_cast<float>(covariance[e]);
    return one;
}

Agreement agreement(const PixelStokes& found, const reference::Integral& expected) {
    constexpr std::array<std::size_t, 4> kDiagonal{0, 3, 5, 6};
    const reference::Stokes& E = expected.value;
    const std::array<double, 4> S{found.mean.s0, found.mean.s1, found.mean.s2, found.mean.s3};
    Agreement a{};
    for (std::size_t c = 0; c < 4; ++c) {
        const double error = std::sqrt(static_cast<double>(found.covariance[kDiagonal[c]]));
        a.stokes = std::max(a.stokes, std::abs(S[c] - E[c]) / E[0]);
        a.noise.stokes = std::max(a.noise.stokes, error / E[0]);
        a.reference = std::max(a.reference, expected.error[c] / E[0]);
    }
    const Stokes<double> right{E[0], E[1], E[2], E[3]};
    a.dolp = std::abs(dolp(found.mean) - dolp(right));
    a.noise.dolp = stderr_dolp(found);
    if (dolp(right) > 0.01) {
        a.aolp_deg = std::abs(to_degrees(std::remainder(aolp(found.mean) - aolp(right), kPi)));
        a.noise.aolp_deg = to_degrees(stderr_aolp(found));
    }
    return a;
}

}  // namespace malus
