// scores.cpp — the quantities that are judged, and the reference of a panel.
// SPDX-License-Identifier: Apache-2.0
#include "support/scores.h"

#include "support/fixtures.h"

namespace malus {

const std::vector<Quantity>& quantities() {
    using P = PixelStokes;
    const auto root = [](std::size_t entry) {
        return [entry](const P& p) { return std::sqrt(static_cast<double>(p.covariance[entry])); };
    };
    static const std::vector<Quantity> list{
        {"S0", [](const P& p) { return p.mean.s0; }, root(0)},
        {"S1", [](const P& p) { return p.mean.s1; }, root(3)},
        {"S2", [](const P& p) { return p.mean.s2; }, root(5)},
        {"S3", [](const P& p) { return p.mean.s3; }, root(6)},
        {"DoLP", [](const P& p) { return dolp(p.mean); }, stderr_dolp, true},
        {"AoLP", [](const P& p) { return aolp(p.mean); }, stderr_aolp, true, true}};
    return list;
}

double student95(double degrees) {
    const double x = 1.959964, x3 = x * x * x, x5 = x3 * x * x, x7 = x5 * x * x, n = degrees;
    return x + (x3 + x) / (4 * n) + (5 * x5 + 16 * x3 + 3 * x) / (96 * n * n) +
           (3 * x7 + 19 * x5 + 17 * x3 - 15 * x) / (384 * n * n * n);
}

PixelStokes panel_reference(const Material& paint, double wavelength_nm, const Camera& camera) {
    const reference::Stokes S = reference::panel(reference_paint(paint, wavelength_nm), {0, 1, 0},
                                                 -camera.forward, camera.right, smooth_sky(), 1e-7)
                                    .value;
    return {{S[0], S[1], S[2], S[3]}, {}};
}

}  // namespace malus
