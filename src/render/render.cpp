// render.cpp — pixels over threads: tiles in parallel, each pixel wholly by one thread.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/render.h"

#include <tbb/blocked_range2d.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>
#include <tuple>

#include "render/path_tracer.h"

namespace malus {
namespace {

// Pixels along a tile's side: small pictures still give every thread several tiles.
int tile_side(const RenderSettings& settings, int threads) {
    const double pixels = static_cast<double>(settings.width) * settings.height;
    return std::clamp(static_cast<int>(std::sqrt(pixels / (16.0 * threads))), 1, 16);
}

bool stop_wanted(const RenderSettings& settings) {
    return settings.stop && settings.stop->load(std::memory_order_relaxed);
}

// Work of one thread on one tile; the counts are merged when the tile is done.
struct TileWork {
    Path path;
    std::vector<float> S;
    PixelAccumulator pixel;
    std::uint64_t paths = 0;
    std::vector<RefusedSample> refused;

    explicit TileWork(const PathTracer& tracer, std::size_t wavelengths)
        : S(4 * tracer.stride()), pixel(wavelengths) {}
};

// False, with the pixel left undeveloped, when told to stop.
bool render_pixel(const PathTracer& tracer, const RenderSettings& settings, int x, int y,
                  TileWork& work, Film& film) {
    const std::size_t index = static_cast<std::size_t>(y) * static_cast<std::size_t>(film.width) +
                              static_cast<std::size_t>(x);
    const std::uint32_t samples = whole_spp(settings.spp) / kReplicates;
    work.pixel.start_pixel();
    for (std::uint32_t r = 0; r < kReplicates; ++r) {
        const Sampler sampler(settings.seed, index, r);
        work.pixel.start_replicate();
        for (std::uint32_t s = 0; s < samples; ++s) {
            if (s % 1024 == 0 && stop_wanted(settings)) return false;
            tracer.trace(x, y, sampler, s, work.path);
            tracer.shade(work.path, work.S.data());
            if (!work.pixel.add(work.S.data(), tracer.stride()))
                work.refused.push_back({x, y, r, s});
            if (work.path.vertices.empty())
                work.pixel.add_sky();
            else
                work.pixel.add_surface(work.path.vertices.front().instance,
                                       work.path.vertices.front().distance);
        }
        work.pixel.end_replicate();
        work.paths += samples;
    }
    work.pixel.develop(film, index);
    return true;
}

// Gathers what tiles report; refusals are sorted so that they do not depend on the threads.
class Ledger {
  public:
    Ledger(RenderResult& result, const RenderSettings& settings)
        : result_(result), settings_(settings) {}

    void tile_done(const TileWork& work, std::size_t pixels) {
        const std::lock_guard lock(mutex_);
        result_.paths += work.paths;
        result_.rays += work.path.rays;
        result_.refused += work.refused.size();
        auto& first = result_.first_refused;
        first.insert(first.end(), work.refused.begin(), work.refused.end());
        std::sort(first.begin(), first.end(), [](const auto& a, const auto& b) {
            return std::tie(a.y, a.x, a.replicate, a.sample) <
                   std::tie(b.y, b.x, b.replicate, b.sample);
        });
        first.resize(std::min(first.size(), RenderResult::kMostReported));
        pixels_done_ += pixels;
        if (settings_.progress)
            settings_.progress(static_cast<double>(pixels_done_) /
                               static_cast<double>(result_.film.pixel_count()));
    }

  private:
    RenderResult& result_;
    const RenderSettings& settings_;
    std::mutex mutex_;
    std::size_t pixels_done_ = 0;
};

}  // namespace

RenderResult render(const PreparedScene& scene, const Camera& camera,
                    const RenderSettings& settings) {
    RenderResult result;
    result.film = Film(settings.width, settings.height, scene.wavelengths_nm());
    const PathTracer tracer(scene.impl(), camera, settings);
    Ledger ledger(result, settings);
    const auto render_tile = [&](const tbb::blocked_range2d<int>& tile) {
        TileWork work(tracer, scene.wavelengths_nm().size());
        for (int y = tile.rows().begin(); y < tile.rows().end(); ++y)
            for (int x = tile.cols().begin(); x < tile.cols().end(); ++x) {
                if (!render_pixel(tracer, settings, x, y, work, result.film)) return;
            }
        ledger.tile_done(work, tile.rows().size() * tile.cols().size());
    };
    const int threads = settings.threads > 0 ? settings.threads : tbb::info::default_concurrency();
    const int side = tile_side(settings, threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    arena.execute([&] {
        tbb::parallel_for(
            tbb::blocked_range2d<int>(0, settings.height, side, 0, settings.width, side),
            render_tile, tbb::simple_partitioner());
    });
    result.stopped = stop_wanted(settings);
    return result;
}

}  // namespace malus
