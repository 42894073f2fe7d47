// layers.cpp — channels of an image by quantity, and means over squares of pixels.
// SPDX-License-Identifier: Apache-2.0
#include "preview/layers.h"

#include <algorithm>
#include <cmath>

#include "malus/analysis/quantity.h"
#include "malus/core/contract.h"
#include "malus/optics/stokes.h"

namespace malus::preview {
namespace {

AolpZero aolp_zero(const Image& image) {
    const std::string* frame = image.text("stokesReferenceFrame");
    return frame && *frame == "image" ? AolpZero::kImageRight : AolpZero::kUnknown;
}

// Sums over the pixels of one square.
struct Square {
    double n = 0, covered = 0;
    Stokes<double> sum{};
    double errors_s0 = 0, errors_dolp = 0, errors_aolp = 0;  // of squares

    void add(const Layers& from, std::size_t i) {
        const double s0 = from.s0[i], polarized = s0 * from.dolp[i];
        n += 1;
        sum.s0 += s0;
        sum.s1 += s0 * from.s1_s0[i];
        sum.s2 += s0 * from.s2_s0[i];
        if (!from.coverage.empty()) covered += from.coverage[i];
        if (!from.stderr_s0.empty()) errors_s0 += sqr(double{from.stderr_s0[i]});
        if (!from.stderr_dolp.empty()) errors_dolp += sqr(s0 * from.stderr_dolp[i]);
        if (!from.stderr_aolp_deg.empty()) errors_aolp += sqr(polarized * from.stderr_aolp_deg[i]);
    }
};

// `of` limited to `most`, which says that nothing is known; so does 0/0.
float error_of(double numerator, double denominator, double most) {
    return denominator > 0 ? static_cast<float>(std::min(most, numerator / denominator))
                           : static_cast<float>(numerator > 0 ? most : 0);
}

void append(Layers& to, const Layers& from, const Square& square) {
    const Stokes<double>& S = square.sum;
    const auto push = [](std::vector<float>& values, double x) {
        values.push_back(static_cast<float>(x));
    };
    push(to.s0, S.s0 / square.n);
    push(to.s1_s0, S.s0 > 0 ? S.s1 / S.s0 : 0);
    push(to.s2_s0, S.s0 > 0 ? S.s2 / S.s0 : 0);
    push(to.dolp, dolp(S));
    push(to.aolp_deg, to_degrees(aolp(S)));
    if (!from.coverage.empty()) push(to.coverage, square.covered / square.n);
    if (!from.stderr_s0.empty()) push(to.stderr_s0, std::sqrt(square.errors_s0) / square.n);
    if (!from.stderr_dolp.empty())
        to.stderr_dolp.push_back(error_of(std::sqrt(square.errors_dolp), S.s0, 1));
    if (!from.stderr_aolp_deg.empty())
        to.stderr_aolp_deg.push_back(
            error_of(std::sqrt(square.errors_aolp), std::hypot(S.s1, S.s2), 90));
}

}  // namespace

Layers read_layers(const Image& image, double nm) {
    Layers layers;
    layers.width = image.width;
    layers.height = image.height;
    layers.wavelength_nm = nm;
    layers.aolp_zero = aolp_zero(image);
    const auto take = [&](const char* name, std::vector<float>& value, std::vector<float>* error) {
        Quantity q = read_quantity(image, name, nm);
        value = std::move(q.value);
        if (error) *error = std::move(q.error);
    };
    take("S0", layers.s0, &layers.stderr_s0);
    take("DoLP", layers.dolp, &layers.stderr_dolp);
    take("AoLP", layers.aolp_deg, &layers.stderr_aolp_deg);
    take("S1/S0", layers.s1_s0, nullptr);
    take("S2/S0", layers.s2_s0, nullptr);
    const auto coverage = image.channels.find("A");
    if (coverage != image.channels.end()) layers.coverage = coverage->second;
    return layers;
}

Layers reduced(const Layers& from, int times) {
    EXPECT(times > 0);
    Layers to;
    to.width = (from.width + times - 1) / times;
    to.height = (from.height + times - 1) / times;
    to.wavelength_nm = from.wavelength_nm;
    to.aolp_zero = from.aolp_zero;
    to.covered = from.covered;
    for (int y = 0; y < from.height; y += times)
        for (int x = 0; x < from.width; x += times) {
            Square square;
            for (int v = y; v < std::min(from.height, y + times); ++v)
                for (int u = x; u < std::min(from.width, x + times); ++u)
                    square.add(from,
                               static_cast<std::size_t>(v) * static_cast<std::size_t>(from.width) +
                                   static_cast<std::size_t>(u));
            append(to, from, square);
        }
    return to;
}

}  // namespace malus::preview
