// layers.cpp — channels of an image by quantity.
// SPDX-License-Identifier: Apache-2.0
#include "preview/layers.h"

#include "malus/core/error.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/stokes.h"

namespace malus::preview {
namespace {

std::vector<float> data_or_nothing(const Image& image, const std::string& quantity, double nm) {
    try {
        return spectral_data(image, quantity, nm);
    } catch (const Error&) {
        return {};
    }
}

template <class Quantity>
std::vector<float> from_stokes(const Image& image, double nm, Quantity quantity) {
    const std::vector<float>&s0 = spectral_data(image, "S0", nm),
          &s1 = spectral_data(image, "S1", nm), &s2 = spectral_data(image, "S2", nm),
          &s3 = spectral_data(image, "S3", nm);
    std::vector<float> result(s0.size());
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = static_cast<float>(quantity(Stokes<double>{s0[i], s1[i], s2[i], s3[i]}));
    return result;
}

AolpZero aolp_zero(const Image& image) {
    const std::string* frame = image.text("stokesReferenceFrame");
    return frame && *frame == "image" ? AolpZero::kImageRight : AolpZero::kUnknown;
}

}  // namespace

Layers read_layers(const Image& image, double nm) {
    Layers layers;
    layers.width = image.width;
    layers.height = image.height;
    layers.wavelength_nm = nm;
    layers.aolp_zero = aolp_zero(image);
    layers.s0 = spectral_data(image, "S0", nm);
    layers.dolp = data_or_nothing(image, "DoLP", nm);
    if (layers.dolp.empty())
        layers.dolp = from_stokes(image, nm, [](const Stokes<double>& S) { return dolp(S); });
    layers.aolp_deg = data_or_nothing(image, "AoLP", nm);
    if (layers.aolp_deg.empty())
        layers.aolp_deg =
            from_stokes(image, nm, [](const Stokes<double>& S) { return to_degrees(aolp(S)); });
    layers.stderr_dolp = data_or_nothing(image, "StdErr_DoLP", nm);
    layers.stderr_aolp_deg = data_or_nothing(image, "StdErr_AoLP", nm);
    const auto coverage = image.channels.find("A");
    if (coverage != image.channels.end()) layers.coverage = coverage->second;
    return layers;
}

}  // namespace malus::preview
