// path_shading.cpp — light along traced paths, from the far end back.
// SPDX-License-Identifier: Apache-2.0
#include "render/path_tracer.h"

namespace malus {
namespace {

using Light = Stokes<Lanes>;

// Blocks: [S0..S3][wavelength][lane], padded to whole registers.

// What comes from places of a sky, SkyDome or SkyEmitter: rows of a place, then transposed. Of lanes that
// are not wanted 0. Where the sky has no S3 its rows are not read.
template <class Rows>
void sky_light(const Rows& sky, const std::array<SkyLookup, kSide>& at, unsigned wanted,
               std::size_t wavelengths, float* block) {
    std::array<std::array<const float*, 4>, kSide> node;
    for (std::size_t i = 0; i < kSide; ++i)
        for (std::size_t k = 0; k < 4; ++k) node[i][k] = sky.row(at[i].node[k], 0);
    const std::size_t read = (sky.circular() ? 4 : 3) * wavelengths;
    std::size_t j = 0;
    for (; j < read; j += Lanes::size) {
        std::array<Lanes, kSide> rows;
        for (std::size_t i = 0; i < kSide; ++i) {
            if (!(wanted >> i & 1)) {
                rows[i] = Lanes(0.f);
                continue;
            }
            const auto& weight = at[i].weight;  // 0 where the sky is black
            rows[i] = Lanes(weight[0]) * Lanes::load_unaligned(node[i][0] + j) +
                      Lanes(weight[1]) * Lanes::load_unaligned(node[i][1] + j) +
                      Lanes(weight[2]) * Lanes::load_unaligned(node[i][2] + j) +
                      Lanes(weight[3]) * Lanes::load_unaligned(node[i][3] + j);
        }
        transpose(rows, block + j * kSide);
    }
    if (j < 4 * wavelengths) std::fill(block + j * kSide, block + 4 * wavelengths * kSide, 0.f);
}

// A pair of wavelengths of a block; of an odd number the last stands with what follows.
Light pair_of(const float* block, std::size_t p, std::size_t wavelengths) {
    const auto row = [&](std::size_t c) {
        return Lanes::load_unaligned(block + (c * wavelengths + 2 * p) * kSide);
    };
    return {row(0), row(1), row(2), row(3)};
}

// One wavelength or two of a row; with a mask, of its lanes only.
void store(const Lanes& x, bool both, float* to) {
    if (both) {
        x.store_unaligned(to);
    } else {
        const auto numbers = stored(x);
        std::copy_n(numbers.begin(), kSide, to);
    }
}
void store_some(const Lanes& x, const Lanes::batch_bool_type& here, bool both, float* to) {
    store(select(here, x, Lanes::load_unaligned(to)), both, to);
}
void store_pair(const Light& S, unsigned lanes, std::size_t p, std::size_t wavelengths,
                float* block) {
    const bool both = 2 * p + 1 < wavelengths;
    const auto row = [&](std::size_t c) { return block + (c * wavelengths + 2 * p) * kSide; };
    if (lanes == kAllLanes) {
        store(S.s0, both, row(0)), store(S.s1, both, row(1));
        store(S.s2, both, row(2)), store(S.s3, both, row(3));
    } else {
        const auto here = lanes_mask_of(lanes);
        store_some(S.s0, here, both, row(0)), store_some(S.s1, here, both, row(1));
        store_some(S.s2, here, both, row(2)), store_some(S.s3, here, both, row(3));
    }
}

// Light as a facet may meet it: rounding of the turns before must not take S0 below |S1|.
Light at_least_polarized(Light S) {
    S.s0 = max(S.s0, abs(S.s1));
    return S;
}

// A surface's reflection of bounces, ready for any wavelength.
class Reflector {
  public:
    Reflector(const Surface& surface, const Bounces& by) : surface_(surface), by_(by) {}

    Light operator()(std::size_t pair, const Light& S) const {
        const BrdfMueller<Lanes> f = eval(surface_.lanes(pair), surface_.slopes(), by_.facet);
        return turned(f * at_least_polarized(turned(S, by_.in)), by_.out);
    }

