// path_shading.cpp — light along traced paths, from the far end back.
// SPDX-License-Identifier: Apache-2.0
#include "render/path_tracer.h"

#include <bit>

namespace malus {
namespace {

using Light = Stokes<Lanes>;

constexpr unsigned kFloats = 2 * kSide;  // of a register

// Stokes vectors of kSide lanes as they lie among a sky's rows: [lane][S0..S3][wavelength].
class LaneLight {
  public:
    explicit LaneLight(std::size_t wavelengths)
        : wavelengths_(wavelengths), row_(4 * wavelengths), rows_(kSide * row_ + kFloats) {}

    void set_black(std::size_t lane) { std::fill_n(&rows_[lane * row_], row_, 0.f); }
    // Rows of a SkyDome or a SkyEmitter.
    template <class Rows>
    void set_sky(std::size_t lane, const Rows& sky, const SkyLookup& at) {
        if (at.weight == std::array<float, 4>{}) return set_black(lane);
        std::array<const float*, 4> node;
        for (std::size_t k = 0; k < 4; ++k) node[k] = sky.row(at.node[k], 0);
        // Lanes are filled in order: what is written beyond a row belongs to the next.
        for (std::size_t i = 0; i < row_; i += kFloats) {
            Lanes sum = Lanes(at.weight[0]) * Lanes::load_unaligned(node[0] + i);
            for (std::size_t k = 1; k < 4; ++k)
                sum = sum + Lanes(at.weight[k]) * Lanes::load_unaligned(node[k] + i);
            sum.store_unaligned(&rows_[lane * row_ + i]);
        }
    }
    // What another level's lane gives off.
    void set(std::size_t lane, const Lanes* light, std::size_t from) {
        const auto* numbers = reinterpret_cast<const float*>(light);
        for (std::size_t c = 0; c < 4; ++c)
            for (std::size_t w = 0; w < wavelengths_; ++w)
                rows_[lane * row_ + c * wavelengths_ + w] =
                    numbers[(w / 2 * 4 + c) * kFloats + w % 2 * kSide + from];
    }

    Light pair(std::size_t p) const {
        const auto row = [&](std::size_t c) {
            const float* first = &rows_[c * wavelengths_ + 2 * p];
            const std::size_t second = 2 * p + 1 < wavelengths_ ? 1 : 0;
            return lanewise<Lanes>([&](std::size_t i) {
                return first[i < kSide ? i * row_ : (i - kSide) * row_ + second];
            });
        };
        return {row(0), row(1), row(2), row(3)};
    }

  private:
    std::size_t wavelengths_, row_;
    std::vector<float> rows_;
};

// Light as a facet may meet it: rounding of the turns before must not take S0 below |S1|.
Light at_least_polarized(Light S) {
    S.s0 = max(S.s0, abs(S.s1));
    return S;
}

// A surface's reflection of bounces, ready for any wavelength.
class Reflector {
  public:
    Reflector(const Surface& surface, const Bounces& by)
        : surface_(surface),
          geometry_(facet_geometry<Lanes>(surface.attenuation(), by.geometry)),
          in_{real<Lanes>(by.in.cos2), real<Lanes>(by.in.sin2)},
          out_{real<Lanes>(by.out.cos2), real<Lanes>(by.out.sin2)},
          weight_(real<Lanes>(by.weight)) {}

    Light operator()(std::size_t pair, const Light& S) const {
        const BrdfMueller<Lanes> f = eval(surface_.lanes(pair), surface_.slopes(), geometry_);
        return turned(weight_ * (f * at_least_polarized(turned(S, in_))), out_);
    }

