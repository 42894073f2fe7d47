// shared_errors.cpp — covariances of one sample, among neighbours.
// SPDX-License-Identifier: Apache-2.0
#include "render/shared_errors.h"

#include <array>

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

}  // namespace malus
