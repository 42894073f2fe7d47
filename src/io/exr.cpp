// exr.cpp — the one place that knows OpenEXR.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/exr.h"

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <ImfStringVectorAttribute.h>
#include <ImfTestFile.h>
#include <ImfThreading.h>

#include <algorithm>
#include <future>
#include <thread>

#include "malus/core/error.h"
#include "malus/io/file.h"

namespace fs = std::filesystem;

namespace malus {
namespace {

void insert(Imf::Header& header, const std::string& name, const Attribute& value) {
    if (const auto* text = std::get_if<std::string>(&value))
        header.insert(name, Imf::StringAttribute(*text));
    else if (const auto* number = std::get_if<float>(&value))
        header.insert(name, Imf::FloatAttribute(*number));
    else if (const auto* integer = std::get_if<int>(&value))
        header.insert(name, Imf::IntAttribute(*integer));
    else
        header.insert(name, Imf::StringVectorAttribute(std::get<std::vector<std::string>>(value)));
}

void collect_attributes(const Imf::Header& header, Image& image) {
    for (auto i = header.begin(); i != header.end(); ++i) {
        const Imf::Attribute& a = i.attribute();
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a))
            image.attributes[i.name()] = text->value();
        else if (const auto* number = dynamic_cast<const Imf::FloatAttribute*>(&a))
            image.attributes[i.name()] = number->value();
        else if (const auto* integer = dynamic_cast<const Imf::IntAttribute*>(&a))
            image.attributes[i.name()] = integer->value();
        else if (const auto* texts = dynamic_cast<const Imf::StringVectorAttribute*>(&a))
            image.attributes[i.name()] = texts->value();
    }
}

// Floats whose first stands at (window.min.x, window.min.y).
Imf::Slice slice(const float* data, const Imath::Box2i& window) {
    // OpenEXR takes char* for input and output alike.
    return Imf::Slice::Make(Imf::FLOAT, const_cast<float*>(data), window);
}

void check_size(const Imath::Box2i& window) {
    const auto width = std::int64_t{window.max.x} - window.min.x + 1;
    const auto height = std::int64_t{window.max.y} - window.min.y + 1;
    if (width < 1 || height < 1 || width * height > (std::int64_t{1} << 31))
        throw Error("the picture is empty or has over 2³¹ pixels");
}

constexpr int kRows = 16;                           // that ZIP takes at once
constexpr std::size_t kNumbersAtOnce = 8ull << 20;  // computed and kept until ZIP has taken them
constexpr std::size_t kNumbersCached = 1ull << 20;  // the same where nothing compresses them

enum class Wanted { kAll, kHeader };

Image read_part(const fs::path& path, Wanted wanted) {
    Imf::MultiPartInputFile parts(path.c_str());
    if (parts.parts() != 1)
        throw Error("it has " + std::to_string(parts.parts()) + " parts, not one");
    Imf::InputFile file(path.c_str());
    const Imf::Header& header = file.header();
    const Imath::Box2i window = header.dataWindow();
    check_size(window);
    Image image;
    image.width = window.max.x - window.min.x + 1;
    image.height = window.max.y - window.min.y + 1;
    collect_attributes(header, image);
    if (wanted == Wanted::kHeader) return image;
    Imf::FrameBuffer frame;
    const Imf::ChannelList& channels = header.channels();
    for (auto c = channels.begin(); c != channels.end(); ++c) {
        if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
            throw Error("channel '" + std::string(c.name()) + "' is subsampled");
        frame.insert(c.name(), slice(image.channel(c.name()).data(), window));
    }
    file.setFrameBuffer(frame);
    file.readPixels(window.min.y, window.max.y);
    return image;
}

Image read(const fs::path& path, Wanted wanted) {
    std::error_code error;
    if (!fs::exists(path, error)) throw Error(path.string() + ": file not found; check the name");
    if (!fs::is_regular_file(path, error) || !Imf::isOpenExrFile(path.c_str()))
        throw Error(path.string() + ": not an OpenEXR file; name one");
    try {
        return read_part(path, wanted);
    } catch (const std::exception& problem) {
        throw Error(path.string() + ": cannot be read (" + one_line(problem.what()) +
                    "); the file may be damaged or cut off, make it again");
    }
}

