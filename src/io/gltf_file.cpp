// gltf_file.cpp — confined file access and URIs of glTF scenes.
// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "io/gltf_error.h"

namespace malus::gltf {
namespace {

namespace fs = std::filesystem;

class OpenFile {
  public:
    // Without O_NONBLOCK, opening a pipe that nobody writes to never returns.
    explicit OpenFile(const fs::path& path)
        : descriptor_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {}
    ~OpenFile() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    int descriptor() const { return descriptor_; }

  private:
    int descriptor_;
};

[[noreturn]] void fail_on_file(const std::string& place, const fs::path& path,
                               const std::string& problem, const std::string& remedy) {
    fail(place, "file '" + one_line(path.filename().string()) + "' " + problem, remedy);
}

std::string why() {
    return std::string("(") + std::strerror(errno) + ")";
}

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::string percent_decoded(std::string_view text, const std::string& place) {
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            decoded += text[i];
            continue;
        }
        const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
        const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
        if (high < 0 || low < 0)
            fail(place, "'%' in the uri is not followed by two hex digits",
                 "write a percent sign in a file name as %25");
        decoded += static_cast<char>(16 * high + low);
        i += 2;
    }
    return decoded;
}

std::string lower_case(std::string_view text) {
    std::string lower(text);
    std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    return lower;
}

constexpr std::array<signed char, 256> base64_values() {
    constexpr std::string_view kAlphabet =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<signed char, 256> values{};
    values.fill(-1);
    for (std::size_t i = 0; i < kAlphabet.size(); ++i)
        values[static_cast<unsigned char>(kAlphabet[i])] = static_cast<signed char>(i);
    return values;
}

// Missing padding is accepted: the length says as much.
Bytes base64_decoded(std::string_view text, const std::string& place) {
    static constexpr auto kValues = base64_values();
    for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);
    if (text.size() % 4 == 1)
        fail(place, "data URI is cut short (its base64 has an impossible length)");
    Bytes bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    unsigned pending = 0;
    int bits = 0;
    for (const char c : text) {
        const int value = kValues[static_cast<unsigned char>(c)];
        if (value < 0) fail(place, "data URI is not base64 (it holds a foreign character)");
        pending = (pending << 6 | static_cast<unsigned>(value)) & 0xFFFF;
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        bytes.push_back(static_cast<unsigned char>(pending >> bits & 0xFF));
    }
    return bytes;
}

// data:[<media type>][;base64],<data>
Bytes read_data_uri(std::string_view uri, std::size_t most, const std::string& place) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos) fail(place, "data URI has no comma before its data");
    const bool base64 = lower_case(uri.substr(0, comma)).ends_with(";base64");
    std::string_view data = uri.substr(comma + 1);
    if ((base64 ? data.size() / 4 * 3 : data.size()) > most)
        fail(place, "data URI is too large for the memory limit", "split the scene");
    std::string decoded;
    if (data.find('%') != std::string_view::npos) data = decoded = percent_decoded(data, place);
    return base64 ? base64_decoded(data, place) : Bytes(data.begin(), data.end());
}

// The path a uri names, relative to the scene's folder and free of every way out but links.
fs::path relative_path(const std::string& uri, const std::string& place) {
    const std::string remedy = "place the file beside the scene and name it by a relative path";
    const std::string shown = "uri '" + one_line(uri) + "' ";
    if (uri.empty()) fail(place, "uri is empty, no file can be found", remedy);
    const std::size_t colon = uri.find(':');
    if (colon != std::string::npos && colon < uri.find('/'))
        fail(place, shown + "has a scheme or a drive, which is not allowed", remedy);
    const std::string path = percent_decoded(uri, place);
    if (path.find('\0') != std::string::npos)
        fail(place, shown + "holds a zero byte, which is not allowed", remedy);
    if (path.find('\\') != std::string::npos)
        fail(place, shown + "holds a backslash, which is not allowed", remedy);
    if (path.front() == '/')
        fail(place, shown + "is an absolute path, which is not allowed", remedy);
    for (const fs::path& part : fs::path(path))
        if (part == "..") fail(place, shown + "holds '..', which is not allowed", remedy);
    return path;
}

// Links are resolved first: one inside the folder may lead outside.
fs::path path_inside(const fs::path& folder, const fs::path& relative, const std::string& place) {
    std::error_code error;
    const fs::path root = fs::canonical(folder.empty() ? "." : folder, error);
    const fs::path target = error ? fs::path() : fs::canonical(root / relative, error);
    if (error)
        fail_on_file(place, relative, "not found (" + error.message() + ")",
                     "place it beside the scene");
    const auto [in_root, in_target] =
        std::mismatch(root.begin(), root.end(), target.begin(), target.end());
    if (in_root != root.end())
        fail_on_file(place, relative, "is a link to a path outside the scene's folder",
                     "copy it there");
    return target;
}

}  // namespace

Bytes read_regular_file(const fs::path& path, std::size_t most, const std::string& place) {
    const OpenFile file(path);
    struct stat info {};
    if (file.descriptor() < 0 || ::fstat(file.descriptor(), &info) != 0)
        fail_on_file(place, path, "cannot be opened " + why(), "check path and permissions");
    if (!S_ISREG(info.st_mode))
        fail_on_file(place, path, "is not a regular file (but a folder, pipe or device)",
                     "name a file");
    const auto size = static_cast<std::size_t>(info.st_size);
    if (size > most)
        fail_on_file(place, path,
                     "is too large (" + std::to_string(size >> 20) + " MiB, limit " +
                         std::to_string(most >> 20) + " MiB)",
                     "split the scene");
    Bytes bytes(size);
    std::size_t filled = 0;
    while (filled < size) {
        const ssize_t got = ::read(file.descriptor(), bytes.data() + filled, size - filled);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail_on_file(place, path, "cannot be read " + why(), "check the disk");
        if (got == 0) break;
        filled += static_cast<std::size_t>(got);
    }
    bytes.resize(filled);
    return bytes;
}

Bytes read_uri(const std::string& uri, const fs::path& folder, std::size_t most,
               const std::string& place) {
    if (lower_case(std::string_view(uri).substr(0, 5)) == "data:")
        return read_data_uri(uri, most, place);
    return read_regular_file(path_inside(folder, relative_path(uri, place), place), most, place);
}

}  // namespace malus::gltf
