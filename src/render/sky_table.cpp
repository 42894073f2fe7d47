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
constexpr double kGrazing = 0.02;      // cosθo: nodes seen flatter than that say little of others

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
    return (static_cast<Key>(paint) << 48) | (at(pixel_x) << 36) | (at(pixel_y) << 24) |
           (cell(p.x * cells.normals + 0.37) << 12) | cell(p.y * cells.normals + 0.41);
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
    sums_.resize(kept * replicates_ * row_);
    means_.resize(kept * replicates_ * row_);
    samples_.resize(kept);
}

int SkyTable::find(int pixel_x, int pixel_y, int instance, const Vec3& n) const {
    const Key k = key(pixel_x, pixel_y, instance, n);
    if (k == kNone) return -1;
    const int usual = seen_[pixel(pixel_x, pixel_y)];
    if (usual >= 0 && keys_[static_cast<std::size_t>(usual)] == k) return usual;
    const auto found = index_.find(k);
    return found == index_.end() ? -1 : found->second;
}

// Do samples of the pixel use T, as its first ones found?
bool SkyTable::needs(const Exposure& exposure, std::size_t pixel) const {
    const std::size_t shares = replicates_ * exposure.wavelengths_nm.size();
    const auto first = exposure.open.begin() + static_cast<std::ptrdiff_t>(pixel * shares);
    return std::any_of(first, first + static_cast<std::ptrdiff_t>(shares),
                       [](std::uint8_t share) { return share > 0; });
}

// Only ever more from round to round, and by the exposure alone: a render that goes on has the T of
// one that never stopped. To the next power of two, since rounds are cut short by the samples asked
// for.
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
