// spectral_image.cpp — films to channels, and the names of channels.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/spectral_image.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>

#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

// In the order of FilmQuantity.
constexpr std::array<const char*, kFilmQuantities> kQuantities{
    "S0",       "S1",        "S2",        "S3",          "DoLP",
    "AoLP",     "StdErr_S0", "StdErr_S1", "StdErr_S2",   "StdErr_S3",
    "Cov_S0S1", "Cov_S0S2",  "Cov_S1S2",  "StdErr_DoLP", "StdErr_AoLP"};

// of(pixel index) for each pixel.
template <class Of>
void add(Image& image, const std::string& name, Of of) {
    const auto numbers_of = [of](std::size_t from, std::size_t to, float* const* numbers) {
        for (std::size_t i = from; i < to; ++i) numbers[0][i - from] = static_cast<float>(of(i));
    };
    image.computed.push_back({{name}, numbers_of});
}

// All quantities of a wavelength.
void add_quantities(Image& image, const Film& film, std::size_t w, DolpEstimator estimator) {
    std::vector<std::string> names;
    for (const char* name : kQuantities)
        names.push_back(spectral_channel(name, film.wavelengths_nm[w]));
    const auto numbers_of = [&film, w, estimator](std::size_t from, std::size_t to,
                                                  float* const* numbers) {
        derive(film, w, from, to, numbers);
        if (estimator == DolpEstimator::kDebiased)
            for (std::size_t i = from; i < to; ++i)
                numbers[kDolp][i - from] = static_cast<float>(debiased_dolp(film.at(i, w)));
    };
    image.computed.push_back({names, numbers_of});
}

// Ids count from 1 in the header's list of names; 0 is the sky.
void add_ids(Image& image, const std::string& channel, const std::string& attribute,
             const Film& film, const std::vector<int>& of_instance,
             const std::vector<std::string>& names) {
    add(image, channel, [&film, &of_instance](std::size_t i) {
        const std::int32_t instance = film.instance[i];
        return instance < 0 ? 0 : of_instance[static_cast<std::size_t>(instance)] + 1;
    });
    std::vector<std::string> listed{"(sky)"};
    listed.insert(listed.end(), names.begin(), names.end());
    image.attributes[attribute] = listed;
}

}  // namespace

std::string spectral_channel(const std::string& quantity, double wavelength_nm) {
    std::array<char, 48> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), wavelength_nm,
                                   std::chars_format::fixed, 6)
                         .ptr;
    std::string number(text.data(), end);
    std::replace(number.begin(), number.end(), '.', ',');
    return quantity + "." + number + "nm";
}

std::optional<SpectralName> parse_spectral_channel(const std::string& name) {
    const std::size_t dot = name.find('.');
    if (dot == std::string::npos || !name.ends_with("nm")) return std::nullopt;
    std::string number = name.substr(dot + 1, name.size() - dot - 3);
    std::replace(number.begin(), number.end(), ',', '.');
    double nm = 0;
    const char* last = number.data() + number.size();
    const auto read = std::from_chars(number.data(), last, nm);
    if (read.ec != std::errc() || read.ptr != last || !(nm > 0)) return std::nullopt;
    return SpectralName{name.substr(0, dot), nm};
}

std::vector<double> stokes_wavelengths(const Image& image) {
    std::map<double, int> found;  // which of S0..S3, as bits
    for (const auto& [name, data] : image.channels) {
        const auto parsed = parse_spectral_channel(name);
        if (!parsed || parsed->quantity.size() != 2 || parsed->quantity[0] != 'S') continue;
        const int component = parsed->quantity[1] - '0';
        if (component >= 0 && component < 4) found[parsed->wavelength_nm] |= 1 << component;
    }
    std::vector<double> list;
    for (const auto& [nm, components] : found) {
        for (int c = 0; c < 4; ++c)
            if (!(components & (1 << c)))
                throw Error("channel '" + spectral_channel("S" + std::to_string(c), nm) +
                            "' is missing; all of S0 to S3 are needed at a wavelength");
        list.push_back(nm);
    }
    return list;
}

const std::vector<float>& spectral_data(const Image& image, const std::string& quantity,
                                        double wavelength_nm) {
    for (const auto& [name, data] : image.channels) {
        const auto parsed = parse_spectral_channel(name);
        if (parsed && parsed->quantity == quantity &&
            std::abs(parsed->wavelength_nm - wavelength_nm) < kSameWavelength_nm)
            return data;
    }
    throw Error("channel '" + spectral_channel(quantity, wavelength_nm) +
                "' is missing; name an image that has it");
}

void declare_stokes(Image& image, const std::string& frame) {
    image.attributes["spectralLayoutVersion"] = "1.0";
    image.attributes["emissiveUnits"] = "W.m^-2.sr^-1";
    image.attributes["polarisationHandedness"] = "right";
    image.attributes["spectralQuantity"] = "spectral radiance per nm";
    image.attributes["stokesReferenceFrame"] = frame;
}

Image described(const Film& film, const Labels& labels, DolpEstimator estimator) {
    Image image;
    image.width = film.width;
    image.height = film.height;
    declare_stokes(image, "image");
    image.attributes["aolpUnits"] = "degrees";
    image.attributes["dolpEstimator"] = estimator == DolpEstimator::kRaw ? "raw" : "MAS";
    for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w)
        add_quantities(image, film, w, estimator);
    add(image, "A", [&film](std::size_t i) { return film.coverage[i]; });
    add(image, "Z", [&film](std::size_t i) { return film.distance[i]; });
    add(image, "N.samples", [&film](std::size_t i) { return film.samples[i]; });
    add(image, "N.replicates", [&film](std::size_t i) { return film.at(i, 0).replicates; });
    add_ids(image, "material.id", "materialNames", film, labels.material_of_instance,
            labels.materials);
    add_ids(image, "node.id", "nodeNames", film, labels.node_of_instance, labels.nodes);
    // For ordinary viewers: S0 of the middle wavelength as grey.
    const std::size_t grey = film.wavelengths_nm.size() / 2;
    for (const char* name : {"R", "G", "B"})
        add(image, name, [&film, grey](std::size_t i) { return film.at(i, grey).mean.s0; });
    image.attributes["greyWavelength"] = static_cast<float>(film.wavelengths_nm[grey]);
    return image;
}

Image to_image(const Film& film, const Labels& labels, DolpEstimator estimator) {
    Image image = described(film, labels, estimator);
    image.compute_channels();
    return image;
}

}  // namespace malus
