// path_tracer.cpp — the path loop.
// SPDX-License-Identifier: Apache-2.0
#include "render/path_tracer.h"

namespace malus {
namespace {

// Which numbers of a block serve what.
enum Dimension { kSky1, kSky2, kSurface1, kSurface2, kLobe, kOther1, kOther2 };
// The last two are the point in the pixel in the first block, and in the next ones the point on the
// sun's disc for the vertex before.

TurnOf<Lanes> lanes_of(const TurnOf<Reals>& turn) {
    return {real<Lanes>(turn.cos2), real<Lanes>(turn.sin2)};
}
// Light from wi, in fixed_frame(wi) or unpolarized, to the frame at.toward: what is left of it to shade goes
// to `bounces`. `weight` without the cosine. Lanes not in `lit` bring none.
template <class Meeting>
ReflectionOf<Reals> reflect(const Meeting& at, const Vec3s& wi, const Reals& weight, unsigned lit,
                            Bounces& bounces) {
    const Mask used = mask_of(lit);
    const Vec3s w = select(used, wi, at.hit.n);  // any sound direction
    const ReflectionOf<Reals> geometry = reflection(at.hit.n, w, at.wo);
    bounces.facet = facet_geometry<Lanes>(at.attenuated, geometry,
                                          select(used, geometry.cos_i * weight, Reals(0.0)));
    bounces.in = lanes_of(turn_between(fixed_frame_above(w), geometry.in));
    bounces.out = lanes_of(turn_between(geometry.out, at.toward));
    bounces.lit = lit;
    return geometry;
}

Reals inverse(const Reals& pdf) {
    return Reals(1.0) / max(pdf, Reals(1e-300));
}

// Moves the origins of rays from far away to where they enter the ball around the scene, in double:
// floats are too coarse for an origin at a satellite. Returns the ways saved, m.
Reals approach(Rays& rays, double radius) {
    const Reals along = -dot(rays.origin, rays.direction);
    const Reals skipped = max(along - Reals(2 * radius), Reals(0.0));
    rays.origin = rays.origin + skipped * rays.direction;
    return skipped;
}

}  // namespace

// Vertices while directions are drawn at them.
struct PathTracer::Meeting {
    std::array<std::uint32_t, kSide> path;
    std::array<int, kSide> instance, surface;
    unsigned live;    // lanes with a path, and a surface that reflects
    Mask attenuated;  // surfaces with Torrance and Sparrow's attenuation
    Hits hit;
    Vec3s wo;
    BeamFrames toward;
    // Directions by the sky's brightness, to the sun, and by the surfaces' lobes, and their densities.
    SkySamples sky;
    Vec3s sun, onward;
    Reals sky_by_surface, sun_by_surface, onward_by_surface, onward_by_light;
    unsigned onward_drawn;  // lanes where it leads above the surface
    bool open = false;      // is it wanted, too, what an open sky would bring?
};

PathTracer::PathTracer(const PreparedScene::Impl& scene, const Camera& camera,
                       const RenderSettings& settings)
    : scene_(scene),
      camera_(camera),
      picture_(camera, settings.width, settings.height),
      settings_(settings) {}

// 1/pdf of a direction to sky or sun, as the balance heuristic weighs it.
Reals PathTracer::light_weight(const Reals& by_light, const Reals& by_surface,
                               Lighting drawn_by) const {
    if (settings_.lighting == Lighting::kBoth) return inverse(by_light + by_surface);
    if (settings_.lighting != drawn_by) return Reals(0.0);
    return inverse(drawn_by == Lighting::kLightSamples ? by_light : by_surface);
}

std::optional<Hit> PathTracer::look(int pixel_x, int pixel_y) const {
    Rays rays = picture_.ray<Reals>(Reals(pixel_x + 0.5), Reals(pixel_y + 0.5));
    rays.origin = rays.origin - Vec3s(scene_.accel.center());
    approach(rays, scene_.accel.radius());
    return scene_.accel.intersect(stored(rays.origin)[0], stored(rays.direction)[0]);
}

void PathTracer::trace(int pixel_x, int pixel_y, std::uint32_t first, std::uint32_t count,
                       Paths& paths, const OpenView& open) const {
    paths.start(first, count, static_cast<std::size_t>(settings_.max_depth));
    look_through(pixel_x, pixel_y, paths);
    for (int depth = 1; depth <= settings_.max_depth; ++depth) {
        Paths::Level& level = paths.level(depth);
        for (std::size_t i = 0; i < level.arrivals.size(); i += kSide) {
            Meeting at = meet(depth, i, paths);
            Vertices& vertices = level.vertices.emplace_back();
            vertices.surface = at.surface;
            if (depth == 1 && open.table) find_spots(at, *open.table, pixel_x, pixel_y, paths);
            at.open = vertices.open = depth == 1 && open.table && paths.knows_sky(i / kSide);
            draw(depth, at, paths, depth == 1 && open.toward ? *open.toward : scene_.sky.density(),
                 vertices);
            sample_lights(at, paths, vertices);
            go_on(depth, at, paths, vertices);
        }
    }
}

// Rays through points of the pixel, to the first vertices.
void PathTracer::look_through(int pixel_x, int pixel_y, Paths& paths) const {
    for (std::size_t first = 0; first < paths.size(); first += kSide) {
        const std::size_t used = std::min(kSide, paths.size() - first);
        const unsigned lanes = kAllLanes >> (kSide - used);
        std::array<std::uint32_t, kSide> path;
        for (std::size_t i = 0; i < kSide; ++i)
            path[i] = static_cast<std::uint32_t>(first + (i < used ? i : 0));
        const auto u = points<kOther1, 2>(paths.places(path, 0));
        Rays rays = picture_.ray<Reals>(Reals(pixel_x) + u[0], Reals(pixel_y) + u[1]);
        rays.origin = rays.origin - Vec3s(scene_.accel.center());
        const auto skipped = stored(approach(rays, scene_.accel.radius()));
        const BeamFrames frame = image_frame(camera_, -rays.direction);
        const auto u0 = stored(u[0]), u1 = stored(u[1]);
        for (std::size_t i = 0; i < used; ++i)
            paths.place_[first + i] = {pixel_x + u0[i], pixel_y + u1[i]};

        paths.count(rays, lanes, RayKind::kFirstHit);
        std::array<Met, kSide> met;
        const unsigned hit = scene_.accel.intersect(rays, lanes, met, Company::kClose);
        Views& views = paths.views_.emplace_back();
        views.next = paths.arrive(1, hit, path, rays.direction, frame.x, met);
        for (std::size_t i = 0; i < used; ++i) {
            if (!(hit >> i & 1)) continue;
            paths.first_vertex_[first + i] = views.next[i];
            paths.first_instance_[first + i] = scene_.accel.instance(met[i]);
            paths.first_distance_[first + i] = static_cast<double>(met[i].distance) + skipped[i];
        }
        views.sky = {};
        views.sun = 0;
        views.surface = hit;
        if (hit == lanes) continue;
        const auto directions = stored(rays.direction);
        for (std::size_t i = 0; i < used; ++i)
            if (!(hit >> i & 1)) views.sky[i] = scene_.sky.dome().locate(directions[i]);
        const Mask above = rays.direction.y >= Reals(0.0);
        const Vec3s up = select(above, rays.direction, Vec3s(Vec3{0, 1, 0}));
        const BeamFrames up_frame = image_frame(camera_, -up);
        views.turn = lanes_of(turn_between(fixed_frame_above(up), up_frame));
        views.sun = bits(scene_.sun.contains(rays.direction)) & lanes & ~hit;
    }
}

// The lanes whose surface has Torrance and Sparrow's attenuation.
unsigned PathTracer::attenuated(const std::array<int, kSide>& surface) const {
    unsigned lanes = 0;
    for (std::size_t i = 0; i < kSide; ++i) {
        const Surface& s = scene_.surfaces[static_cast<std::size_t>(surface[i])];
        lanes |= (s.attenuation() == Attenuation::kTorranceSparrow ? 1u : 0u) << i;
    }
    return lanes;
}

// kSide vertices from arrival `first` on.
PathTracer::Meeting PathTracer::meet(int depth, std::size_t first, Paths& paths) const {
    const std::vector<Paths::Arrival>& arrivals = paths.level(depth).arrivals;
    const std::size_t used = std::min(kSide, arrivals.size() - first);
    const auto arrival = [&](std::size_t i) -> const Paths::Arrival& {
        return arrivals[first + (i < used ? i : 0)];
    };
    Meeting at;
    at.live = kAllLanes >> (kSide - used);
    std::array<Met, kSide> met;
    for (std::size_t i = 0; i < kSide; ++i) {
        met[i] = arrival(i).met;
        at.path[i] = arrival(i).path;
        at.instance[i] = scene_.accel.instance(met[i]);
        at.surface[i] = scene_.paints[static_cast<std::size_t>(at.instance[i])];
    }
    at.attenuated = mask_of(attenuated(at.surface));
    const Vec3s direction = vectors([&](std::size_t i) { return arrival(i).direction; });
    at.hit = scene_.accel.points(met, direction);
    at.wo = -direction;
    at.toward = {at.wo, vectors([&](std::size_t i) { return arrival(i).toward_x; })};
    return at;
}

// Directions of light, each with its densities. `by_light` draws those to the sky that the lobes do not.
void PathTracer::draw(int depth, Meeting& at, Paths& paths, const SkyDensity& by_light,
                      Vertices& vertices) const {
    const auto block = static_cast<std::uint32_t>(depth - 1);
    const auto u = points<0, kLobe + 1>(paths.places(at.path, block));
    at.sky = sample_sky(scene_.sky, by_light, u[kSky1], u[kSky2], vertices.sky_sample_light);
    at.sun = at.hit.n;
    if (scene_.sun.present()) {
        const auto v = points<kOther1, 2>(paths.places(at.path, block + 1));
        at.sun = scene_.sun.sample(v[0], v[1]);
    }
    draw_by_surface(at, u[kLobe], u[kSurface1], u[kSurface2]);
    at.onward_by_light =
        locate(scene_.sky, by_light, at.onward, at.onward_drawn, vertices.onward_light);
}

// A direction by the surfaces' lobes, and the densities of all directions by them.
void PathTracer::draw_by_surface(Meeting& at, const Reals& lobe, const Reals& u1,
                                 const Reals& u2) const {
    const BasisOf<Reals> basis(at.hit.n, at.wo);
    const Vec3s wo = basis.to_local(at.wo);
    const Vec3s sky = basis.to_local(at.sky.w), sun = basis.to_local(at.sun);
    Vec3s onward(Vec3{0, 0, 1});
    const Reals zero(0.0);
    at.sky_by_surface = at.sun_by_surface = at.onward_by_surface = zero;
    for_each_value(at.surface, [&](int surface, unsigned lanes) {
        const DirectionSampler& directions =
            scene_.surfaces[static_cast<std::size_t>(surface)].directions();
        if (directions.black()) {
            at.live &= ~lanes;
            return;
        }
        const Mask here = mask_of(lanes);
        const DirectionSampler::View<Reals> lobes(directions, wo);
        const Vec3s local = lobes.sample(lobe, u1, u2);
        onward = select(here, local, onward);
        at.sky_by_surface = select(here, lobes.pdf(sky), at.sky_by_surface);
        at.onward_by_surface = select(here, lobes.pdf(local), at.onward_by_surface);
        if (scene_.sun.present())
            at.sun_by_surface = select(here, lobes.pdf(sun), at.sun_by_surface);
    });
    // Facets that point it underground reflect none.
    at.onward_drawn = at.live & bits((onward.z > zero) && (at.onward_by_surface > zero));
    at.onward = select(mask_of(at.onward_drawn), basis.to_world(onward), at.hit.n);
}

// The lanes in `wanted` that light from w reaches.
unsigned PathTracer::sees(const Meeting& at, const Vec3s& w, unsigned wanted, Company company,
                          Paths& paths) const {
    const Reals zero(0.0);
    wanted &= at.live & bits((dot(w, at.hit.n) > zero) && (dot(w, at.hit.ng) > zero));
    if (!wanted) return 0;
    const Rays shadow{at.hit.leave(w), w};
    paths.count(shadow, wanted, RayKind::kAnyHit);
    return wanted & ~scene_.accel.occluded(shadow, wanted, company);
}

// Light from the directions drawn by the sky's brightness and from the sun.
void PathTracer::sample_lights(Meeting& at, Paths& paths, Vertices& vertices) const {
    const Reals zero(0.0);
    const unsigned drawn = bits(at.sky.pdf > zero);
    vertices.sky_sample_seen = sees(at, at.sky.w, drawn, Company::kAlone, paths);
    const unsigned lit =
        at.open ? at.live & drawn & bits(dot(at.sky.w, at.hit.n) > zero) : vertices.sky_sample_seen;
    if (lit)
        reflect(at, at.sky.w, light_weight(at.sky.pdf, at.sky_by_surface, Lighting::kLightSamples),
                lit, vertices.sky_sample);
    if (!scene_.sun.present()) return;
    const unsigned seen = sees(at, at.sun, bits(at.sun.y >= zero), Company::kClose, paths);
    if (!seen) return;
    reflect(at, at.sun,
            light_weight(Reals(scene_.sun.pdf()), at.sun_by_surface, Lighting::kLightSamples), seen,
            vertices.sun_sample);
}

// Follows the directions drawn by the surfaces' lobes: to the sky, or to the next vertices.
void PathTracer::go_on(int depth, Meeting& at, Paths& paths, Vertices& vertices) const {
    const Reals zero(0.0), one(1.0);
    const Vec3s& wi = at.onward;
    // On the last bounce only the sky beyond matters.
    const bool last = depth == settings_.max_depth;
    unsigned free = at.onward_drawn & bits(dot(wi, at.hit.ng) > zero);
    if (last) free &= bits(wi.y >= zero);
    const Rays rays{at.hit.leave(wi), wi};
    paths.count(rays, free, last ? RayKind::kAnyHit : RayKind::kFirstHit);
    std::array<Met, kSide> met;
    const unsigned blocked = last && free ? scene_.accel.occluded(rays, free) : 0;
    const unsigned hit = last || !free ? 0 : scene_.accel.intersect(rays, free, met);
    const unsigned seen = free & ~hit & ~blocked;

    vertices.onward_seen = seen;
    const Reals weight =
        light_weight(at.onward_by_light, at.onward_by_surface, Lighting::kSurfaceSamples);
    const Mask to_surface = mask_of(hit), to_sky = mask_of(seen);
    const ReflectionOf<Reals> onward =
        reflect(at, wi, select(to_surface, inverse(at.onward_by_surface), weight), seen | hit,
                vertices.onward);
    const auto in_facet_frame = lanes_mask_of(hit);  // as the next vertex's light is
    vertices.onward.in.cos2 = select(in_facet_frame, Lanes(1.f), vertices.onward.in.cos2);
    vertices.onward.in.sin2 = select(in_facet_frame, Lanes(0.f), vertices.onward.in.sin2);
    const Mask to_sun = to_sky && (weight > zero) && scene_.sun.contains(wi);
    vertices.meets_sun = bits(to_sun);
    if (vertices.meets_sun)
        vertices.onward_sun = real<Lanes>(select(
            to_sun,
            light_weight(Reals(scene_.sun.pdf()), at.onward_by_surface, Lighting::kSurfaceSamples) /
                select(to_sun, weight, one),
            zero));
    if (at.open) {
        const unsigned behind = at.onward_drawn & ~seen & bits(wi.y >= zero);
        if (behind) reflect(at, wi, weight, behind, vertices.behind);
    }
    vertices.next = paths.arrive(depth + 1, hit, at.path, wi, onward.in.x, met);
}

// Where first vertices lie in the table.
void PathTracer::find_spots(const Meeting& at, const SkyTable& table, int pixel_x, int pixel_y,
                            Paths& paths) const {
    const auto n = stored(at.hit.n), wo = stored(at.wo);
    std::array<SkySpot, kSide>& spots = paths.spots_.emplace_back();
    for (std::size_t i = 0; i < kSide; ++i) {
        const auto& place = paths.place_[at.path[i]];
        if (at.live >> i & 1)
            spots[i] =
                table.find(pixel_x, pixel_y, place[0], place[1], at.instance[i], n[i], wo[i]);
    }
}

void PathTracer::sample_open(const SkyNode& node, std::uint32_t sample, Paths& paths) const {
    const Reals zero(0.0);
    paths.start(sample, 1, 1);
    for (std::size_t first = 0; first < paths.size(); first += kSide) {
        const std::size_t used = std::min(kSide, paths.size() - first);
        Meeting at;
        for (std::size_t i = 0; i < kSide; ++i)
            at.path[i] = static_cast<std::uint32_t>(first + (i < used ? i : 0));
        at.live = kAllLanes >> (kSide - used);
        at.instance.fill(node.instance);
        at.surface.fill(scene_.paints[static_cast<std::size_t>(node.instance)]);
        at.attenuated = mask_of(attenuated(at.surface));
        at.hit.n = at.hit.ng = Vec3s(node.n);
        at.wo = Vec3s(node.wo);
        at.toward = {at.wo, Vec3s(node.toward.x)};
        Vertices& vertices = paths.level(1).vertices.emplace_back();
        draw(1, at, paths, scene_.sky.density(), vertices);
        vertices.surface = at.surface;
        vertices.next.fill(-1);
        const auto reflected = [&](const Vec3s& w, const Reals& by_light, const Reals& by_surface,
                                   unsigned drawn, Bounces& bounces) {
            const unsigned lit = at.live & drawn & bits((dot(w, at.hit.n) > zero) && (w.y >= zero));
            reflect(at, w, inverse(by_light + by_surface), lit, bounces);
        };
        reflected(at.onward, at.onward_by_light, at.onward_by_surface, at.onward_drawn,
                  vertices.onward);
        vertices.onward_seen = vertices.onward.lit;
        reflected(at.sky.w, at.sky.pdf, at.sky_by_surface, bits(at.sky.pdf > zero),
                  vertices.sky_sample);
        for (std::size_t i = 0; i < used; ++i)
            paths.first_vertex_[first + i] = static_cast<int>(first + i);
    }
    shade_level(1, paths);
}

}  // namespace malus