int thread_count() {
    return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

// Computes pixels [from, to) of all channels, in blocks whose sources stay in the cache from channel
// to channel. Number i of the n-th channel goes to first[n][i].
void compute(const Image& image, std::size_t from, std::size_t to,
             const std::vector<float*>& first) {
    constexpr std::size_t kBlock = 64;
    std::vector<float*> numbers = first;
    for (std::size_t at = from; at < to; at += kBlock) {
        float* const* next = numbers.data();
        for (const ComputedChannels& channels : image.computed) {
            channels.of(at, std::min(at + kBlock, to), next);
            next += channels.names.size();
        }
        for (float*& number : numbers) number += kBlock;
    }
}

std::size_t computed_count(const Image& image) {
    std::size_t count = 0;
    for (const ComputedChannels& channels : image.computed) count += channels.names.size();
    return count;
}

// Computed channels for some rows at a time: of a large image they are more than all else that a
// render needs, and fresh pages cost as much as their numbers.
struct Strip {
    int first = 0, end = 0;
    std::vector<float> numbers;
    std::vector<float*> channels;  ///< where each one's numbers start

    Strip(std::size_t count, std::size_t pixels) {
        // Not a power of two apart, or all would compete for the same few lines of the cache.
        const std::size_t stride = (pixels + 15) / 16 * 16 + 16;
        numbers.resize(count * stride);
        for (std::size_t i = 0; i < count; ++i) channels.push_back(numbers.data() + i * stride);
    }
};

// Rows of a strip: what ZIP takes at once for each of OpenEXR's threads, fewer where they are large;
// without ZIP as many as stay in the cache until they are written.
int rows_at_once(std::size_t channels, int width, int threads, Compression compression) {
    const std::size_t row = std::max<std::size_t>(1, channels * static_cast<std::size_t>(width));
    const auto share = [&](std::size_t numbers, std::size_t most) {
        return static_cast<int>(std::clamp<std::size_t>(numbers / row, 1, most));
    };
    if (compression == Compression::kNone) return share(kNumbersCached, 256);
    return kRows * share(kNumbersAtOnce / kRows, static_cast<std::size_t>(threads));
}

// Each strip is computed while the one before it is written, which takes longer.
void write_rows(Imf::OutputFile& file, const Image& image, const Imf::FrameBuffer& whole,
                int rows) {
    const auto width = static_cast<std::size_t>(image.width);
    const std::size_t channels = computed_count(image),
                      pixels = width * static_cast<std::size_t>(rows);
    Strip written(channels, pixels), computed(channels, pixels);
    const auto fill = [&](int first) {
        computed.first = first, computed.end = std::min(first + rows, image.height);
        compute(image, static_cast<std::size_t>(first) * width,
                static_cast<std::size_t>(computed.end) * width, computed.channels);
    };
    fill(0);
    while (computed.first < image.height) {
        std::swap(written, computed);
        auto next = std::async(std::launch::async, fill, written.end);
        const Imath::Box2i window({0, written.first}, {image.width - 1, written.end - 1});
        Imf::FrameBuffer frame = whole;
        auto numbers = written.channels.begin();
        for (const ComputedChannels& group : image.computed)
            for (const std::string& name : group.names)
                frame.insert(name, slice(*numbers++, window));
        file.setFrameBuffer(frame);
        file.writePixels(written.end - written.first);
        next.get();
    }
}

}  // namespace

void Image::compute_channels() {
    std::vector<float*> first;
    for (const ComputedChannels& group : computed)
        for (const std::string& name : group.names) first.push_back(channel(name).data());
    compute(*this, 0, pixel_count(), first);
    computed.clear();
}

std::vector<float>& Image::channel(const std::string& name) {
    std::vector<float>& data = channels[name];
    data.resize(pixel_count());
    return data;
}

const std::string* Image::text(const std::string& attribute) const {
    const auto found = attributes.find(attribute);
    return found == attributes.end() ? nullptr : std::get_if<std::string>(&found->second);
}

const float* Image::number(const std::string& attribute) const {
    const auto found = attributes.find(attribute);
    return found == attributes.end() ? nullptr : std::get_if<float>(&found->second);
}

Image read_exr(const fs::path& path) {
    return read(path, Wanted::kAll);
}

Image read_exr_header(const fs::path& path) {
    return read(path, Wanted::kHeader);
}

void check_exr_name(const fs::path& path) {
    const std::string ending = path.extension().string();
    if (ending != ".exr" && ending != ".EXR")
        throw Error(path.string() +
                    ": the image is an EXR file; name it .exr (malus preview makes "
                    "pictures of it)");
}

void write_exr(const fs::path& path, const Image& image, Compression compression) {
    const Imath::Box2i window({0, 0}, {image.width - 1, image.height - 1});
    Imf::Header header(window, window);
    header.compression() =
        compression == Compression::kZip ? Imf::ZIP_COMPRESSION : Imf::NO_COMPRESSION;
    for (const auto& [name, value] : image.attributes) insert(header, name, value);
    Imf::FrameBuffer frame;
    for (const auto& [name, data] : image.channels) {
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        frame.insert(name, slice(data.data(), window));
    }
    for (const ComputedChannels& channels : image.computed)
        for (const std::string& name : channels.names)
            header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    write_whole(path, [&](const fs::path& beside) {
        // Compression is most of the work; threads of OpenEXR's pool share it.
        const int threads = thread_count();
        if (Imf::globalThreadCount() < threads) Imf::setGlobalThreadCount(threads);
        Imf::OutputFile file(beside.c_str(), header, threads);
        const int rows = rows_at_once(computed_count(image), image.width, threads, compression);
        write_rows(file, image, frame, rows);
    });
}

}  // namespace malus
