// merge.cpp — means of pictures, weighted by samples.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/merge.h"

#include <algorithm>
#include <limits>

#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

void check_alike(const Film& a, const Film& b) {
    const auto same = [](double x, double y) { return std::abs(x - y) < kSameWavelength_nm; };
    if (a.width != b.width || a.height != b.height ||
        !std::equal(a.wavelengths_nm.begin(), a.wavelengths_nm.end(), b.wavelengths_nm.begin(),
                    b.wavelengths_nm.end(), same))
        throw Error("the pictures differ in size or wavelengths; merge what is alike");
}

// `share`: the weight of b.
void merge_light(PixelStokes& a, const PixelStokes& b, double share) {
    const double rest = 1 - share;
    a.mean = held_physical(rest * a.mean + share * b.mean);
    for (std::size_t e = 0; e < a.covariance.size(); ++e)
        a.covariance[e] = static_cast<float>(sqr(rest) * static_cast<double>(a.covariance[e]) +
                                             sqr(share) * static_cast<double>(b.covariance[e]));
    a.replicates = static_cast<float>(1 / (sqr(rest) / static_cast<double>(a.replicates) +
                                           sqr(share) / static_cast<double>(b.replicates)));
}

void merge_surface(Film& film, const Film& other, std::size_t pixel, double share) {
    const double a = (1 - share) * static_cast<double>(film.coverage[pixel]);
    const double b = share * static_cast<double>(other.coverage[pixel]);
    const double distance = a * static_cast<double>(film.distance[pixel]) +
                            b * static_cast<double>(other.distance[pixel]);
    film.coverage[pixel] = static_cast<float>(a + b);
    film.distance[pixel] = a + b > 0 ? static_cast<float>(distance / (a + b)) : 0;
}

}  // namespace

void merge_into(Film& film, const Film& other) {
    check_alike(film, other);
    const std::size_t wavelengths = film.wavelengths_nm.size();
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        if (other.samples[i] == 0) continue;
        const double all = static_cast<double>(film.samples[i]) + other.samples[i];
        if (all > std::numeric_limits<std::uint32_t>::max())
            throw Error("a pixel has over 4294967295 samples; merge fewer pictures");
        const double share = other.samples[i] / all;
        for (std::size_t w = 0; w < wavelengths; ++w)
            merge_light(film.stokes[i * wavelengths + w], other.at(i, w), share);
        merge_surface(film, other, i, share);
        if (other.samples[i] > film.samples[i]) film.instance[i] = other.instance[i];
        film.samples[i] += other.samples[i];
    }
}

}  // namespace malus
