// sky_table.cpp — which nodes, and their sums.
// SPDX-License-Identifier: Apache-2.0
#include "render/sky_table.h"

#include <algorithm>
#include <bit>
#include <map>
#include <unordered_set>

namespace malus {
namespace {

// Pixels that a group has for each node. Those of bent surfaces, of which a pixel needs many, serve
// others, too; with many wavelengths to read them all takes longer than to trace paths.
constexpr double kFacePixels = 4, kBentPixels = 1, kBentWavelengths = 8;
constexpr double kMostMemory = 0x1p28;  // bytes, of a group's nodes
constexpr double kSamples = 1;          // of T, for each sample of the pixels
constexpr double kLeast = 1;            // of T, for each sample of the pixel that wants most
// Of a pixel, at the end of the round in which the last of them say what it needs.
constexpr std::uint32_t kEarly = 4;

}  // namespace

SkyTable::SkyTable(const PreparedScene::Impl& scene, const Camera& camera,
                   const RenderSettings& settings)
    : grid_(scene, camera, settings),
      picture_(camera, settings.width, settings.height),
      width_(settings.width),
      replicates_(settings.replicates),
      row_(4 * scene.wavelengths_nm.size()) {
    const std::size_t pixels =
        static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height);
    seen_.assign(pixels, -1);
    looks_.resize(pixels);
}

void SkyTable::look(int pixel_x, int pixel_y, int instance, const Vec3& n) {
    looks_[pixel(pixel_x, pixel_y)] = {instance, Vec3f(n)};
    grid_.look(instance, n);
}

void SkyTable::settle() {
    // Cells in the order in which pixels show them.
    std::map<int, std::vector<CellCount>> groups;
    std::unordered_map<Key, std::size_t> known;  // place in its group
    std::vector<Key> keys(looks_.size(), SkyGrid::kNone);
    for (std::size_t i = 0; i < looks_.size(); ++i) {
        const auto& [instance, normal] = looks_[i];
        if (instance < 0) continue;
        const int x = static_cast<int>(i) % width_, y = static_cast<int>(i) / width_;
        const Vec3 wo = -picture_.ray(x + 0.5, y + 0.5).direction;
        keys[i] = grid_
                      .place(x, y, x + 0.5, y + 0.5, instance, normalize(Vec3(normal)), wo,
                             SkyGrid::kNone)
                      .cell;
        if (keys[i] == SkyGrid::kNone) continue;
        std::vector<CellCount>& cells = groups[grid_.group(keys[i])];
        const auto [found, is_new] = known.try_emplace(keys[i], cells.size());
        if (is_new) cells.push_back({keys[i], 0});
        ++cells[found->second].pixels;
    }
    looks_ = {};
    std::unordered_map<Key, int> node_index;
    for (const auto& [group, cells] : groups)
        if (const auto fewest = fewest_pixels(cells))
            for (const CellCount& cell : cells)
                if (cell.pixels >= *fewest) add_cell(cell.key, node_index);
    for (std::size_t i = 0; i < keys.size(); ++i)
        if (const auto found = index_.find(keys[i]); found != index_.end())
            seen_[i] = found->second;
    sums_.resize(nodes_.size() * replicates_ * row_);
    means_.resize(sums_.size());
    samples_.resize(nodes_.size());
}

// How many pixels a cell of a group must have for their nodes to be worth their while; nothing where that
// will not do.
std::optional<std::uint32_t> SkyTable::fewest_pixels(const std::vector<CellCount>& cells) const {
    const double many = std::max(1.0, static_cast<double>(row_) / (4 * kBentWavelengths));
    const double pixels_per_node = grid_.of_face(cells[0].key) ? kFacePixels : kBentPixels * many;
    const double memory =
        kMostMemory / static_cast<double>(replicates_ * row_ * (sizeof(double) + sizeof(float)));
    for (std::uint32_t fewest = 1; fewest <= 64; fewest *= 4) {
        double shown = 0, count = 0;
        for (const CellCount& cell : cells)
            if (cell.pixels >= fewest) shown += cell.pixels, count += 1;
        const double most = std::min(shown / pixels_per_node, memory);
        if (count <= most && count_nodes(cells, fewest, most) <= most)  // nor are nodes fewer
            return fewest;
    }
    return {};
}

// Of cells that so many pixels show; where it comes to more than `most`, somewhat more than that.
double SkyTable::count_nodes(const std::vector<CellCount>& cells, std::uint32_t fewest,
                             double most) const {
    std::unordered_set<Key> nodes;
    for (const CellCount& cell : cells) {
        if (cell.pixels < fewest) continue;
        for (Key node : grid_.nodes_of(cell.key)) nodes.insert(node);
        if (static_cast<double>(nodes.size()) > most) break;
    }
    return static_cast<double>(nodes.size());
}

// With its nodes, if all can be.
void SkyTable::add_cell(Key cell, std::unordered_map<Key, int>& node_index) {
    const std::vector<Key> keys = grid_.nodes_of(cell);
    std::vector<int> corners;
    for (Key key : keys) {
        const auto found = node_index.find(key);
        const std::optional<SkyNode> node =
            found == node_index.end() ? grid_.node_at(key) : std::nullopt;
        if (found == node_index.end() && !node) return;
        corners.push_back(found == node_index.end() ? static_cast<int>(nodes_.size())
                                                    : found->second);
        if (!node) continue;
        node_index.emplace(key, corners.back());
        nodes_.push_back(*node);
    }
    index_.emplace(cell, static_cast<int>(cells_.size()));
    cells_.push_back({cell, cell_nodes_.size(), corners.size()});
    cell_nodes_.insert(cell_nodes_.end(), corners.begin(), corners.end());
}

