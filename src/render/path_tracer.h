// path_tracer.h — paths of light of a pixel: traced side by side, then shaded for all wavelengths.
//
//   L_o(wo) = ∫ f(wi,wo) L_i(wi) cosθi dωi,  L_i the sky's light where nothing is hit, else what
//   the surface met reflects.
//
// Trace   from the detector into the scene. Each vertex draws one direction by the sky's
//         brightness, one to the sun's disc if there is one, and one by the surface's lobes. Light
//         that two of them find is weighed by the balance heuristic (Veach & Guibas 1995):
//         cosθi / (p_sky + p_surface), cosθi / (p_sun + p_surface). The last direction also leads
//         on to the next vertex, with weight cosθi / p_surface.
// Shade   from the far end back: S ← light of sky and sun + M·S.
//         Turns between frames are two numbers a segment.
// Side by side  kSide vertices of the same depth fill vector registers, a path a lane; their light, a
//         path and one of two wavelengths a lane. What a level's directions meet is packed anew for
//         the next, so that registers stay full though most paths end in the sky.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "render/points.h"
#include "render/sky_lights.h"
#include "render/sky_table.h"

namespace malus {

using Rays = RayOf<Reals>;
using BeamFrames = BeamFrameOf<Reals>;

/// Reflections at vertices: from the light's frames through the facets to the next frames. Nothing but
/// `lit` is set at first, nor read of lanes that are not lit: to clear it all takes 3 % of a render.
struct Bounces {
    Bounces() {}
    FacetGeometry<Lanes> facet;  ///< weight: sr; 0: no light this way
    TurnOf<Lanes> in, out;
    unsigned lit = 0;  ///< lanes with a weight
};

/// Surfaces met by paths, one a lane; lanes beyond the last path repeat the first. As with Bounces only
/// what says what there is to be read is set at first.
struct Vertices {
    Vertices() {}
    std::array<int, kSide> surface;  ///< index into the scene's
    Bounces sky_sample;              ///< directions drawn by the sky's brightness
    SkyLookups sky_sample_light;
    unsigned sky_sample_seen = 0;  ///< lanes whose light arrives; an open sky would light all
    Bounces sun_sample;            ///< directions to the sun's disc
    Bounces onward;                ///< directions drawn by the surfaces' lobes
    SkyLookups onward_light;       ///< where they meet the sky, or would
    unsigned onward_seen = 0;      ///< lanes where they meet it
    Lanes onward_sun;              ///< weight of the sun's light there, in onward.facet.weight
    unsigned meets_sun = 0;        ///< lanes with such a weight
    std::array<int, kSide> next;   ///< or the vertex of the next level they lead to; −1: none
    bool open = false;             ///< is it wanted, too, what an open sky would bring? Then:
    Bounces behind;                ///< onward, from the sky behind what is in its way
};

/// What the detector sees along rays, before any surface.
struct Views {
    SkyLookups sky;  ///< of the dome; black where a surface is
    TurnOf<Lanes> turn;
    unsigned surface;             ///< lanes that meet one
    unsigned sun;                 ///< lanes that see the disc
    std::array<int, kSide> next;  ///< the first vertex, −1: none
};

/// Floats of a block of light: `rows` of kSide, up to whole registers.
constexpr std::size_t block_size(std::size_t rows) {
    constexpr std::size_t kWhole = 2 * kSide;
    return (rows + kWhole - 1) / kWhole * kWhole * kSide;
}

enum class RayKind { kFirstHit, kAnyHit };
struct TracedRay {
    Ray ray;
    RayKind kind;
};

/// Paths of one pixel, `count` samples of each replicate, and their light. Reused from pixel to pixel.
class Paths {
  public:
    /// To begin with a pixel: the numbers of its replicates.
    void begin(std::span<const Sampler> samplers);

    std::size_t replicates() const { return samplers_.size(); }
    std::size_t size() const { return size_; }

    /// What path i met first: index into Scene::instances, −1 for the sky; and how far off, m.
    int instance(std::size_t i) const { return first_instance_[i]; }
    double distance(std::size_t i) const { return first_distance_[i]; }
    /// Stokes vectors of the paths of one sample (0: the first traced) in the image frame:
    /// [S0..S3][wavelength][replicate].
    void light(std::size_t sample, std::size_t wavelengths, float* S) const;

    /// Of path i, where an open sky is known: where in the table, and what its directions would bring of
    /// that sky, [S0..S3][wavelength], and S0 of what of it reaches the vertex, [wavelength], kSide apart.
    struct Open {
        const SkySpot* spot;  ///< null: none is known
        const float* light;
    };
    Open open(std::size_t i, std::size_t wavelengths) const;

    std::uint64_t rays = 0;                 ///< counted since the owner last set it to 0
    std::vector<TracedRay>* log = nullptr;  ///< where to keep each ray, for benchmarks

