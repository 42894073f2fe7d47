// shared_errors.cpp — covariances of one sample, among neighbours.
// SPDX-License-Identifier: Apache-2.0
#include "render/shared_errors.h"

#include <algorithm>
#include <array>
#include <vector>

namespace malus {
namespace {

using Covariance = std::array<double, 7>;

Covariance of_one_sample(const SharedError& of) {
    Covariance v{};
    for (std::size_t e = 0; e < v.size(); ++e)
        v[e] = of.samples * static_cast<double>(of.pixel->covariance[e]);
    return v;
}

// Of S0 to S2.
double trace(const Covariance& v) {
    return v[0] + v[3] + v[5];
}

}  // namespace

void share_errors(std::span<const SharedError> pixels) {
    // Sums over neighbours, in light and in parts of each pixel's own.
    Covariance sum{}, relative{};
    double lit = 0;
    for (const SharedError& of : pixels) {
        const Covariance v = of_one_sample(of);
        const double S0 = of.pixel->mean.s0;
        for (std::size_t e = 0; e < v.size(); ++e) {
            sum[e] += v[e];
            if (S0 > 0) relative[e] += v[e] / S0 / S0;
        }
        if (S0 > 0) ++lit;
    }
    const double share = 1 / static_cast<double>(pixels.size());
    for (const SharedError& of : pixels) {
        const Covariance v = of_one_sample(of);
        const double own = lit > 0 ? sqr(of.pixel->mean.s0) / lit : 0;
        const bool dark = own * trace(relative) < share * trace(sum);
        const Covariance& neighbours = dark ? relative : sum;
        const double unit = dark ? own : share;
        if (!(unit * trace(neighbours) > trace(v))) continue;
        for (std::size_t e = 0; e < v.size(); ++e)
            of.pixel->covariance[e] =
                static_cast<float>((v[e] + unit * neighbours[e]) / (2 * of.samples));
    }
}

void share_errors(Film& film, std::size_t wavelength, std::span<std::size_t> pixels) {
    std::vector<SharedError> shared;
    while (!pixels.empty()) {
        const std::int32_t instance = film.instance[pixels.front()];
        const auto rest = std::partition(pixels.begin(), pixels.end(), [&](std::size_t pixel) {
            return film.instance[pixel] == instance;
        });
        const auto same = static_cast<std::size_t>(rest - pixels.begin());
        shared.clear();
        for (std::size_t pixel : pixels.first(same))
            shared.push_back({&film.stokes[pixel * film.wavelengths_nm.size() + wavelength],
                              static_cast<double>(film.samples[pixel])});
        share_errors(shared);
        pixels = pixels.subspan(same);
    }
}

}  // namespace malus
