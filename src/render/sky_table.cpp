// sky_table.cpp — which nodes, and their sums.
// SPDX-License-Identifier: Apache-2.0
#include "render/sky_table.h"

#include <algorithm>
#include <bit>

namespace malus {
namespace {

constexpr double kWidth = 0.07;       // of a cell of normals, in the paint's least RMS slope
constexpr double kNarrow = 4;         // nor less than that many pixels' angles: T is shared
constexpr double kNarrowest = 0.003;  // rad; sharper paints have no nodes
constexpr double kWidest = 0.15;      // rad
// Of a cell in the picture, in that width. A turn of the view moves the mirror direction as half that
// turn of the normal does; wide lobes keep their directions (path_tracer.cpp) and want nearer nodes.
constexpr double kSharpAcross = 2, kWideAcross = 1.4;
constexpr std::uint32_t kFewest = 16;  // pixels of a node
constexpr double kSamples = 0.5;       // of T, for each sample of a node's pixels
constexpr double kLeast = 4;           // of T, for each sample of the pixel that wants most
constexpr double kFlat = 1e-3;         // rad that normals beside each other may differ by there
// Of a pixel, at the end of the round in which the last of them say what it needs.
constexpr std::uint32_t kEarly = 4;
constexpr double kGrazing = 0.02;  // cosθo: nodes seen flatter than that say little of others

// The sphere on a square [0,1]² (octahedral map), z toward its middle.
struct MapPoint {
    double x, y;
};
MapPoint octahedral(const Vec3& v) {
    const double norm = std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
    const double x = v.x / norm, y = v.y / norm;
    if (v.z >= 0) return {0.5 * (1 + x), 0.5 * (1 + y)};
    return {0.5 * (1 + std::copysign(1 - std::abs(y), x)),
            0.5 * (1 + std::copysign(1 - std::abs(x), y))};
}

// What a step to the next cell of the picture adds to a key.
constexpr std::array<int, 2> kAxisShift{36, 24};

bool is_flat(const Vec3& n, const Vec3& beside) {
    const Vec3 step = n - beside;
    return dot(step, step) < sqr(kFlat);
}

// Angle between the rays of two pixels beside each other, rad; 0: all rays are parallel.
double pixel_angle(const Camera& camera, int height) {
    if (camera.projection == Projection::kOrthographic) return 0;
    return 2 * std::tan(0.5 * camera.yfov) / height;
}

}  // namespace

SkyTable::SkyTable(const PreparedScene::Impl& scene, const Camera& camera,
                   const RenderSettings& settings)
    : scene_(scene),
      camera_(camera),
      picture_(camera, settings.width, settings.height),
      width_(settings.width),
      replicates_(settings.replicates),
      row_(4 * scene.wavelengths_nm.size()),
      seen_(static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height),
            -1) {
    const double angle = pixel_angle(camera, settings.height);
    for (const Surface& surface : scene.surfaces) {
        const double slope = surface.sharpest_slope();
        const double width = std::min(kWidest, std::max(kWidth * slope, kNarrow * angle));
        Cells cells;
        if (width >= kNarrowest && width < slope && !surface.directions().black()) {
            cells.normals = std::sqrt(4 * kPi) / width;
            const double across = (surface.sharp() ? kSharpAcross : kWideAcross) * width;
            cells.pixels = angle > 0 ? std::max(1.0, across / angle) : HUGE_VAL;
        }
        cells_.push_back(cells);
    }
}

SkyTable::Key SkyTable::key(int pixel_x, int pixel_y, int instance, const Vec3& n) const {
    const auto paint = static_cast<std::size_t>(scene_.paints[static_cast<std::size_t>(instance)]);
    const Cells& cells = cells_[paint];
    if (cells.normals == 0) return kNone;
    const MapPoint p =
        octahedral({dot(n, camera_.right), dot(n, camera_.up), -dot(n, camera_.forward)});
    // Off the middle by odd parts, so that what is level or faces the camera is on no edge.
    const auto cell = [](double x) { return static_cast<Key>(x) & 0xfff; };
    const auto at = [&](int pixel) {
        return cells.pixels == HUGE_VAL ? Key{0} : cell((pixel + 0.5) / cells.pixels);
    };
    return (static_cast<Key>(paint) << 48) | (at(pixel_x) << kAxisShift[0]) |
           (at(pixel_y) << kAxisShift[1]) | (cell(p.x * cells.normals + 0.37) << 12) |
           cell(p.y * cells.normals + 0.41);
}

std::optional<SkyNode> SkyTable::node_of(int pixel_x, int pixel_y, int instance,
                                         const Vec3& n) const {
    const auto paint = static_cast<std::size_t>(scene_.paints[static_cast<std::size_t>(instance)]);
    const double cell = cells_[paint].pixels;
    const auto middle = [&](int pixel) {
        return cell == HUGE_VAL ? 0 : (std::floor((pixel + 0.5) / cell) + 0.5) * cell;
    };
    const Vec3 k = picture_.ray(middle(pixel_x), middle(pixel_y)).direction;
    if (dot(n, -k) < kGrazing) return {};
    return SkyNode{instance, n, -k, image_frame(camera_, -k), dot(n, -k)};
}

