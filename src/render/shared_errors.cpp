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
    Covariance mean{};
    for (const SharedError& of : pixels) {
        const Covariance v = of_one_sample(of);
        for (std::size_t e = 0; e < v.size(); ++e)
            mean[e] += v[e] / static_cast<double>(pixels.size());
    }
    for (const SharedError& of : pixels) {
        const Covariance v = of_one_sample(of);
        if (!(trace(mean) > trace(v))) continue;
        for (std::size_t e = 0; e < v.size(); ++e)
            of.pixel->covariance[e] = static_cast<float>((v[e] + mean[e]) / (2 * of.samples));
    }
}

void share_errors(Film& film, std::span<std::size_t> pixels) {
    const std::size_t wavelengths = film.wavelengths_nm.size();
    std::vector<SharedError> shared;
    while (!pixels.empty()) {
        const std::int32_t instance = film.instance[pixels.front()];
        const auto rest = std::partition(pixels.begin(), pixels.end(), [&](std::size_t pixel) {
            return film.instance[pixel] == instance;
        });
        const auto same = static_cast<std::size_t>(rest - pixels.begin());
        for (std::size_t w = 0; w < wavelengths; ++w) {
            shared.clear();
            for (std::size_t pixel : pixels.first(same))
                shared.push_back({&film.stokes[pixel * wavelengths + w],
                                  static_cast<double>(film.samples[pixel])});
            share_errors(shared);
        }
        pixels = pixels.subspan(same);
    }
}

}  // namespace malus