  private:
    friend class PathTracer;

    // A vertex to come.
    struct Arrival {
        Vec3 direction, toward_x;  // of the ray; reference axis in which light must leave
        Met met;
        std::uint32_t path;
    };
    // Of a path.
    struct Number {
        std::uint32_t replicate, sample;
    };
    // Vertices of one depth and what leaves them.
    struct Level {
        std::vector<Arrival> arrivals;
        std::vector<Vertices> vertices;
        std::vector<float> light;  // [vertices][S0..S3][wavelength][lane], padded
    };

    void start(std::uint32_t first, std::uint32_t count, std::size_t depths);
    Level& level(int depth) { return levels_[static_cast<std::size_t>(depth - 1)]; }
    std::array<int, kSide> arrive(int depth, unsigned hit,
                                  const std::array<std::uint32_t, kSide>& path,
                                  const Vec3s& direction, const Vec3s& toward_x,
                                  const std::array<Met, kSide>& met);
    const Scramble* scrambles(std::uint32_t block);
    PointPlaces places(const std::array<std::uint32_t, kSide>& path, std::uint32_t block);
    void count(const Rays& traced, unsigned active, RayKind kind);
    // [S0..S3][wavelength] of a vertex of a depth, kSide apart.
    const float* light_of(int depth, int place, std::size_t wavelengths) const;
    bool in_order(std::size_t first) const;
    bool knows_sky(std::size_t vertices) const;
    // Room for three blocks of light on its way to vertices.
    float* arriving(std::size_t block);

    std::vector<Sampler> samplers_;
    std::vector<std::uint32_t> blocks_;  // in use with this pixel
    std::vector<Scramble> scrambles_;    // [of blocks_][replicate]
    std::size_t size_ = 0;
    std::vector<Number> numbers_;                     // by path
    std::vector<int> first_vertex_, first_instance_;  // by path, −1: none
    std::vector<double> first_distance_;
    std::vector<std::array<double, 2>> place_;  // by path: in the picture
    std::vector<Views> views_;
    std::vector<float> view_light_;                  // as a level's, where the sky is seen
    std::vector<Level> levels_;                      // [depth − 1]
    std::vector<std::array<SkySpot, kSide>> spots_;  // [first vertices]; empty without a table
    std::vector<float> open_light_;  // [first vertices][S0..S3, seen][wavelength][lane], padded
    std::vector<float> arriving_;
};

/// What is known of the open sky around a pixel.
struct OpenView {
    const SkyTable* table = nullptr;     ///< null: nothing is wanted of it
    const SkyDensity* toward = nullptr;  ///< may draw the first vertices' light instead of the sky
};

class PathTracer {
  public:
    PathTracer(const PreparedScene::Impl& scene, const Camera& camera,
               const RenderSettings& settings);

    /// Samples [first, first + count) of each replicate through the box of pixel (pixel_x, pixel_y):
    /// path (sample − first) · replicates + replicate. With a table, what the open sky would bring,
    /// too.
    void trace(int pixel_x, int pixel_y, std::uint32_t first, std::uint32_t count, Paths& paths,
               const OpenView& open = {}) const;
    /// The light of traced paths.
    void shade(Paths& paths) const;

    /// One sample of each replicate of a node's open sky, as light() of paths; no ray.
    void sample_open(const SkyNode& node, std::uint32_t sample, Paths& paths) const;

    /// The surface in the middle of a pixel.
    std::optional<Hit> look(int pixel_x, int pixel_y) const;

  private:
    struct Meeting;
    void look_through(int pixel_x, int pixel_y, Paths& paths) const;
    Meeting meet(int depth, std::size_t first, Paths& paths) const;
    unsigned attenuated(const std::array<int, kSide>& surface) const;
    void draw(int depth, Meeting& at, Paths& paths, const SkyDensity& by_light,
              Vertices& vertices) const;
    void draw_by_surface(Meeting& at, const Reals& lobe, const Reals& u1, const Reals& u2) const;
    void sample_lights(Meeting& at, Paths& paths, Vertices& vertices) const;
    void go_on(int depth, Meeting& at, Paths& paths, Vertices& vertices) const;
    unsigned sees(const Meeting& at, const Vec3s& w, unsigned wanted, Company company,
                  Paths& paths) const;
    void find_spots(const Meeting& at, const SkyTable& table, int pixel_x, int pixel_y,
                    Paths& paths) const;
    Reals light_weight(const Reals& by_light, const Reals& by_surface, Lighting drawn_by) const;

    void shade_views(Paths& paths) const;
    void shade_level(int depth, Paths& paths) const;
    std::size_t pair_count() const { return pairs(scene_.wavelengths_nm.size()); }

    const PreparedScene::Impl& scene_;
    const Camera& camera_;
    Picture picture_;
    const RenderSettings& settings_;
};

}  // namespace malus
