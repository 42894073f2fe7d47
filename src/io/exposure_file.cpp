// exposure_file.cpp — exposures to channels and back.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/exposure_file.h"

#include <algorithm>
#include <cmath>

#include "malus/core/digest.h"
#include "malus/core/error.h"
#include "malus/io/spectral_image.h"

namespace malus {
namespace {

std::string sum_channel(std::size_t replicate, std::size_t component, double wavelength_nm) {
    return spectral_channel("Sum" + std::to_string(replicate) + "_S" + std::to_string(component),
                            wavelength_nm);
}
std::string open_channel(std::size_t replicate, double wavelength_nm) {
    return spectral_channel("Sum" + std::to_string(replicate) + "_open", wavelength_nm);
}
std::string kept_channel(std::size_t replicate) {
    return "Sum" + std::to_string(replicate) + ".kept";
}

template <class T>
void add(Image& image, const std::string& name, const std::vector<T>& values) {
    std::transform(values.begin(), values.end(), image.channel(name).begin(),
                   [](T value) { return static_cast<float>(value); });
}

const std::vector<float>& channel(const Image& image, const std::string& name) {
    const auto found = image.channels.find(name);
    if (found == image.channels.end()) throw Error("channel '" + name + "' is missing");
    return found->second;
}

template <class T>
void take(const Image& image, const std::string& name, T least, std::vector<T>& values) {
    const std::vector<float>& data = channel(image, name);
    for (std::size_t i = 0; i < data.size(); ++i) {
        // Floats that hold counts; what is beyond 2³¹ is none.
        if (!(data[i] >= static_cast<float>(least) && data[i] < 0x1p31f))
            throw Error("channel '" + name + "' holds " + std::to_string(data[i]));
        values[i] = static_cast<T>(data[i]);
    }
}

std::uint32_t replicates_of(const Image& image) {
    std::uint32_t count = 0;
    while (image.channels.count(kept_channel(count))) ++count;
    return count;
}

std::vector<double> exposure_wavelengths(const Image& image) {
    std::vector<double> list;
    for (const auto& [name, data] : image.channels) {
        const auto parsed = parse_spectral_channel(name);
        if (parsed && parsed->quantity == "Sum0_S0") list.push_back(parsed->wavelength_nm);
    }
    std::sort(list.begin(), list.end());
    return list;
}

Exposure exposure_of(const Image& image) {
    const std::vector<double> wavelengths_nm = exposure_wavelengths(image);
    const std::uint32_t replicates = replicates_of(image);
    if (image.channels.size() != 6 + replicates * (1 + 5 * wavelengths_nm.size()))
        throw Error("it has " + std::to_string(image.channels.size()) +
                    " channels, which do not fit " + std::to_string(replicates) +
                    " replicates at " + std::to_string(wavelengths_nm.size()) + " wavelengths");
    Exposure e(image.width, image.height, wavelengths_nm, replicates);
    take(image, "Sum.taken", 0u, e.taken);
    take(image, "Sum.wanted", 0u, e.wanted);
    take(image, "Sum.covered", 0u, e.covered);
    e.distance = channel(image, "Sum.distance");
    for (float metres : e.distance)
        if (!(metres >= 0 && std::isfinite(metres)))
            throw Error("channel 'Sum.distance' holds " + std::to_string(metres));
    take(image, "Sum.instance", -1, e.instance);
    take(image, "Sum.votes", 0u, e.votes);
    for (std::size_t r = 0; r < e.replicates; ++r) {
        const std::vector<float>& kept = channel(image, kept_channel(r));
        for (std::size_t i = 0; i < e.pixel_count(); ++i) {
            if (!(kept[i] >= 0 && kept[i] <= static_cast<float>(e.taken[i])) ||
                e.taken[i] != checkpoint(e.taken[i]))
                throw Error("its counts of samples contradict each other");
            e.kept[i * e.replicates + r] = static_cast<std::uint32_t>(kept[i]);
        }
    }
    const std::size_t wavelengths = e.wavelengths_nm.size();
    for (std::size_t r = 0; r < e.replicates; ++r)
        for (std::size_t w = 0; w < wavelengths; ++w) {
            const std::string name = open_channel(r, e.wavelengths_nm[w]);
            const std::vector<float>& shares = channel(image, name);
            for (std::size_t i = 0; i < e.pixel_count(); ++i) {
                if (!(shares[i] >= 0 && shares[i] <= 1))
                    throw Error("channel '" + name + "' holds " + std::to_string(shares[i]));
                e.open[(i * e.replicates + r) * wavelengths + w] =
                    static_cast<std::uint8_t>(std::lround(255 * shares[i]));
            }
        }
    for (std::size_t r = 0; r < e.replicates; ++r)
        for (std::size_t c = 0; c < 4; ++c)
            for (std::size_t w = 0; w < wavelengths; ++w) {
                const std::string name = sum_channel(r, c, e.wavelengths_nm[w]);
                const std::vector<float>& data = channel(image, name);
                for (std::size_t i = 0; i < data.size(); ++i) {
                    if (!std::isfinite(data[i]))
                        throw Error("channel '" + name + "' is not finite");
                    e.stokes[i * e.pixel_stride() + (c * wavelengths + w) * e.replicates + r] =
                        data[i];
                }
            }
    return e;
}

}  // namespace

std::filesystem::path sums_path(const std::filesystem::path& image) {
    return image.string() + ".sums";
}

std::string fingerprint(const Exposure& e) {
    Digest digest;
    for (const auto* counts : {&e.kept, &e.taken, &e.wanted, &e.covered, &e.votes})
        digest.add_all(*counts);
    digest.add_all(e.open);
    digest.add_all(e.instance);
    digest.add_all(e.stokes);
    digest.add_all(e.distance);
    return digest.text();
}

void write_exposure(const std::filesystem::path& path, const Exposure& e) {
    Image image;
    image.width = e.width;
    image.height = e.height;
    add(image, "Sum.taken", e.taken);
    add(image, "Sum.wanted", e.wanted);
    add(image, "Sum.covered", e.covered);
    add(image, "Sum.distance", e.distance);
    add(image, "Sum.instance", e.instance);
    add(image, "Sum.votes", e.votes);
    const std::size_t wavelengths = e.wavelengths_nm.size();
    // One of `stride` numbers a pixel, the first at `first`.
    const auto add_strided = [&](const std::string& name, const auto* first, std::size_t stride,
                                 float divisor) {
        const auto numbers_of = [=](std::size_t from, std::size_t to, float* const* numbers) {
            for (std::size_t i = from; i < to; ++i)
                numbers[0][i - from] = static_cast<float>(first[i * stride]) / divisor;
        };
        image.computed.push_back({{name}, numbers_of});
    };
    for (std::size_t r = 0; r < e.replicates; ++r) {
        add_strided(kept_channel(r), e.kept.data() + r, e.replicates, 1);
        for (std::size_t w = 0; w < wavelengths; ++w)
            add_strided(open_channel(r, e.wavelengths_nm[w]), e.open.data() + r * wavelengths + w,
                        e.replicates * wavelengths, 255);
        for (std::size_t c = 0; c < 4; ++c)
            for (std::size_t w = 0; w < wavelengths; ++w)
                add_strided(sum_channel(r, c, e.wavelengths_nm[w]),
                            e.stokes.data() + (c * wavelengths + w) * e.replicates + r,
                            e.pixel_stride(), 1);
    }
    write_exr(path, image, Compression::kNone);
}

Exposure read_exposure(const std::filesystem::path& path) {
    const Image image = read_exr(path);
    try {
        return exposure_of(image);
    } catch (const Error& problem) {
        throw Error(path.string() + ": not the sums of a render: " + problem.what() +
                    "; render anew");
    }
}

}  // namespace malus