  private:
    const Surface& surface_;
    const Bounces& by_;
};

// The sun's radiance at a pair of wavelengths.
Lanes sun_light(const SunDisc& sun, std::size_t p) {
    const float* radiance = sun.radiance() + 2 * p;
    return lanewise<Lanes>([&](std::size_t i) { return radiance[i < kSide ? 0 : 1]; });
}

Light only(const Lanes::batch_bool_type& here, const Light& S) {
    const Lanes none(0.f);
    return {select(here, S.s0, none), select(here, S.s1, none), select(here, S.s2, none),
            select(here, S.s3, none)};
}

Light dark() {
    return {Lanes(0.f), Lanes(0.f), Lanes(0.f), Lanes(0.f)};
}

}  // namespace

void PathTracer::shade(Paths& paths) const {
    for (std::size_t depth = paths.levels_.size(); depth > 0; --depth)
        shade_level(static_cast<int>(depth), paths);
    shade_views(paths);
}

void PathTracer::shade_level(int depth, Paths& paths) const {
    Paths::Level& level = paths.level(depth);
    const std::size_t wavelengths = scene_.wavelengths_nm.size(), rows = 4 * wavelengths;
    const std::size_t block = block_size(rows);
    level.light.resize(std::max(level.light.size(), level.vertices.size() * block));
    const bool open = !level.vertices.empty() && depth == 1 && !paths.spots_.empty();
    const std::size_t open_block = block_size(5 * wavelengths);
    if (open)
        paths.open_light_.resize(
            std::max(paths.open_light_.size(), level.vertices.size() * open_block));
    float* const onward = paths.arriving(block);
    float* const sky = onward + block;
    float* const behind = sky + block;
    for (std::size_t v = 0; v < level.vertices.size(); ++v) {
        const Vertices& at = level.vertices[v];
        if (at.sky_sample.lit)
            sky_light(scene_.sky, at.sky_sample_light, at.sky_sample.lit, wavelengths, sky);
        if (at.onward.lit)
            sky_light(scene_.sky, at.onward_light, at.onward_seen, wavelengths, onward);
        if (at.open && at.behind.lit)
            sky_light(scene_.sky, at.onward_light, at.behind.lit, wavelengths, behind);
        for (std::size_t i = 0; i < kSide; ++i) {
            if (at.next[i] < 0) continue;
            const float* next = paths.light_of(depth + 1, at.next[i], wavelengths);
            for (std::size_t j = 0; j < rows; ++j) onward[j * kSide + i] = next[j * kSide];
        }
        float* const open_light = at.open ? &paths.open_light_[v * open_block] : nullptr;
        for_each_value(at.surface, [&](int s, unsigned lanes) {
            const Surface& surface = scene_.surfaces[static_cast<std::size_t>(s)];
            const Reflector by_onward(surface, at.onward), by_sky(surface, at.sky_sample),
                by_sun(surface, at.sun_sample), by_behind(surface, at.behind);
            const auto sky_seen = lanes_mask_of(at.sky_sample_seen),
                       onward_seen = lanes_mask_of(at.onward_seen);
            for (std::size_t p = 0; p < pairs(wavelengths); ++p) {
                const Lanes sun = sun_light(scene_.sun, p);
                Light S = dark(), C = dark();
                Lanes reaches(0.f);
                if (at.onward.lit & lanes) {
                    Light from = pair_of(onward, p, wavelengths);
                    S = by_onward(p, from);
                    if (at.open) {
                        C = only(onward_seen, S);
                        reaches = C.s0;
                    }
                    if (at.meets_sun) {
                        from.s0 = from.s0 + at.onward_sun * sun;
                        S = by_onward(p, from);
                    }
                }
                if (at.sky_sample.lit & lanes) {
                    const Light by = by_sky(p, pair_of(sky, p, wavelengths));
                    if (at.open) {
                        const Light seen = only(sky_seen, by);
                        C = C + by;
                        reaches = reaches + seen.s0;
                        S = S + seen;
                    } else {
                        S = S + by;
                    }
                }
                if (at.sun_sample.lit & lanes)
                    S = S + by_sun(p, {sun, Lanes(0.f), Lanes(0.f), Lanes(0.f)});
                store_pair(S, lanes, p, wavelengths, &level.light[v * block]);
                if (!at.open) continue;
                if (at.behind.lit & lanes) C = C + by_behind(p, pair_of(behind, p, wavelengths));
                store_pair(C, lanes, p, wavelengths, open_light);
                store_some(reaches, lanes_mask_of(lanes), 2 * p + 1 < wavelengths,
                           open_light + (4 * wavelengths + 2 * p) * kSide);
            }
        });
    }
}

// The sky beside the scene.
void PathTracer::shade_views(Paths& paths) const {
    const std::size_t wavelengths = scene_.wavelengths_nm.size(),
                      block = block_size(4 * wavelengths);
    paths.view_light_.resize(std::max(paths.view_light_.size(), paths.views_.size() * block));
    for (std::size_t v = 0; v < paths.views_.size(); ++v) {
        const Views& at = paths.views_[v];
        if (at.surface == kAllLanes) continue;
        float* const light = &paths.view_light_[v * block];
        float* const seen = paths.arriving(block);
        sky_light(scene_.sky.dome(), at.sky, ~at.surface & kAllLanes, wavelengths, seen);
        const auto sun = lanes_mask_of(at.sun);
        for (std::size_t p = 0; p < pairs(wavelengths); ++p) {
            Light S = turned(pair_of(seen, p, wavelengths), at.turn);
            if (at.sun) S.s0 = S.s0 + select(sun, sun_light(scene_.sun, p), Lanes(0.f));
            store_pair(S, kAllLanes, p, wavelengths, light);
        }
    }
}

}  // namespace malus
