// spectral_image.cpp — films to channels, and the names of channels.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/spectral_image.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <map>
#include <thread>

#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

struct Quantity {
    const char* name;
    double (*of)(const PixelStokes&);
};
const std::array<Quantity, 15> kQuantities{{
    {"S0", [](const PixelStokes& p) { return p.mean.s0; }},
    {"S1", [](const PixelStokes& p) { return p.mean.s1; }},
    {"S2", [](const PixelStokes& p) { return p.mean.s2; }},
    {"S3", [](const PixelStokes& p) { return p.mean.s3; }},
    {"DoLP", [](const PixelStokes& p) { return std::min(1.0, dolp(p.mean)); }},
    {"AoLP", [](const PixelStokes& p) { return aolp_degrees(p.mean); }},
    {"StdErr_S0", [](const PixelStokes& p) { return std::sqrt(double{p.covariance[0]}); }},
    {"StdErr_S1", [](const PixelStokes& p) { return std::sqrt(double{p.covariance[3]}); }},
    {"StdErr_S2", [](const PixelStokes& p) { return std::sqrt(double{p.covariance[5]}); }},
    {"StdErr_S3", [](const PixelStokes& p) { return std::sqrt(double{p.covariance[6]}); }},
    {"Cov_S0S1", [](const PixelStokes& p) { return double{p.covariance[1]}; }},
    {"Cov_S0S2", [](const PixelStokes& p) { return double{p.covariance[2]}; }},
    {"Cov_S1S2", [](const PixelStokes& p) { return double{p.covariance[4]}; }},
    {"StdErr_DoLP", [](const PixelStokes& p) { return stderr_dolp(p); }},
    {"StdErr_AoLP", [](const PixelStokes& p) { return to_degrees(stderr_aolp(p)); }},
}};

// All quantities at all wavelengths: pixels in blocks that stay in the cache, shared by threads.
void fill_quantities(Image& image, const Film& film, DolpEstimator estimator) {
    struct Channel {
        float* first;
        double (*of)(const PixelStokes&);
    };
    std::vector<Channel> channels;  // [wavelength][quantity]
    for (double nm : film.wavelengths_nm)
        for (const Quantity& quantity : kQuantities) {
            const bool debiased =
                estimator == DolpEstimator::kDebiased && quantity.name == std::string_view("DoLP");
            channels.push_back({image.channel(spectral_channel(quantity.name, nm)).data(),
                                debiased ? &debiased_dolp : quantity.of});
        }
    constexpr std::size_t kBlock = 64;
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
        for (std::size_t from; (from = next.fetch_add(kBlock)) < film.pixel_count();) {
            const std::size_t to = std::min(from + kBlock, film.pixel_count());
            for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w)
                for (std::size_t q = 0; q < kQuantities.size(); ++q) {
                    const Channel& channel = channels[w * kQuantities.size() + q];
                    for (std::size_t i = from; i < to; ++i)
                        channel.first[i] = static_cast<float>(channel.of(film.at(i, w)));
                }
        }
    };
    std::vector<std::jthread> helpers;
    if (film.pixel_count() > 16 * kBlock)
        for (unsigned t = 1; t < std::thread::hardware_concurrency(); ++t)
            helpers.emplace_back(work);
    work();
}

// Ids count from 1 in the header's list of names; 0 is the sky.
void fill_ids(Image& image, const std::string& channel, const std::string& attribute,
              const Film& film, const std::vector<int>& of_instance,
              const std::vector<std::string>& names) {
    std::vector<float>& ids = image.channel(channel);
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const std::int32_t instance = film.instance[i];
        ids[i] = instance < 0
                     ? 0.0f
                     : static_cast<float>(of_instance[static_cast<std::size_t>(instance)] + 1);
    }
    std::vector<std::string> listed{"(sky)"};
    listed.insert(listed.end(), names.begin(), names.end());
    image.attributes[attribute] = listed;
}

}  // namespace

double aolp_degrees(const Stokes<double>& S) {
    const double degrees = to_degrees(aolp(S));
    return static_cast<float>(degrees) < 180.0f ? degrees : 0.0;
}

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

Image to_image(const Film& film, const Labels& labels, DolpEstimator estimator) {
    Image image;
    image.width = film.width;
    image.height = film.height;
    declare_stokes(image, "image");
    image.attributes["aolpUnits"] = "degrees";
    image.attributes["dolpEstimator"] = estimator == DolpEstimator::kRaw ? "raw" : "MAS";
    fill_quantities(image, film, estimator);
    image.channel("A") = film.coverage;
    image.channel("Z") = film.distance;
    std::copy(film.samples.begin(), film.samples.end(), image.channel("N.samples").begin());
    std::vector<float>& replicates = image.channel("N.replicates");
    for (std::size_t i = 0; i < replicates.size(); ++i) replicates[i] = film.at(i, 0).replicates;
    fill_ids(image, "material.id", "materialNames", film, labels.material_of_instance,
             labels.materials);
    fill_ids(image, "node.id", "nodeNames", film, labels.node_of_instance, labels.nodes);
    // For ordinary viewers: S0 of the middle wavelength as grey.
    const double grey_nm = film.wavelengths_nm[film.wavelengths_nm.size() / 2];
    for (const char* name : {"R", "G", "B"})
        image.channel(name) = image.channels.at(spectral_channel("S0", grey_nm));
    image.attributes["greyWavelength"] = static_cast<float>(grey_nm);
    return image;
}

}  // namespace malus
