// sky_grid.cpp — keys of nodes and cells.
// SPDX-License-Identifier: Apache-2.0
#include "render/sky_grid.h"

#include <algorithm>
#include <bit>

namespace malus {
namespace {

constexpr double kSpacing = 0.6;      // of nodes, in the paint's least RMS slope
constexpr double kWidest = 0.12;      // rad
constexpr double kWidestTilt = 0.05;  // rad, between normals
constexpr double kViews = 0.07;       // rad, between views of what is no face
constexpr double kNarrowest = 0.003;  // rad; sharper paints have no nodes
constexpr double kFlattest = 0.35;    // of cosθo: nodes lie no farther apart
constexpr int kLevels = 4;            // of spacings, each half of the one before
constexpr double kGrazing = 0.005;    // cosθo: nodes are not seen flatter
// What interpolation is off by, of S0: the most that `Sky table: between nodes …` finds, and a little
// more: on faces, and elsewhere.
constexpr double kFaceError = 1.5e-4, kBentError = 3e-4;
constexpr std::uint32_t kFace = 64;  // pixels that show the same normal,
constexpr int kRun = 4;              // and that many beside each other, to be counted
constexpr std::size_t kMostFaces = 2048;
constexpr int kMiddle = 2048;     // of a number in a key
constexpr unsigned kFewest = 12;  // normals of a ring but the first

// Weights of a polynomial through nodes −1, 0, 1, 2 at t.
std::array<double, 4> cubic(double t) {
    return {t * (t - 1) * (2 - t) / 6, (t + 1) * (t - 1) * (t - 2) / 2, (t + 1) * t * (2 - t) / 2,
            (t + 1) * t * (t - 1) / 6};
}
// Through nodes −1, 0, 1.
std::array<double, 3> quadratic(double t) {
    return {t * (t - 1) / 2, 1 - t * t, t * (t + 1) / 2};
}

// How many normals a ring has: each a multiple of the ones before.
int normals_of(int ring, double step) {
    if (ring == 0) return 1;
    const double around = 2 * kPi * std::min(ring * step, 1.0) / step;
    return static_cast<int>(kFewest *
                            std::bit_ceil(static_cast<unsigned>(std::ceil(around / kFewest))));
}

}  // namespace

// What is packed into a key. A cell has the column and row after its first ones; the column of what is no
// face is one of its last ring.
struct SkyGrid::Fields {
    bool face;
    int level, view_level;  // halvings of the spacing, and between views
    int id;                 // of the face or the paint
    int column, row;        // in the face; or normal and ring
    int view_x, view_y;

