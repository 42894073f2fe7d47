// sky_table.h — the light of the open sky, known beside the paths.
//
//   ⟨X⟩ = ⟨X + α g (T − C)⟩
//   X   what a path brings
//   C = Σ f(n',wo',wi) L(wi) cosθi' / pdf(wi): what its first vertex would reflect, were nothing in
//       the sky's way, and normal and view those of a node nearby. Of the same directions where lobes
//       are wide, which keeps L; where they are sharp, of those that the same random numbers draw at
//       the node, which keeps f/pdf: the lobe's directions turn with it (reconnection and random
//       replay; Hua et al. 2019, A Survey on Gradient-Domain Rendering)
//   T = ∫ f(n',wo',wi) L(wi) cosθi' dωi: the mean of C, from many samples that trace no rays
//   g = cosθo'/cosθo: what a facet's foreshortening differs by
//   On flat surfaces of rough paint g T and g C are sums over nodes beside each other in the picture, with weights that
//   make them linear in the pixel's place there: what is left of X − C is of second order.
//   α   how much of C reaches the pixel, as the first samples of its other replicates found: 1 in
//       the open, where X and C hardly differ; 0 under cover
//
// No bias  ⟨T − C⟩ = 0 for whatever T's samples gave, at each node and with any weights that do not
//          depend on the directions drawn: each replicate has a T of its own, so that
//          the error of T, which pixels of a node share, is in the spread of the replicates.
// Nodes    one for each paint, cell of the picture and cell of normals (in the camera's frame) that
//          enough pixels look at; normal of the first of them, view of the cell's middle. Cells are
//          a part of the paint's least RMS slope wide: the nearer a node, the less X − C varies.
// Cost     T has in proportion to the samples of those pixels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// Nodes whose weighted sum stands for a pixel, the nearest first; −1: none. The weights add up to 1.
inline constexpr std::size_t kShares = 3;
struct NodeShares {
    std::array<int, kShares> node{-1, -1, -1};
    std::array<double, kShares> weight{1, 0, 0};
};

class SkyTable {
  public:
    SkyTable(const PreparedScene::Impl& scene, const Camera& camera,
             const RenderSettings& settings);

    /// The middle of a pixel shows this surface. Pixels in order, each once at most.
    void look(int pixel_x, int pixel_y, int instance, const Vec3& n);
    /// After all have been looked at: keeps the nodes of enough pixels.
    void settle();

    /// Has the middle of a pixel a node?
    bool knows(int pixel_x, int pixel_y) const { return seen_[pixel(pixel_x, pixel_y)] >= 0; }
    /// Without `linear` the nearest alone.
    NodeShares find(int pixel_x, int pixel_y, int instance, const Vec3& n, bool linear) const;
    const SkyNode& node(int index) const { return nodes_[static_cast<std::size_t>(index)]; }
    std::size_t node_count() const { return nodes_.size(); }

    /// Samples a replicate that T of each node should have, by what its pixels want; never 0.
    std::vector<std::uint32_t> goals(const Exposure& exposure) const;
    std::uint32_t samples(std::size_t node) const { return samples_[node]; }
    /// Adds a sample, [S0..S3][wavelength], its numbers `step` apart.
    void add(std::size_t node, std::size_t replicate, const float* C, std::size_t step);
    /// After a sample of each replicate.
    void end_sample(std::size_t node) { ++samples_[node]; }
    /// After samples were added: T is their mean.
    void develop(std::size_t node);
    /// T, in the frame `toward`: [S0..S3][wavelength][replicate].
    const float* mean(std::size_t node) const { return &means_[node * replicates_ * row_]; }

  private:
    // How a paint's nodes are dealt out; none where its lobes are too sharp.
    struct Cells {
        double pixels = 0;   // width in the picture
        double normals = 0;  // along a side of the octahedral map
    };
    // Nodes in the next cells of the picture, where a rough surface goes on flat: [axis][side], the first
    // side toward the origin; −1: none.
    using Neighbours = std::array<std::array<int, 2>, 2>;
    using Key = std::uint64_t;
    static constexpr Key kNone = ~Key{0};

    std::size_t pixel(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(x);
    }
    bool needs(const Exposure& exposure, std::size_t pixel) const;
    Key key(int pixel_x, int pixel_y, int instance, const Vec3& n) const;
    void find_neighbours(std::size_t node);
    std::optional<SkyNode> node_of(int pixel_x, int pixel_y, int instance, const Vec3& n) const;

    const PreparedScene::Impl& scene_;
    const Camera& camera_;
    Picture picture_;
    int width_;
    std::size_t replicates_, row_;
    std::vector<Cells> cells_;  // by paint
    std::unordered_map<Key, int> index_;
    std::vector<SkyNode> nodes_;
    std::vector<Key> keys_;               // of the nodes
    std::vector<Neighbours> neighbours_;  // the same
    std::vector<int> seen_;               // by pixel: its node
    std::vector<double> sums_;            // [node][S0..S3][wavelength][replicate]
    std::vector<float> means_;            // the same
    std::vector<std::uint32_t> samples_;  // [node], of each replicate
};

}  // namespace malus
