// mask.cpp — pixels by what they show.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/mask.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "malus/core/error.h"

namespace malus {
namespace {

const std::vector<std::string>* list(const Image& image, const std::string& attribute) {
    const auto found = image.attributes.find(attribute);
    return found == image.attributes.end() ? nullptr
                                           : std::get_if<std::vector<std::string>>(&found->second);
}

// The place of each node's parent in the list of nodes, 0 for none.
std::vector<std::size_t> parents(const Image& image, std::size_t nodes) {
    std::vector<std::size_t> places(nodes, 0);
    const std::vector<std::string>* texts = list(image, "nodeParents");
    for (std::size_t i = 0; texts && i < std::min(nodes, texts->size()); ++i) {
        const std::string& text = (*texts)[i];
        std::size_t place = 0;
        std::from_chars(text.data(), text.data() + text.size(), place);
        if (place < nodes) places[i] = place;
    }
    return places;
}

// Pixels whose id is in `meant`.
Mask with_ids(const Image& image, const std::string& channel, const std::vector<bool>& meant) {
    const auto ids = image.channels.find(channel);
    if (ids == image.channels.end())
        throw Error("channel '" + channel + "' is missing; name an image that malus rendered");
    Mask mask(ids->second.size());
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const float id = ids->second[i];
        mask[i] =
            id > 0 && id < static_cast<float>(meant.size()) && meant[static_cast<std::size_t>(id)];
    }
    return mask;
}

const std::vector<std::string>& names(const Image& image, const std::string& attribute) {
    const std::vector<std::string>* known = list(image, attribute);
    if (!known)
        throw Error("the header has no list '" + attribute +
                    "'; name an image that malus rendered");
    return *known;
}

[[noreturn]] void unknown(const std::string& kind, const std::string& name,
                          const std::vector<std::string>& known) {
    throw Error("no " + kind + " '" + one_line(name) + "' in the image" +
                suggest(name, {known.begin() + (known.empty() ? 0 : 1), known.end()}));
}

}  // namespace

Mask surface_mask(const Image& image) {
    const auto coverage = image.channels.find("A");
    Mask mask(image.pixel_count(), 1);
    if (coverage != image.channels.end())
        for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = coverage->second[i] > 0;
    return mask;
}

Mask node_mask(const Image& image, const std::string& name) {
    const std::vector<std::string>& known = names(image, "nodeNames");
    const std::vector<std::size_t> parent = parents(image, known.size());
    std::vector<bool> meant(known.size());
    for (std::size_t i = 1; i < known.size(); ++i) {
        std::size_t at = i;
        // As many steps as there are nodes, lest a damaged header lead in circles.
        for (std::size_t step = 0; at > 0 && !meant[i] && step < known.size(); ++step) {
            meant[i] = known[at] == name;
            at = parent[at];
        }
    }
    if (std::find(meant.begin(), meant.end(), true) == meant.end()) unknown("node", name, known);
    return with_ids(image, "node.id", meant);
}

Mask material_mask(const Image& image, const std::string& name) {
    const std::vector<std::string>& known = names(image, "materialNames");
    std::vector<bool> meant(known.size());
    for (std::size_t i = 1; i < known.size(); ++i) meant[i] = known[i] == name;
    if (std::find(meant.begin(), meant.end(), true) == meant.end())
        unknown("material", name, known);
    return with_ids(image, "material.id", meant);
}

Mask ring_around(const Mask& inner, int width, int height, double from, double to) {
    const auto at = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    };
    // Squared distance to the nearest pixel of `inner` in its own row, then over the rows.
    std::vector<double> in_row(inner.size(), HUGE_VAL);
    for (int y = 0; y < height; ++y) {
        int last = -1;
        const auto sweep = [&](int x) {
            if (inner[at(x, y)]) last = x;
            if (last >= 0)
                in_row[at(x, y)] = std::min(in_row[at(x, y)], double(x - last) * (x - last));
        };
        for (int x = 0; x < width; ++x) sweep(x);
        last = -1;
        for (int x = width - 1; x >= 0; --x) sweep(x);
    }
    const int reach = static_cast<int>(std::min<double>(std::floor(to), height));
    Mask ring(inner.size());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            double nearest = HUGE_VAL;
            for (int v = std::max(0, y - reach); v <= std::min(height - 1, y + reach); ++v)
                nearest = std::min(nearest, in_row[at(x, v)] + double(v - y) * (v - y));
            ring[at(x, y)] = !inner[at(x, y)] && nearest > from * from && nearest <= to * to;
        }
    return ring;
}

Mask both(const Mask& a, const Mask& b) {
    Mask result(a);
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = a[i] && b[i];
    return result;
}

Mask without(const Mask& a, const Mask& b) {
    Mask result(a);
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = a[i] && !b[i];
    return result;
}

std::size_t count(const Mask& mask) {
    return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), 1));
}

}  // namespace malus
