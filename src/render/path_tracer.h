// path_tracer.h — one path of light: traced once, then shaded for all wavelengths.
//
//   L_o(wo) = ∫ f(wi,wo) L_i(wi) cosθi dωi,  L_i the sky's light where nothing is hit, else what
//   the surface met reflects.
//
// Trace   from the detector into the scene. Each vertex draws one direction by the sky's
//         brightness, one to the sun's disc if there is one, and one by the surface's lobes. Light
//         that two of them find is weighed by the balance heuristic (Veach & Guibas 1995):
//         cosθi / (p_sky + p_surface), cosθi / (p_sun + p_surface). The last direction also leads
//         on to the next vertex, with weight cosθi / p_surface.
// Shade   from the far end back: S ← light of sky and sun + M·S, in vector registers over wavelength.
//         Turns between frames are two numbers a segment.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "malus/core/sampler.h"
#include "render/sky_table.h"

namespace malus {

/// One reflection at a vertex: from the light's frame through the facet to the next frame.
struct Bounce {
    Reflection geometry;
    Turn in, out;
    double weight = 0;  ///< sr; 0: no light this way
};

/// A surface met by the path.
struct Vertex {
    int instance;
    double distance;    ///< from the previous vertex, m
    Bounce sky_sample;  ///< direction drawn by the sky's brightness
    LightLookup sky_sample_light;
    Bounce sun_sample;         ///< direction to the sun's disc
    Bounce onward;             ///< direction drawn by the surface's lobes
    LightLookup onward_light;  ///< where it leads to the sky; weights 0 where it meets a surface
    double onward_sun = 0;  ///< weight of the sun's light there, in onward.weight; 0 off the disc
};

/// What the first vertex would reflect of an open sky at a node of the sky table.
struct OpenSky {
    int node = -1;     ///< −1: none
    double scale = 1;  ///< g of sky_table.h, in the weights of the bounces, too
    Bounce sky_sample, onward;
    LightLookup sky_sample_light, onward_light;
    bool sky_sample_seen = false, onward_seen = false;  ///< does the light reach the vertex?
};

enum class RayKind { kFirstHit, kAnyHit };
struct TracedRay {
    Ray ray;
    RayKind kind;
};

/// What a path needs to be shaded. Reused from path to path.
struct Path {
    std::vector<Vertex> vertices;  ///< from the detector on
    OpenSky open;
    SkyLookup sky;  ///< what the detector sees directly, if no vertex
    Turn sky_turn;
    bool sees_sun = false;                  ///< the sun's disc is there, too
    std::uint64_t rays = 0;                 ///< counted since the owner last set it to 0
    std::vector<TracedRay>* log = nullptr;  ///< where to keep each ray, for benchmarks

    void count(const Ray& ray, RayKind kind) {
        ++rays;
        if (log) log->push_back({ray, kind});
    }
};

class PathTracer {
  public:
    PathTracer(const PreparedScene::Impl& scene, const Camera& camera,
               const RenderSettings& settings);

    /// The path of `sample` through the box of pixel (pixel_x, pixel_y); with a table, what the open
    /// sky would bring, too.
    void trace(int pixel_x, int pixel_y, const Sampler& sampler, std::uint32_t sample, Path& path,
               const SkyTable* table = nullptr) const;
    /// Stokes vectors in the image frame: four rows of stride() floats, wavelength innermost.
    void shade(const Path& path, float* S) const;

    /// A sample of a node's open sky into path.open; no ray.
    void trace_open(const SkyNode& node, const Sampler& sampler, std::uint32_t sample,
                    Path& path) const;
    /// As shade(), of path.open (g C); in a fifth row S0 of what reaches the vertex.
    void shade_open(const Path& path, const SkyNode& node, float* C) const;

    /// The surface in the middle of a pixel.
    std::optional<Hit> look(int pixel_x, int pixel_y) const;
    std::size_t stride() const { return padded(scene_.wavelengths_nm.size()); }

  private:
    const SkyNode* find_open(const SkyTable& table, int pixel_x, int pixel_y, const Hit& hit,
                             const Vec3& wo, Path& path) const;
    void sample_sky(const Hit& hit, const Basis& basis, const Vec3& wo,
                    const DirectionSampler::View& lobes, const SamplePoint& u,
                    const BeamFrame& toward, const SkyNode* open, Path& path) const;
    void sample_sun(const Hit& hit, const Basis& basis, const Vec3& wo,
                    const DirectionSampler::View& lobes, const SamplePoint& u,
                    const BeamFrame& toward, Path& path) const;
    bool sees_sky(const Hit& hit, const Vec3& w, Path& path) const;
    double light_weight(double by_light, double by_surface, Lighting drawn_by) const;

    const PreparedScene::Impl& scene_;
    const Camera& camera_;
    Picture picture_;
    const RenderSettings& settings_;
};

}  // namespace malus