void SkyTable::look(int pixel_x, int pixel_y, int instance, const Vec3& n) {
    const Key k = key(pixel_x, pixel_y, instance, n);
    if (k == kNone) return;
    const auto [found, is_new] = index_.try_emplace(k, static_cast<int>(nodes_.size()));
    if (is_new) {
        const std::optional<SkyNode> node = node_of(pixel_x, pixel_y, instance, n);
        if (!node) {
            index_.erase(found);
            return;
        }
        nodes_.push_back(*node);
        keys_.push_back(k);
    }
    seen_[pixel(pixel_x, pixel_y)] = found->second;
}

void SkyTable::settle() {
    std::vector<std::uint32_t> pixels(nodes_.size(), 0);
    for (int i : seen_)
        if (i >= 0) ++pixels[static_cast<std::size_t>(i)];
    std::vector<int> place(nodes_.size(), -1);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (pixels[i] < kFewest) continue;
        place[i] = static_cast<int>(kept);
        nodes_[kept] = nodes_[i];
        keys_[kept++] = keys_[i];
    }
    nodes_.resize(kept);
    keys_.resize(kept);
    for (int& i : seen_)
        if (i >= 0) i = place[static_cast<std::size_t>(i)];
    index_.clear();
    for (std::size_t i = 0; i < kept; ++i) index_.emplace(keys_[i], static_cast<int>(i));
    neighbours_.resize(kept);
    for (std::size_t i = 0; i < kept; ++i) find_neighbours(i);
    sums_.resize(kept * replicates_ * row_);
    means_.resize(kept * replicates_ * row_);
    samples_.resize(kept);
}

// None of sharp paint: with directions that turn with the node little is left to gain, and three nodes
// cost more than that.
void SkyTable::find_neighbours(std::size_t node) {
    neighbours_[node] = {{{-1, -1}, {-1, -1}}};
    if (scene_.surface_of(nodes_[node].instance).sharp()) return;
    for (std::size_t axis = 0; axis < 2; ++axis)
        for (std::size_t side = 0; side < 2; ++side) {
            const Key step = Key{1} << kAxisShift[axis];
            const auto found = index_.find(side == 0 ? keys_[node] - step : keys_[node] + step);
            const bool goes_on =
                found != index_.end() &&
                is_flat(nodes_[static_cast<std::size_t>(found->second)].n, nodes_[node].n);
            neighbours_[node][axis][side] = goes_on ? found->second : -1;
        }
}

NodeShares SkyTable::find(int pixel_x, int pixel_y, int instance, const Vec3& n,
                          bool linear) const {
    NodeShares shares;
    const Key k = key(pixel_x, pixel_y, instance, n);
    if (k == kNone) return shares;
    int own = seen_[pixel(pixel_x, pixel_y)];
    if (own < 0 || keys_[static_cast<std::size_t>(own)] != k) {
        const auto found = index_.find(k);
        if (found == index_.end()) return shares;
        own = found->second;
    }
    shares.node[0] = own;
    const double width =
        cells_[static_cast<std::size_t>(scene_.paints[static_cast<std::size_t>(instance)])].pixels;
    if (!linear || width == HUGE_VAL || !is_flat(node(own).n, n)) return shares;
    // The neighbour on the pixel's side of the cell's middle, or else that on the other side.
    const std::array<double, 2> place{(pixel_x + 0.5) / width, (pixel_y + 0.5) / width};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const auto& neighbours = neighbours_[static_cast<std::size_t>(own)][axis];
        const double off = place[axis] - std::floor(place[axis]) - 0.5;
        const std::size_t near = off > 0 ? 1 : 0, side = neighbours[near] >= 0 ? near : 1 - near;
        if (neighbours[side] < 0) continue;
        shares.node[axis + 1] = neighbours[side];
        shares.weight[axis + 1] = side == 1 ? off : -off;
        shares.weight[0] -= shares.weight[axis + 1];
    }
    return shares;
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
    std::vector<double> pixels(nodes_.size(), 0.0), sum = pixels, most = pixels;
    for (std::size_t pixel = 0; pixel < seen_.size(); ++pixel) {
        if (seen_[pixel] < 0) continue;
        const auto i = static_cast<std::size_t>(seen_[pixel]);
        pixels[i] += 1;
        if (!needs(exposure, pixel)) continue;
        const double wanted = std::bit_ceil(exposure.wanted[pixel]);
        sum[i] += wanted;
        most[i] = std::max(most[i], wanted);
    }
    std::vector<std::uint32_t> goals;
    for (std::size_t i = 0; i < sum.size(); ++i)
        goals.push_back(std::bit_floor(static_cast<std::uint32_t>(std::min(
            0x1p31, std::max({kSamples * pixels[i], kSamples * sum[i], kLeast * most[i]})))));
    return goals;
}

void SkyTable::add(std::size_t node, std::size_t replicate, const float* C, std::size_t step) {
    double* sums = &sums_[node * replicates_ * row_ + replicate];
    for (std::size_t i = 0; i < row_; ++i)
        sums[i * replicates_] += static_cast<double>(C[i * step]);
}

void SkyTable::develop(std::size_t node) {
    const std::size_t numbers = replicates_ * row_;
    for (std::size_t i = node * numbers; i < (node + 1) * numbers; ++i)
        means_[i] = static_cast<float>(sums_[i] / samples_[node]);
}

}  // namespace malus