    bool fits() const {
        const auto fit = [](int i) { return i > 8 - kMiddle && i < kMiddle - 8; };
        return fit(column) && fit(row) && fit(view_x) && fit(view_y);
    }
    int last_ring() const { return row + 2; }
};

SkyGrid::Key SkyGrid::packed(const Fields& f) {
    Key key = f.face ? 1 : 0;
    key = key << 2 | static_cast<Key>(f.level);
    key = key << 2 | static_cast<Key>(f.view_level);
    key = key << 11 | static_cast<Key>(f.id);
    for (int i : {f.column, f.row, f.view_x, f.view_y})
        key = key << 12 | static_cast<Key>(i + kMiddle);
    return key;
}

SkyGrid::Fields SkyGrid::unpacked(Key key) {
    const auto number = [&](int at) { return static_cast<int>(key >> at & 0xfff) - kMiddle; };
    return {(key >> 63) != 0,
            static_cast<int>(key >> 61 & 3),
            static_cast<int>(key >> 59 & 3),
            static_cast<int>(key >> 48 & 0x7ff),
            number(36),
            number(24),
            number(12),
            number(0)};
}

SkyGrid::SkyGrid(const PreparedScene::Impl& scene, const Camera& camera,
                 const RenderSettings& settings)
    : scene_(scene),
      camera_(camera),
      picture_(camera, settings.width, settings.height),
      angle_(picture_.pixel_angle()),
      example_(scene.surfaces.size(), -1) {
    for (const Surface& surface : scene.surfaces) {
        const double spacing = std::min(kWidest, kSpacing * surface.sharpest_slope());
        spacing_.push_back(spacing < kNarrowest || surface.directions().black() ? 0 : spacing);
    }
}

// A paint, and a normal to 1e-5.
SkyGrid::Key SkyGrid::face_key(int paint, const Vec3& n) {
    Key key = static_cast<Key>(paint);
    for (double x : {n.x, n.y, n.z})
        key = key << 18 | static_cast<Key>(std::lround(1e5 * x) + (1 << 17));
    return key;
}

void SkyGrid::look(int instance, const Vec3& n) {
    const int paint = scene_.paints[static_cast<std::size_t>(instance)];
    example_[static_cast<std::size_t>(paint)] = instance;
    const Key key = face_key(paint, n);
    run_ = key == run_key_ ? run_ + 1 : 1;
    run_key_ = key;
    if (run_ < kRun) return;
    FaceCount& count = face_index_[key];
    const std::uint32_t before = count.pixels;
    count.pixels += run_ == kRun ? kRun : 1;
    if (before >= kFace || count.pixels < kFace) return;
    if (faces_.size() == kMostFaces) {
        count.pixels = 0;
        return;
    }
    count.id = static_cast<int>(faces_.size());
    faces_.push_back({paint, n});
}

int SkyGrid::face_of(int paint, const Vec3& n, Key near) const {
    if (near != kNone && of_face(near)) {
        const int id = unpacked(near).id;
        const Face& face = faces_[static_cast<std::size_t>(id)];
        const Vec3 off = face.n - n;
        if (face.paint == paint && dot(off, off) < sqr(1e-7)) return id;
    }
    const auto found = face_index_.find(face_key(paint, n));
    return found == face_index_.end() ? -1 : found->second.id;
}

int SkyGrid::paint_of(const Fields& f) const {
    return f.face ? faces_[static_cast<std::size_t>(f.id)].paint : f.id;
}

// From node to node: an angle in the picture, or between normals.
double SkyGrid::step(const Fields& f) const {
    const double widest = spacing_[static_cast<std::size_t>(paint_of(f))];
    return std::ldexp(f.face ? widest : std::min(kWidestTilt, widest / 2), -f.level);
}

// An angle as a way in the picture; without end where all rays are parallel.
double SkyGrid::pixels(double angle) const {
    return angle_ > 0 ? angle / angle_ : HUGE_VAL;
}

double SkyGrid::view_width(const Fields& f) const {
    return pixels(std::ldexp(kViews, -f.view_level));
}

SkyGrid::Place SkyGrid::place(int pixel_x, int pixel_y, double x, double y, int instance,
                              const Vec3& n, const Vec3& wo, Key near) const {
    const int paint = scene_.paints[static_cast<std::size_t>(instance)];
    const double cos_o = dot(n, wo), widest = spacing_[static_cast<std::size_t>(paint)];
    if (widest == 0 || cos_o <= 0) return {};
    const auto level_of = [&](double spacing) {
        int level = 0;
        while (level < kLevels && std::ldexp(spacing, -level) > kFlattest * cos_o) ++level;
        return level;
    };
    const int face = face_of(paint, n, near);
    Fields f{face >= 0, level_of(widest), 0, face >= 0 ? face : paint, 0, 0, 0, 0};
    if (!f.face) f.view_level = level_of(kViews);
    if (std::max(f.level, f.view_level) == kLevels) return {};

    const double h = step(f);
    double column, row;
    if (f.face) {
        column = x / pixels(h), row = y / pixels(h);
        f.row = static_cast<int>(std::floor(row));
    } else {
        row = 2 * std::asin(std::sqrt(0.5 * std::max(0.0, 1 - n.y))) / h;
        f.row = std::max(1, static_cast<int>(row));
        const double azimuth = std::atan2(n.z, n.x) / (2 * kPi);
        column = (azimuth - std::floor(azimuth)) * normals_of(f.last_ring(), h);
        f.view_x = static_cast<int>(std::lround((pixel_x + 0.5) / view_width(f)));
        f.view_y = static_cast<int>(std::lround((pixel_y + 0.5) / view_width(f)));
    }
    f.column = static_cast<int>(std::floor(column));
    if (!f.fits()) return {};

    Place place;
    place.cell = packed(f);
    const std::array<double, 4> rows = cubic(row - f.row);
    std::array<double, 4> columns = cubic(column - f.column);
    for (int i = 0; i < 4; ++i) {
        if (!f.face) {
            const int each = normals_of(f.last_ring(), h) / normals_of(f.row - 1 + i, h);
            columns = cubic(column / each - f.column / each);
        }
        for (int j = 0; j < 4; ++j)
            place.weight[static_cast<std::size_t>(4 * i + j)] = static_cast<float>(
                rows[static_cast<std::size_t>(i)] * columns[static_cast<std::size_t>(j)] / cos_o);
    }
    return place;
}

bool SkyGrid::of_face(Key cell) const {
    return unpacked(cell).face;
}

int SkyGrid::group(Key cell) const {
    const Fields f = unpacked(cell);
    return f.face ? f.id : -1 - f.id;
}

double SkyGrid::error(Key cell) const {
    if (cell == kNone || !of_face(cell)) return kBentError;
    return angle_ > 0 ? kFaceError : 0;  // all views are the node's
}

std::vector<SkyGrid::Key> SkyGrid::nodes_of(Key cell) const {
    const Fields first = unpacked(cell);
    const double h = step(first);
    std::vector<Key> nodes;
    const int reach = first.face || angle_ == 0 ? 0 : 1;
    for (int view_y = -reach; view_y <= reach; ++view_y)
        for (int view_x = -reach; view_x <= reach; ++view_x)
            for (int row = -1; row <= 2; ++row)
                for (int column = -1; column <= 2; ++column) {
                    Fields node = first;
                    if (!first.face) {
                        node.row += row;
                        const int count = normals_of(node.row, h);
                        const int each = normals_of(first.last_ring(), h) / count;
                        node.column = (first.column / each + column + count) % count;
                    } else if (angle_ > 0) {  // else all views are the same
                        node.column += column, node.row += row;
                    }
                    node.view_x += view_x, node.view_y += view_y;
                    nodes.push_back(packed(node));
                }
    return nodes;
}

std::optional<SkyNode> SkyGrid::node_at(Key key) const {
    const Fields f = unpacked(key);
    const double h = step(f);
    const auto at = [&](int i, double width) { return angle_ > 0 ? i * width : 0.0; };
    const Vec3 wo =
        -(f.face ? picture_.ray(at(f.column, pixels(h)), at(f.row, pixels(h)))
                 : picture_.ray(at(f.view_x, view_width(f)), at(f.view_y, view_width(f))))
             .direction;
    SkyNode node{
        example_[static_cast<std::size_t>(paint_of(f))], {}, wo, image_frame(camera_, wo), 0};
    if (f.face) {
        node.n = faces_[static_cast<std::size_t>(f.id)].n;
    } else {
        const double azimuth = 2 * kPi * f.column / normals_of(f.row, h), tilt = f.row * h;
        if (tilt > kPi) return {};
        const double level = std::sin(tilt);
        node.n = {level * std::cos(azimuth), std::cos(tilt), level * std::sin(azimuth)};
    }
    node.cos_o = dot(node.n, wo);
    if (node.cos_o < kGrazing) return {};
    return node;
}

std::array<float, 9> SkyGrid::view_weights(Key cell, int pixel_x, int pixel_y) const {
    const double width = view_width(unpacked(cell));
    const double x = (pixel_x + 0.5) / width, y = (pixel_y + 0.5) / width;
    const auto u = quadratic(x - std::round(x)), v = quadratic(y - std::round(y));
    std::array<float, 9> weights;
    for (std::size_t i = 0; i < 9; ++i) weights[i] = static_cast<float>(u[i % 3] * v[i / 3]);
    return weights;
}

}  // namespace malus