SkyTable::Key SkyTable::key_at(int pixel_x, int pixel_y) const {
    const int cell = seen_[pixel(pixel_x, pixel_y)];
    return cell < 0 ? SkyGrid::kNone : cells_[static_cast<std::size_t>(cell)].key;
}

double SkyTable::error(int pixel_x, int pixel_y) const {
    return grid_.error(key_at(pixel_x, pixel_y));
}

SkySpot SkyTable::find(int pixel_x, int pixel_y, double x, double y, int instance, const Vec3& n,
                       const Vec3& wo) const {
    const Key near = key_at(pixel_x, pixel_y);
    const SkyGrid::Place at = grid_.place(pixel_x, pixel_y, x, y, instance, n, wo, near);
    if (at.cell == SkyGrid::kNone) return {};
    if (at.cell == near) return {seen_[pixel(pixel_x, pixel_y)], at.weight};
    const auto found = index_.find(at.cell);
    return found == index_.end() ? SkySpot{} : SkySpot{found->second, at.weight};
}

SkyTable::Corners SkyTable::corners(int cell, int pixel_x, int pixel_y,
                                    std::vector<float>& space) const {
    const Cell& of = cells_[static_cast<std::size_t>(cell)];
    const std::size_t numbers = replicates_ * row_;
    const auto mean = [&](std::size_t i) {
        return &means_[static_cast<std::size_t>(cell_nodes_[of.first + i]) * numbers];
    };
    Corners corners;
    if (of.count == kCorners) {
        for (std::size_t i = 0; i < kCorners; ++i) corners[i] = mean(i);
        return corners;
    }
    const std::array<float, 9> weights = grid_.view_weights(of.key, pixel_x, pixel_y);
    space.assign(corners.size() * numbers, 0.f);
    for (std::size_t view = 0; view < weights.size(); ++view) {
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const float* from = mean(view * corners.size() + i);
            float* to = &space[i * numbers];
            for (std::size_t j = 0; j < numbers; ++j) to[j] += weights[view] * from[j];
        }
    }
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = &space[i * numbers];
    return corners;
}

// Do samples of the pixel use T, as its first ones found before this round?
bool SkyTable::needs(const Exposure& exposure, std::size_t pixel) const {
    const std::size_t shares = replicates_ * exposure.wavelengths_nm.size();
    const auto first = exposure.open.begin() + static_cast<std::ptrdiff_t>(pixel * shares);
    // What a later sample than the first found may be of this round.
    const bool early = exposure.wanted[pixel] <= kEarly;
    return std::any_of(first, first + static_cast<std::ptrdiff_t>(shares),
                       [early](std::uint8_t share) { return early ? share % 2 == 1 : share > 0; });
}

// Only ever more from round to round, and by the exposure alone: a render that goes on has the T of
// one that never stopped, wherever in a round it did. To the next power of two, since rounds are cut
// short by the samples asked for.
std::vector<std::uint32_t> SkyTable::goals(const Exposure& exposure) const {
    std::vector<double> pixels(cells_.size(), 0.0), sum = pixels, most = pixels;
    for (std::size_t pixel = 0; pixel < seen_.size(); ++pixel) {
        if (seen_[pixel] < 0) continue;
        const auto i = static_cast<std::size_t>(seen_[pixel]);
        pixels[i] += 1;
        if (!needs(exposure, pixel)) continue;
        const double wanted = std::bit_ceil(exposure.wanted[pixel]);
        sum[i] += wanted;
        most[i] = std::max(most[i], wanted);
    }
    std::vector<double> at_first(nodes_.size(), 0.0), whole = at_first, least = at_first;
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
        const Cell& of = cells_[cell];
        const double share = kSamples / static_cast<double>(of.count);
        for (std::size_t i = 0; i < of.count; ++i) {
            const auto node = static_cast<std::size_t>(cell_nodes_[of.first + i]);
            at_first[node] += share * pixels[cell], whole[node] += share * sum[cell];
            least[node] = std::max(least[node], kLeast * most[cell]);
        }
    }
    std::vector<std::uint32_t> goals;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
        goals.push_back(std::bit_floor(static_cast<std::uint32_t>(
            std::min(0x1p31, std::max({kLeast, at_first[i], whole[i], least[i]})))));
    return goals;
}

void SkyTable::add(std::size_t node, const float* C) {
    const std::size_t numbers = replicates_ * row_;
    double* sums = &sums_[node * numbers];
    for (std::size_t i = 0; i < numbers; ++i) sums[i] += static_cast<double>(C[i]);
    ++samples_[node];
}

void SkyTable::develop(std::size_t node) {
    const std::size_t numbers = replicates_ * row_;
    const double scale = nodes_[node].cos_o / samples_[node];
    for (std::size_t i = node * numbers; i < (node + 1) * numbers; ++i)
        means_[i] = static_cast<float>(scale * sums_[i]);
}

}  // namespace malus