  private:
    const Surface& surface_;
    FacetGeometry<Lanes> geometry_;
    TurnOf<Lanes> in_, out_;
    Lanes weight_;
};

bool has_light(const Reals& weight) {
    return any(weight > Reals(0.0));
}

Lanes at_pair(const float* of_wavelengths, std::size_t p, std::size_t wavelengths) {
    const float a = of_wavelengths[2 * p],
                b = 2 * p + 1 < wavelengths ? of_wavelengths[2 * p + 1] : a;
    return lanewise<Lanes>([&](std::size_t i) { return i < kSide ? a : b; });
}

template <class Visit>
void for_each_surface(const std::array<int, kSide>& surface, const Visit& visit) {
    for (unsigned left = kAllLanes; left;) {
        const int first = surface[static_cast<std::size_t>(std::countr_zero(left))];
        unsigned same = 0;
        for (std::size_t i = 0; i < kSide; ++i) same |= (surface[i] == first ? 1u : 0u) << i;
        visit(first, same);
        left &= ~same;
    }
}

Light select_light(const Lanes::batch_bool_type& here, const Light& yes, const Light& no) {
    return {select(here, yes.s0, no.s0), select(here, yes.s1, no.s1), select(here, yes.s2, no.s2),
            select(here, yes.s3, no.s3)};
}

Light dark() {
    return {Lanes(0.f), Lanes(0.f), Lanes(0.f), Lanes(0.f)};
}

void store(const Light& S, Lanes* to) {
    to[0] = S.s0, to[1] = S.s1, to[2] = S.s2, to[3] = S.s3;
}
Light load(const Lanes* from) {
    return {from[0], from[1], from[2], from[3]};
}

}  // namespace

void PathTracer::shade(Paths& paths) const {
    for (std::size_t depth = paths.levels_.size(); depth > 0; --depth)
        shade_level(static_cast<int>(depth), paths);
    shade_views(paths);
    shade_open(paths);
}

void PathTracer::shade_level(int depth, Paths& paths) const {
    Paths::Level& level = paths.level(depth);
    const std::size_t wavelengths = scene_.wavelengths_nm.size(), row = 4 * pair_count();
    level.light.resize(level.vertices.size() * row);
    LaneLight onward(wavelengths), sky(wavelengths);
    for (std::size_t v = 0; v < level.vertices.size(); ++v) {
        const Vertices& at = level.vertices[v];
        const bool goes_on = has_light(at.onward.weight),
                   sees_sky = has_light(at.sky_sample.weight),
                   sees_sun = has_light(at.sun_sample.weight), meets_sun = has_light(at.onward_sun);
        const Lanes onward_sun = real<Lanes>(at.onward_sun);
        for (std::size_t i = 0; i < kSide; ++i) {
            if (sees_sky) sky.set_sky(i, scene_.sky, at.sky_sample_light[i]);
            if (!goes_on) continue;
            if (at.next[i] < 0)
                onward.set_sky(i, scene_.sky, at.onward_light[i]);
            else
                onward.set(i, paths.light_of(depth + 1, at.next[i], row),
                           static_cast<std::size_t>(at.next[i]) % kSide);
        }
        Lanes* to = &level.light[v * row];
        for_each_surface(at.surface, [&](int s, unsigned lanes) {
            const Surface& surface = scene_.surfaces[static_cast<std::size_t>(s)];
            const Reflector by_onward(surface, goes_on ? at.onward : at.sky_sample),
                by_sky(surface, at.sky_sample),
                by_sun(surface, sees_sun ? at.sun_sample : at.sky_sample);
            const auto here = lanes_mask_of(lanes);
            for (std::size_t p = 0; p < pair_count(); ++p) {
                const Lanes sun = at_pair(scene_.sun.radiance(), p, wavelengths);
                Light S = dark();
                if (goes_on) {
                    Light from = onward.pair(p);
                    if (meets_sun) from.s0 = from.s0 + onward_sun * sun;
                    S = by_onward(p, from);
                }
                if (sees_sky) S = S + by_sky(p, sky.pair(p));
                if (sees_sun) S = S + by_sun(p, {sun, Lanes(0.f), Lanes(0.f), Lanes(0.f)});
                store(lanes == kAllLanes ? S : select_light(here, S, load(to + 4 * p)), to + 4 * p);
            }
        });
    }
}

void PathTracer::shade_views(Paths& paths) const {
    const std::size_t wavelengths = scene_.wavelengths_nm.size(), row = 4 * pair_count();
    paths.view_light_.resize(paths.views_.size() * row);
    LaneLight seen(wavelengths);
    for (std::size_t v = 0; v < paths.views_.size(); ++v) {
        const Views& at = paths.views_[v];
        unsigned to_surface = 0;
        for (std::size_t i = 0; i < kSide; ++i) {
            to_surface |= (at.next[i] < 0 ? 0u : 1u) << i;
            if (at.next[i] < 0)
                seen.set_sky(i, scene_.sky.dome(), at.sky[i]);
            else
                seen.set(i, paths.light_of(1, at.next[i], row),
                         static_cast<std::size_t>(at.next[i]) % kSide);
        }
        const auto surface = lanes_mask_of(to_surface), sun = lanes_mask_of(at.sun);
        const TurnOf<Lanes> turn{select(surface, Lanes(1.f), real<Lanes>(at.turn.cos2)),
                                 select(surface, Lanes(0.f), real<Lanes>(at.turn.sin2))};
        for (std::size_t p = 0; p < pair_count(); ++p) {
            Light S = turned(seen.pair(p), turn);
            if (at.sun)
                S.s0 =
                    S.s0 + select(sun, at_pair(scene_.sun.radiance(), p, wavelengths), Lanes(0.f));
            store(S, &paths.view_light_[v * row + 4 * p]);
        }
    }
}

void PathTracer::shade_open(Paths& paths) const {
    const std::size_t wavelengths = scene_.wavelengths_nm.size(), row = 5 * pair_count();
    paths.open_light_.resize(paths.open_.size() * row);
    LaneLight sky(wavelengths), onward(wavelengths);
    for (std::size_t v = 0; v < paths.open_.size(); ++v) {
        const OpenSky& at = paths.open_[v];
        const bool lit = has_light(at.sky_sample.weight) || has_light(at.onward.weight);
        if (!lit) {
            std::fill_n(&paths.open_light_[v * row], row, Lanes(0.f));
            continue;
        }
        for (std::size_t i = 0; i < kSide; ++i) {
            sky.set_sky(i, scene_.sky, at.sky_sample_light[i]);
            onward.set_sky(i, scene_.sky, at.onward_light[i]);
        }
        const auto sky_seen = lanes_mask_of(at.sky_sample_seen),
                   onward_seen = lanes_mask_of(at.onward_seen);
        Lanes* to = &paths.open_light_[v * row];
        for_each_surface(at.surface, [&](int s, unsigned lanes) {
            const Surface& surface = scene_.surfaces[static_cast<std::size_t>(s)];
            const Reflector by_sky(surface, at.sky_sample), by_onward(surface, at.onward);
            const auto here = lanes_mask_of(lanes);
            for (std::size_t p = 0; p < pair_count(); ++p, to += 5) {
                const Light a = by_sky(p, sky.pair(p)), b = by_onward(p, onward.pair(p));
                const Lanes reaches =
                    select(sky_seen, a.s0, Lanes(0.f)) + select(onward_seen, b.s0, Lanes(0.f));
                store(lanes == kAllLanes ? a + b : select_light(here, a + b, load(to)), to);
                to[4] = lanes == kAllLanes ? reaches : select(here, reaches, to[4]);
            }
            to -= row;
        });
    }
}

}  // namespace malus
