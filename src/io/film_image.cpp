// film_image.cpp — channels to films.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/film_image.h"

#include <cfloat>
#include <cmath>
#include <map>

#include "malus/core/error.h"

namespace malus {
namespace {

struct Range {
    double least, most;
    bool whole = false;  ///< integers only
};
constexpr Range kFinite{-FLT_MAX, FLT_MAX}, kNotNegative{0, FLT_MAX}, kShare{0, 1};
constexpr Range kErrors{0, 1e19};                   // whose squares are floats
constexpr Range kReplicateCount{1, FLT_MAX};        // of a mean over pictures: no integer
constexpr Range kSampleCount{0, 4294967040, true};  // the largest float below 2³²

// store(pixel, value) for all pixels of a channel.
template <class Store>
void take(const Image& image, const std::string& name, const Range& range, Store store) {
    const auto found = image.channels.find(name);
    if (found == image.channels.end()) throw Error("channel '" + name + "' is missing");
    for (std::size_t i = 0; i < found->second.size(); ++i) {
        const auto value = static_cast<double>(found->second[i]);
        // NaN compares as false.
        if (!(value >= range.least && value <= range.most) ||
            (range.whole && value != std::floor(value))) {
            const auto width = static_cast<std::size_t>(image.width);
            throw Error("channel '" + name + "' holds " + std::to_string(value) + " at pixel (" +
                        std::to_string(i % width) + ',' + std::to_string(i / width) + ")");
        }
        store(i, value);
    }
}

void take_wavelength(const Image& image, Film& film, std::size_t w) {
    const std::size_t stride = film.wavelengths_nm.size();
    const auto pixel = [&](std::size_t i) -> PixelStokes& { return film.stokes[i * stride + w]; };
    const auto name = [&](const char* quantity) {
        return spectral_channel(quantity, film.wavelengths_nm[w]);
    };
    take(image, name("S0"), kNotNegative, [&](auto i, double x) { pixel(i).mean.s0 = x; });
    take(image, name("S1"), kFinite, [&](auto i, double x) { pixel(i).mean.s1 = x; });
    take(image, name("S2"), kFinite, [&](auto i, double x) { pixel(i).mean.s2 = x; });
    take(image, name("S3"), kFinite, [&](auto i, double x) { pixel(i).mean.s3 = x; });
    const auto entry = [&](std::size_t e) {
        return [&, e](std::size_t i, double x) { pixel(i).covariance[e] = static_cast<float>(x); };
    };
    const auto squared = [&](std::size_t e) {
        return [&, e](std::size_t i, double x) {
            pixel(i).covariance[e] = static_cast<float>(sqr(x));
        };
    };
    take(image, name("StdErr_S0"), kErrors, squared(0));
    take(image, name("Cov_S0S1"), kFinite, entry(1));
    take(image, name("Cov_S0S2"), kFinite, entry(2));
    take(image, name("StdErr_S1"), kErrors, squared(3));
    take(image, name("Cov_S1S2"), kFinite, entry(4));
    take(image, name("StdErr_S2"), kErrors, squared(5));
    take(image, name("StdErr_S3"), kErrors, squared(6));
}

// Names without "(sky)", which is the first.
std::vector<std::string> listed(const Image& image, const std::string& attribute) {
    const auto found = image.attributes.find(attribute);
    const auto* names = found == image.attributes.end()
                            ? nullptr
                            : std::get_if<std::vector<std::string>>(&found->second);
    if (!names || names->empty()) throw Error("the header has no list '" + attribute + "'");
    return {names->begin() + 1, names->end()};
}

// Where each of `names` stands among the known ones, to which new ones are added. Nodes may share a
// name: the second goes to the second.
std::vector<int> places_among(std::vector<std::string>& known,
                              const std::vector<std::string>& names) {
    std::multimap<std::string, int> free;
    for (std::size_t i = 0; i < known.size(); ++i) free.emplace(known[i], static_cast<int>(i));
    std::vector<int> places;
    for (const std::string& name : names) {
        const auto found = free.lower_bound(name);
        if (found != free.end() && found->first == name) {
            places.push_back(found->second);
            free.erase(found);
        } else {
            places.push_back(static_cast<int>(known.size()));
            known.push_back(name);
        }
    }
    return places;
}

// The channel's ids as indices into the known names; −1 for the sky.
std::vector<int> take_ids(const Image& image, const std::string& channel,
                          const std::string& attribute, std::vector<std::string>& known) {
    const std::vector<int> places = places_among(known, listed(image, attribute));
    std::vector<int> ids(image.pixel_count());
    take(image, channel, {0, static_cast<double>(places.size()), true},
         [&](std::size_t i, double id) {
             ids[i] = id > 0 ? places[static_cast<std::size_t>(id) - 1] : -1;
         });
    return ids;
}

void take_instances(const Image& image, Film& film, Labels& labels) {
    const std::vector<int> materials =
        take_ids(image, "material.id", "materialNames", labels.materials);
    const std::vector<int> nodes = take_ids(image, "node.id", "nodeNames", labels.nodes);
    std::vector<int>& materials_of = labels.material_of_instance;
    std::vector<int>& nodes_of = labels.node_of_instance;
    std::map<std::pair<int, int>, std::int32_t> known;
    for (std::size_t i = 0; i < materials_of.size(); ++i)
        known.emplace(std::pair(materials_of[i], nodes_of[i]), static_cast<std::int32_t>(i));
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        if ((materials[i] < 0) != (nodes[i] < 0))
            throw Error("channels 'material.id' and 'node.id' contradict each other");
        if (materials[i] < 0) continue;
        const auto [at, is_new] = known.emplace(std::pair(materials[i], nodes[i]),
                                                static_cast<std::int32_t>(materials_of.size()));
        if (is_new) materials_of.push_back(materials[i]), nodes_of.push_back(nodes[i]);
        film.instance[i] = at->second;
    }
}

}  // namespace

Film film_of(const Image& image, Labels& labels) {
    const std::vector<double> wavelengths = stokes_wavelengths(image);
    if (wavelengths.empty()) throw Error("it has no channels S0 to S3");
    Film film(image.width, image.height, wavelengths);
    for (std::size_t w = 0; w < wavelengths.size(); ++w) take_wavelength(image, film, w);
    take(image, "A", kShare, [&](auto i, double x) { film.coverage[i] = static_cast<float>(x); });
    take(image, "Z", kNotNegative,
         [&](auto i, double x) { film.distance[i] = static_cast<float>(x); });
    take(image, "N.samples", kSampleCount,
         [&](auto i, double x) { film.samples[i] = static_cast<std::uint32_t>(x); });
    take(image, "N.replicates", kReplicateCount, [&](std::size_t i, double x) {
        for (std::size_t w = 0; w < wavelengths.size(); ++w)
            film.stokes[i * wavelengths.size() + w].replicates = static_cast<float>(x);
    });
    take_instances(image, film, labels);
    return film;
}

}  // namespace malus
