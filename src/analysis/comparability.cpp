// comparability.cpp — what headers and channels of two images say of a comparison.
// SPDX-License-Identifier: Apache-2.0
#include "analysis/comparability.h"

#include <algorithm>
#include <array>

#include "malus/analysis/quantity.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

std::string size_of(const Image& image) {
    return std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels";
}

bool has_errors(const Image& image, const std::vector<double>& wavelengths_nm) {
    for (double nm : wavelengths_nm)
        for (const char* name : {"S0", "S1", "S2", "S3"})
            if (read_quantity(image, name, nm).error.empty()) return false;
    return true;
}

bool same_channel(const Image& a, const Image& b, const std::string& name) {
    const auto x = a.channels.find(name), y = b.channels.find(name);
    return x != a.channels.end() && y != b.channels.end() && x->second == y->second;
}

std::set<std::string> seeds(const Image& image) {
    std::set<std::string> found;
    const std::string* text = image.text("seed");
    for (std::size_t at = 0; text && at < text->size();) {
        const std::size_t end = std::min(text->find(", ", at), text->size());
        found.insert(text->substr(at, end - at));
        at = end + 2;
    }
    return found;
}

bool share_seeds(const Image& a, const Image& b) {
    const std::set<std::string> other = seeds(b);
    for (const std::string& seed : seeds(a))
        if (other.count(seed)) return true;
    return false;
}

// Both drew the very same numbers, and would be the same if nothing had changed.
bool same_numbers(const Image& a, const Image& b) {
    for (const char* name : {"seed", "skyTable", "maxDepth", "malusVersion"})
        if (attribute(a, name).empty() || attribute(a, name) != attribute(b, name)) return false;
    return stokes_wavelengths(a) == stokes_wavelengths(b) && same_channel(a, b, "N.samples") &&
           same_channel(a, b, "N.replicates");
}

}  // namespace

std::string attribute(const Image& image, const std::string& name) {
    const auto found = image.attributes.find(name);
    if (found == image.attributes.end()) return {};
    if (const int* integer = std::get_if<int>(&found->second)) return std::to_string(*integer);
    const std::string* text = image.text(name);
    return text ? one_line(*text) : std::string();
}

bool differ(const Image& a, const Image& b, const std::string& name) {
    const std::string x = attribute(a, name), y = attribute(b, name);
    return !x.empty() && !y.empty() && x != y;
}

std::set<std::string> material_names(const Image& image) {
    const auto found = image.attributes.find("materialNames");
    if (found == image.attributes.end()) return {};
    const auto* names = std::get_if<std::vector<std::string>>(&found->second);
    if (!names || names->empty()) return {};
    return {names->begin() + 1, names->end()};  // the first is that of no surface
}

void check_comparable(const Image& a, const Image& b) {
    if (a.width != b.width || a.height != b.height)
        throw Error("another size (" + size_of(a) + ", " + size_of(b) + ")");
    constexpr std::array<std::pair<const char*, const char*>, 4> kMustAgree{
        {{"stokesReferenceFrame", "another frame of the Stokes vectors"},
         {"polarisationHandedness", "another sign of S3"},
         {"emissiveUnits", "other units"},
         {"viewHash", "another view of the scene"}}};
    for (const auto& [name, what] : kMustAgree)
        if (differ(a, b, name))
            throw Error(std::string(what) + " (header " + name + ": " + attribute(a, name) + ", " +
                        attribute(b, name) + ")");
}

std::vector<double> shared_wavelengths(const Image& a, const Image& b,
                                       const std::vector<double>& asked_nm) {
    const std::vector<double> first = said_of("first", [&] { return wavelengths_of(a, asked_nm); }),
                              second =
                                  said_of("second", [&] { return wavelengths_of(b, asked_nm); });
    bool same = first.size() == second.size();
    for (double nm : first) same = same && find_wavelength(second, nm);
    if (!same)
        throw Error("other wavelengths (" + to_text(first) + ", the other " + to_text(second) +
                    " nm); choose --wavelengths that both have");
    return first;
}

Errors errors_of(const Image& a, const Image& b, const std::vector<double>& wavelengths_nm) {
    if (same_numbers(a, b)) return Errors::kSameNumbers;
    const bool a_has = said_of("first", [&] { return has_errors(a, wavelengths_nm); }),
               b_has = said_of("second", [&] { return has_errors(b, wavelengths_nm); });
    if (!a_has || !b_has) return Errors::kNone;
    const bool traced = attribute(a, "skyTable") == "0" && attribute(b, "skyTable") == "0";
    return traced ? Errors::kIndependent : Errors::kShared;
}

std::vector<std::string> notes_on(const Image& a, const Image& b, Errors errors) {
    std::vector<std::string> notes;
    if (errors == Errors::kSameNumbers)
        notes.push_back(
            "same seed and samples, so the same random numbers: z-scores mean nothing, and what is "
            "not identical has changed; render one with another --seed to judge by error bars");
    else if (errors == Errors::kNone)
        notes.push_back(
            "no error channels in one of them (StdErr_S0 to StdErr_S3): judged by limits on the "
            "differences alone");
    else if (share_seeds(a, b))
        notes.push_back(
            "a seed in common (" + attribute(a, "seed") +
            "), so partly the same random numbers: z-scores are too small, and little is found; "
            "render one with another --seed");
    if (errors == Errors::kShared)
        notes.push_back(
            "pixels may share errors (sky table), which hides small differences of a whole "
            "picture; "
            "render both with --no-sky-table to find them");
    const std::set<std::string> of_a = material_names(a), of_b = material_names(b);
    const auto note_missing = [&](const auto& some, const auto& others, const char* which) {
        for (const std::string& name : some)
            if (!others.empty() && !others.count(name))
                notes.push_back("only the " + std::string(which) + " image has a paint '" +
                                one_line(name) +
                                "': its pixels are tested as part of all surfaces");
    };
    note_missing(of_a, of_b, "first"), note_missing(of_b, of_a, "second");
    // Hashes of paints and sky are of what all wavelengths of a render need of them.
    const bool same_set = stokes_wavelengths(a) == stokes_wavelengths(b);
    constexpr std::array<std::pair<const char*, const char*>, 6> kMayDiffer{
        {{"sceneHash", "the scene"},
         {"paintsHash", "the paints"},
         {"skyHash", "the sky"},
         {"maxDepth", "--max-depth"},
         {"malusVersion", "the version of malus"},
         {"dolpEstimator", "the estimator of DoLP; compared is that of the Stokes vectors"}}};
    for (const auto& [name, what] : kMayDiffer)
        if (differ(a, b, name) &&
            (same_set || (name != std::string("paintsHash") && name != std::string("skyHash"))))
            notes.push_back("by their headers they differ in " + std::string(what) + " (" + name +
                            ": " + attribute(a, name) + ", " + attribute(b, name) + ")");
    return notes;
}

}  // namespace malus
