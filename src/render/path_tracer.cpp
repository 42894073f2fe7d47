// path_tracer.cpp — the path loop, and its shading.
// SPDX-License-Identifier: Apache-2.0
#include "render/path_tracer.h"

namespace malus {
namespace {

// Which numbers of a block serve what.
enum Dimension { kSky1, kSky2, kSurface1, kSurface2, kLobe, kPixelX, kPixelY };
enum SunDimension { kSun1, kSun2 };
constexpr std::uint32_t kSunBlocks = 1u << 20;  // blocks of their own, beyond any path's vertices

// Rows of a SkyDome or a SkyEmitter.
template <class Rows>
Stokes<Lanes> sky_light(const Rows& sky, const SkyLookup& at, std::size_t first) {
    Stokes<Lanes> S{Lanes(0.f), Lanes(0.f), Lanes(0.f), Lanes(0.f)};
    for (std::size_t i = 0; i < 4; ++i) {
        const Lanes weight(at.weight[i]);
        const auto row = [&](int c) {
            return weight * Lanes::load_unaligned(sky.row(at.node[i], c) + first);
        };
        S = S + Stokes<Lanes>{row(0), row(1), row(2), row(3)};
    }
    return S;
}

Stokes<Lanes> sun_light(const SunDisc& sun, std::size_t first) {
    return {Lanes::load_unaligned(sun.radiance() + first), Lanes(0.f), Lanes(0.f), Lanes(0.f)};
}

bool is_sky(const SkyLookup& at) {
    return at.weight != std::array<float, 4>{};
}

// Light as a facet may meet it: rounding of the turns before must not take S0 below |S1|.
Stokes<Lanes> at_least_polarized(Stokes<Lanes> S) {
    S.s0 = max(S.s0, abs(S.s1));
    return S;
}

Stokes<Lanes> reflected(const Surface& surface, std::size_t first, const Bounce& bounce,
                        const Stokes<Lanes>& S) {
    const BrdfMueller<Lanes> f =
        eval(surface.lanes(first), surface.slopes(), surface.attenuation(), bounce.geometry);
    const Stokes<Lanes> in = at_least_polarized(turned(S, bounce.in));
    return turned(real<Lanes>(bounce.weight) * (f * in), bounce.out);
}

// Light from wi as a node reflects it; `weight` without the cosine. No light from below its plane.
Bounce open_bounce(const SkyNode& node, const Vec3& wi, double weight) {
    Bounce bounce;
    if (!(dot(wi, node.n) > 0) || wi.y < 0) return bounce;
    bounce.geometry = reflection(node.n, wi, node.wo);
    bounce.in = turn_between(fixed_frame(wi), bounce.geometry.in);
    bounce.out = turn_between(bounce.geometry.out, node.toward);
    bounce.weight = bounce.geometry.cos_i * weight;
    return bounce;
}

// Moves the origin of a ray from far away to where it enters the ball around the scene, in double:
// floats are too coarse for an origin at a satellite. Returns the way saved, m.
double approach(Ray& ray, double radius) {
    const double reach = 2 * radius, along = -dot(ray.origin, ray.direction);
    const double skipped = along - reach;
    if (skipped <= 0) return 0;
    ray.origin = ray.origin + skipped * ray.direction;
    return skipped;
}

}  // namespace

PathTracer::PathTracer(const PreparedScene::Impl& scene, const Camera& camera,
                       const RenderSettings& settings)
    : scene_(scene),
      camera_(camera),
      picture_(camera, settings.width, settings.height),
      settings_(settings) {}

// 1/pdf of a direction to sky or sun, as the balance heuristic weighs it.
double PathTracer::light_weight(double by_light, double by_surface, Lighting drawn_by) const {
    if (settings_.lighting == Lighting::kBoth) return 1 / (by_light + by_surface);
    if (settings_.lighting != drawn_by) return 0;
    return 1 / (drawn_by == Lighting::kLightSamples ? by_light : by_surface);
}

// The node whose open sky stands for the first vertex's, if there is one near enough.
const SkyNode* PathTracer::find_open(const SkyTable& table, int pixel_x, int pixel_y,
                                     const Hit& hit, const Vec3& wo, Path& path) const {
    constexpr double kFarthest = 3;  // between the foreshortenings, beyond which lobes differ, too
    const int index = table.find(pixel_x, pixel_y, hit.instance, hit.n);
    if (index < 0) return nullptr;
    const SkyNode& node = table.node(index);
    const double scale = node.cos_o / dot(hit.n, wo);
    if (scale > kFarthest || scale * kFarthest < 1) return nullptr;
    path.open = {};
    path.open.node = index;
    path.open.scale = scale;
    return &node;
}

std::optional<Hit> PathTracer::look(int pixel_x, int pixel_y) const {
    Ray ray = picture_.ray(pixel_x + 0.5, pixel_y + 0.5);
    ray.origin = ray.origin - scene_.accel.center();
    approach(ray, scene_.accel.radius());
    return scene_.accel.intersect(ray.origin, ray.direction);
}

void PathTracer::trace(int pixel_x, int pixel_y, const Sampler& sampler, std::uint32_t sample,
                       Path& path, const SkyTable* table) const {
    path.vertices.clear();
    path.open.node = -1;
    path.sees_sun = false;
    SamplePoint u = sampler.point(sample, 0);
    Ray ray = picture_.ray(pixel_x + u[kPixelX], pixel_y + u[kPixelY]);
    ray.origin = ray.origin - scene_.accel.center();
    const double skipped = approach(ray, scene_.accel.radius());
    // The frame in which light must leave the vertex: first the picture's, then the facet's.
    BeamFrame toward = image_frame(camera_, -ray.direction);

    path.count(ray, RayKind::kFirstHit);
    std::optional<Hit> hit = scene_.accel.intersect(ray.origin, ray.direction);
    if (!hit) {
        path.sky = scene_.sky.dome().locate(ray.direction);
        path.sky_turn = turn_between(fixed_frame(ray.direction), toward);
        path.sees_sun = scene_.sun.contains(ray.direction);
        return;
    }
    for (int depth = 1; hit; ++depth) {
        if (depth > 1) u = sampler.point(sample, static_cast<std::uint32_t>(depth - 1));
        const Surface& surface = scene_.surface_of(hit->instance);
        const Vec3 wo = -ray.direction;
        Vertex& vertex = path.vertices.emplace_back();
        vertex.instance = hit->instance;
        vertex.distance = hit->distance + (depth == 1 ? skipped : 0);
        if (surface.directions().black()) return;

        // Light from a direction drawn by the sky's brightness, and from the sun.
        const Basis basis(hit->n, wo);
        const DirectionSampler::View lobes(surface.directions(), basis.to_local(wo));
        const SkyNode* open =
            depth == 1 && table ? find_open(*table, pixel_x, pixel_y, *hit, wo, path) : nullptr;
        sample_sky(*hit, basis, wo, lobes, u, toward, open, path);
        if (scene_.sun.present()) {
            const std::uint32_t block = kSunBlocks + static_cast<std::uint32_t>(depth);
            sample_sun(*hit, basis, wo, lobes, sampler.point(sample, block), toward, path);
        }

        // A direction drawn by the surface's lobes; facets that point it underground reflect none.
        const Vec3 local = lobes.sample(u[kLobe], u[kSurface1], u[kSurface2]);
        const Vec3 wi = basis.to_world(local);
        if (!(local.z > 0)) return;
        const double pdf = lobes.pdf(local);
        if (!(pdf > 0)) return;
        if (open) {
            path.open.onward_light = scene_.sky.locate(wi);
            path.open.onward =
                open_bounce(*open, wi, path.open.scale / (path.open.onward_light.pdf + pdf));
        }
        if (!(dot(wi, hit->ng) > 0)) return;
        vertex.onward.geometry = reflection(hit->n, wi, wo);
        vertex.onward.out = turn_between(vertex.onward.geometry.out, toward);
        const double cos_i = vertex.onward.geometry.cos_i;

        // On the last bounce only the sky beyond matters.
        const bool last = depth == settings_.max_depth;
        if (last && wi.y < 0) return;
        ray = {Accel::leave(*hit, wi), wi};
        path.count(ray, last ? RayKind::kAnyHit : RayKind::kFirstHit);
        const bool blocked = last && scene_.accel.occluded(ray.origin, wi);
        hit = last ? std::nullopt : scene_.accel.intersect(ray.origin, wi);
        if (blocked) return;
        if (hit) {
            vertex.onward.weight = cos_i / pdf;
            toward = vertex.onward.geometry.in;
        } else {
            vertex.onward_light = open ? path.open.onward_light : scene_.sky.locate(wi);
            path.open.onward_seen |= depth == 1;
            vertex.onward.in = turn_between(fixed_frame(wi), vertex.onward.geometry.in);
            const double weight =
                light_weight(vertex.onward_light.pdf, pdf, Lighting::kSurfaceSamples);
            vertex.onward.weight = cos_i * weight;
            if (weight > 0 && scene_.sun.contains(wi))
                vertex.onward_sun =
                    light_weight(scene_.sun.pdf(), pdf, Lighting::kSurfaceSamples) / weight;
        }
    }
}

// Does light from w reach the hit?
bool PathTracer::sees_sky(const Hit& hit, const Vec3& w, Path& path) const {
    if (!(dot(w, hit.n) > 0) || !(dot(w, hit.ng) > 0)) return false;
    const Ray shadow{Accel::leave(hit, w), w};
    path.count(shadow, RayKind::kAnyHit);
    return !scene_.accel.occluded(shadow.origin, shadow.direction);
}

// Fills the last vertex's sky_sample if a direction drawn by the sky's brightness sees the sky.
void PathTracer::sample_sky(const Hit& hit, const Basis& basis, const Vec3& wo,
                            const DirectionSampler::View& lobes, const SamplePoint& u,
                            const BeamFrame& toward, const SkyNode* open, Path& path) const {
    const LightSample sky = scene_.sky.sample(u[kSky1], u[kSky2]);
    if (!(sky.light.pdf > 0)) return;
    const bool seen = sees_sky(hit, sky.w, path);
    if (!seen && !open) return;
    const double by_surface = lobes.pdf(basis.to_local(sky.w));
    if (open) {
        path.open.sky_sample_light = sky.light;
        path.open.sky_sample_seen = seen;
        path.open.sky_sample =
            open_bounce(*open, sky.w, path.open.scale / (sky.light.pdf + by_surface));
    }
    if (!seen) return;
    Vertex& vertex = path.vertices.back();
    Bounce& bounce = vertex.sky_sample;
    bounce.geometry = reflection(hit.n, sky.w, wo);
    bounce.in = turn_between(fixed_frame(sky.w), bounce.geometry.in);
    bounce.out = turn_between(bounce.geometry.out, toward);
    bounce.weight =
        bounce.geometry.cos_i * light_weight(sky.light.pdf, by_surface, Lighting::kLightSamples);
    vertex.sky_sample_light = sky.light;
}

void PathTracer::trace_open(const SkyNode& node, const Sampler& sampler, std::uint32_t sample,
                            Path& path) const {
    path.open = {};
    const SamplePoint u = sampler.point(sample, 0);
    const Basis basis(node.n, node.wo);
    const DirectionSampler::View lobes(scene_.surface_of(node.instance).directions(),
                                       basis.to_local(node.wo));
    const LightSample sky = scene_.sky.sample(u[kSky1], u[kSky2]);
    if (sky.light.pdf > 0) {
        path.open.sky_sample_light = sky.light;
        path.open.sky_sample =
            open_bounce(node, sky.w, 1 / (sky.light.pdf + lobes.pdf(basis.to_local(sky.w))));
    }
    const Vec3 local = lobes.sample(u[kLobe], u[kSurface1], u[kSurface2]);
    if (!(local.z > 0)) return;
    const double pdf = lobes.pdf(local);
    if (!(pdf > 0)) return;
    const Vec3 wi = basis.to_world(local);
    path.open.onward_light = scene_.sky.locate(wi);
    path.open.onward = open_bounce(node, wi, 1 / (path.open.onward_light.pdf + pdf));
}

void PathTracer::shade_open(const Path& path, const SkyNode& node, float* C) const {
    const Surface& surface = scene_.surface_of(node.instance);
    const OpenSky& open = path.open;
    const auto light = [&](const Bounce& bounce, const LightLookup& from, std::size_t first) {
        if (!(bounce.weight > 0) || !is_sky(from.at))
            return Stokes<Lanes>{Lanes(0.f), Lanes(0.f), Lanes(0.f), Lanes(0.f)};
        return reflected(surface, first, bounce, sky_light(scene_.sky, from.at, first));
    };
    for (std::size_t first = 0; first < stride(); first += kLanes) {
        const Stokes<Lanes> a = light(open.sky_sample, open.sky_sample_light, first);
        const Stokes<Lanes> b = light(open.onward, open.onward_light, first);
        (a.s0 + b.s0).store_unaligned(C + first);
        (a.s1 + b.s1).store_unaligned(C + stride() + first);
        (a.s2 + b.s2).store_unaligned(C + 2 * stride() + first);
        (a.s3 + b.s3).store_unaligned(C + 3 * stride() + first);
        const Lanes seen =
            (open.sky_sample_seen ? a.s0 : Lanes(0.f)) + (open.onward_seen ? b.s0 : Lanes(0.f));
        seen.store_unaligned(C + 4 * stride() + first);
    }
}

// Fills the last vertex's sun_sample if a direction to the sun's disc sees it.
void PathTracer::sample_sun(const Hit& hit, const Basis& basis, const Vec3& wo,
                            const DirectionSampler::View& lobes, const SamplePoint& u,
                            const BeamFrame& toward, Path& path) const {
    const Vec3 w = scene_.sun.sample(u[kSun1], u[kSun2]);
    if (w.y < 0 || !sees_sky(hit, w, path)) return;
    Bounce& bounce = path.vertices.back().sun_sample;
    bounce.geometry = reflection(hit.n, w, wo);
    bounce.out = turn_between(bounce.geometry.out, toward);
    bounce.weight =
        bounce.geometry.cos_i *
        light_weight(scene_.sun.pdf(), lobes.pdf(basis.to_local(w)), Lighting::kLightSamples);
}

void PathTracer::shade(const Path& path, float* S) const {
    for (std::size_t first = 0; first < stride(); first += kLanes) {
        Stokes<Lanes> light{Lanes(0.f), Lanes(0.f), Lanes(0.f), Lanes(0.f)};
        if (path.vertices.empty())
            light = turned(sky_light(scene_.sky.dome(), path.sky, first), path.sky_turn);
        if (path.vertices.empty() && path.sees_sun) light = light + sun_light(scene_.sun, first);
        for (auto vertex = path.vertices.rbegin(); vertex != path.vertices.rend(); ++vertex) {
            const Surface& surface = scene_.surface_of(vertex->instance);
            const bool onward_sky = is_sky(vertex->onward_light.at);
            if (onward_sky) light = sky_light(scene_.sky, vertex->onward_light.at, first);
            if (vertex->onward_sun > 0)
                light = light + real<Lanes>(vertex->onward_sun) * sun_light(scene_.sun, first);
            light = vertex->onward.weight > 0 ? reflected(surface, first, vertex->onward, light)
                                              : 0.f * light;
            if (vertex->sky_sample.weight > 0)
                light =
                    light + reflected(surface, first, vertex->sky_sample,
                                      sky_light(scene_.sky, vertex->sky_sample_light.at, first));
            if (vertex->sun_sample.weight > 0)
                light = light +
                        reflected(surface, first, vertex->sun_sample, sun_light(scene_.sun, first));
        }
        light.s0.store_unaligned(S + first);
        light.s1.store_unaligned(S + stride() + first);
        light.s2.store_unaligned(S + 2 * stride() + first);
        light.s3.store_unaligned(S + 3 * stride() + first);
    }
}

}  // namespace malus
