// exr.h — named float channels and attributes in an OpenEXR file.
//
// Written as one part of scanlines, 32-bit float, ZIP or uncompressed, dataWindow = displayWindow.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace malus {

using Attribute = std::variant<std::string, float, int, std::vector<std::string>>;

/// Channels that are computed as they are written, several at once where they share work.
struct ComputedChannels {
    std::vector<std::string> names;
    /// The numbers of pixels [from, to), rows from the top, one array for each name. Called by
    /// several threads at once.
    std::function<void(std::size_t from, std::size_t to, float* const* numbers)> of;
};

/// Channels of one size, rows from the top, and what the header says of them.
struct Image {
    int width = 0, height = 0;
    std::map<std::string, std::vector<float>> channels;
    std::vector<ComputedChannels> computed;  ///< written like the others; none when read
    std::map<std::string, Attribute> attributes;

    std::size_t pixel_count() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    /// The channel, made of zeros if it does not exist yet.
    std::vector<float>& channel(const std::string& name);
    /// Makes channels of the computed ones.
    void compute_channels();
    const std::string* text(const std::string& attribute) const;  ///< nullptr if absent
    const float* number(const std::string& attribute) const;      ///< nullptr if absent
};

/// Throws Error when the file is missing, not OpenEXR, damaged, tiled in levels or of many parts.
Image read_exr(const std::filesystem::path& path);
/// The same without channels.
Image read_exr_header(const std::filesystem::path& path);

/// Throws Error unless the name ends in .exr: what is written is one, whatever its name.
void check_exr_name(const std::filesystem::path& path);

/// ZIP takes half a second a core for 30 MB of noisy floats, and saves a few per cent of them.
enum class Compression { kZip, kNone };

/// Appears whole or not at all; throws Error.
void write_exr(const std::filesystem::path& path, const Image& image,
               Compression compression = Compression::kZip);

}  // namespace malus
