// sky_grid.h — nodes between which the light of the open sky is interpolated.
//
// Of a face, whose normal many pixels share, nodes are points of the picture. Elsewhere they are points of
// the picture and normals, on rings around the zenith:
//   tilt = i h,  azimuth = 2π j / N_i,  N_i = 12·2^k, the least with 2π min(tilt, 1)/N_i ≤ h
// Light times cosθo is smooth in both, but where a normal is upright: however it tilts, its plane
// cuts a lune off the sky, and light falls as the tilt grows. So ring 0 is one node, and no polynomial
// goes across it. Along and between rings, and in the picture of a face, they are cubic, 4 × 4 nodes;
// between views of what is no face quadratic, 3 × 3.
// Nodes lie a part of the paint's least RMS slope apart, which is by how much lobes smooth the sky (half of
// that between normals, by twice of which light turns), and nearer where a surface is seen flat.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "render/prepared_scene.h"

namespace malus {

/// A geometry of which the light of the open sky is known.
struct SkyNode {
    int instance;  ///< one with its paint
    Vec3 n, wo;
    BeamFrame toward;  ///< image frame of the beam along −wo
    double cos_o;
};

class SkyGrid {
  public:
    using Key = std::uint64_t;  ///< of a node, or of a cell
    static constexpr Key kNone = ~Key{0};
    static constexpr std::size_t kCorners = 16;  ///< of a cell, [row][column]

    SkyGrid(const PreparedScene::Impl& scene, const Camera& camera, const RenderSettings& settings);

    /// The middle of a pixel shows this surface. Pixels in order; all, before anything else is asked.
    void look(int instance, const Vec3& n);

    struct Place {
        Key cell = kNone;
        std::array<float, kCorners>
            weight;  ///< of corners' light times cosθo: their sum is 1/cosθo
    };
    /// Of a surface with normal n seen from wo at (x, y) of the picture, in a pixel; most likely in `near`.
    Place place(int pixel_x, int pixel_y, double x, double y, int instance, const Vec3& n,
                const Vec3& wo, Key near) const;

    bool of_face(Key cell) const;
    int group(Key cell) const;  ///< of cells that may share nodes
    /// [view][row][column]: corners as seen from one view, or from 3 × 3.
    std::vector<Key> nodes_of(Key cell) const;
    /// None where nothing could be seen.
    std::optional<SkyNode> node_at(Key node) const;
    /// What nodes_of()'s views count in a pixel: 9 weights.
    std::array<float, 9> view_weights(Key cell, int pixel_x, int pixel_y) const;

    /// What interpolation in a cell may be off by, as a part of S0.
    double error(Key cell) const;

  private:
    struct Fields;
    struct Face {
        int paint;
        Vec3 n;
    };
    struct FaceCount {
        std::uint32_t pixels = 0;
        int id = -1;  // once it has enough
    };
    static Fields unpacked(Key key);
    static Key packed(const Fields& f);
    static Key face_key(int paint, const Vec3& n);
    int face_of(int paint, const Vec3& n, Key near) const;
    int paint_of(const Fields& f) const;
    double step(const Fields& f) const;
    double view_width(const Fields& f) const;
    double pixels(double angle) const;

    const PreparedScene::Impl& scene_;
    const Camera& camera_;
    Picture picture_;
    double angle_;  // between the rays of pixels beside each other, rad; 0: all rays are parallel
    std::vector<double> spacing_;  // of nodes, by paint, rad; 0: none
    std::vector<int> example_;     // an instance, by paint; −1: none is seen
    Key run_key_ = kNone;          // of the pixels looked at last
    int run_ = 0;
    std::unordered_map<Key, FaceCount> face_index_;
    std::vector<Face> faces_;
};

}  // namespace malus
