// provenance.cpp — what two headers must share.
// SPDX-License-Identifier: Apache-2.0
#include "cli/provenance.h"

#include <array>
#include <charconv>

#include "cli/render_inputs.h"
#include "malus/core/error.h"
#include "malus/scene/fingerprint.h"

namespace malus::cli {
namespace {

struct Entry {
    const char *attribute, *what;
};
constexpr std::array<Entry, 7> kShared{{{"wavelengths", "other wavelengths"},
                                        {"sceneHash", "another scene"},
                                        {"paintsHash", "other paints"},
                                        {"skyHash", "another sky"},
                                        {"viewHash", "another view"},
                                        {"maxDepth", "another --max-depth"},
                                        {"malusVersion", "another version of malus"}}};

std::string size_of(const Image& image) {
    return std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels";
}

std::string value(const Image& image, const char* attribute) {
    const auto found = image.attributes.find(attribute);
    if (found == image.attributes.end()) return "none";
    if (const int* integer = std::get_if<int>(&found->second)) return std::to_string(*integer);
    const std::string* text = image.text(attribute);
    return text ? one_line(*text) : "of another type";
}

bool is_seed(const std::string& text) {
    std::uint64_t number = 0;
    const char* last = text.data() + text.size();
    const auto read = std::from_chars(text.data(), last, number);
    return read.ec == std::errc() && read.ptr == last && std::to_string(number) == text;
}

}  // namespace

void add_fingerprints(Image& image, const Inputs& in) {
    image.attributes["sceneHash"] = fingerprint(in.scene);
    image.attributes["paintsHash"] = fingerprint(in.materials, in.paints, in.wavelengths_nm);
    image.attributes["skyHash"] = fingerprint(in.sky, in.wavelengths_nm);
    image.attributes["viewHash"] = fingerprint(in.camera);
}

std::vector<std::string> seeds_of(const Image& header) {
    for (const Entry& entry : kShared)
        if (!header.attributes.count(entry.attribute))
            throw Error("the header has no " + std::string(entry.attribute));
    const std::string* text = header.text("seed");
    if (!text) throw Error("the header has no seed");
    std::vector<std::string> seeds;
    for (std::size_t at = 0; at <= text->size();) {
        const std::size_t end = std::min(text->find(", ", at), text->size());
        seeds.push_back(text->substr(at, end - at));
        if (!is_seed(seeds.back()))
            throw Error("the header's seed '" + one_line(*text) + "' is no list of numbers");
        at = end + 2;
    }
    return seeds;
}

std::string first_difference(const Image& a, const Image& b) {
    if (a.width != b.width || a.height != b.height)
        return "another size (" + size_of(a) + ", " + size_of(b) + ")";
    for (const Entry& entry : kShared) {
        const std::string x = value(a, entry.attribute), y = value(b, entry.attribute);
        if (x != y)
            return std::string(entry.what) + " (header " + entry.attribute + ": " + x + ", " + y +
                   ")";
    }
    return {};
}

}  // namespace malus::cli
