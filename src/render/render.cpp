// render.cpp — rounds of samples: tiles over threads, each pixel wholly by one thread.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/render.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <tuple>

#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"
#include "render/path_tracer.h"
#include "render/sampling_plan.h"

namespace malus {
namespace {

class Clock {
  public:
    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Work of one thread; the counts are merged when all is done.
struct Worker {
    Path path;
    std::vector<float> S;
    PixelExposure pixel;
    std::vector<Sampler> samplers;  // one a replicate
    std::uint64_t paths = 0, refused = 0;
    std::vector<RefusedSample> first_refused;

    Worker(const PathTracer& tracer, const Exposure& exposure)
        : S(4 * tracer.stride()), pixel(exposure) {}
};

// One call of render().
class Job {
  public:
    Job(const PreparedScene& scene, const Camera& camera, const RenderSettings& settings,
        RenderResult& result)
        : settings_(settings),
          tracer_(scene.impl(), camera, settings),
          result_(result),
          plan_(settings, result.exposure),
          workers_([this] { return Worker(tracer_, result_.exposure); }),
          complete_(result.complete()) {}

    void run() {
        develop_begun();
        while (true) {
            if (const auto why = plan_.plan_round(exposure())) return end(*why);
            const std::vector<std::size_t> tiles = plan_.round(exposure());
            fit_into_time(tiles);
            expose(tiles);
            if (stop_wanted()) return end(StoppedBy::kRequest);
            if (time_is_up()) return end(StoppedBy::kTimeLimit);
        }
    }

  private:
    Exposure& exposure() { return result_.exposure; }

    bool stop_wanted() const {
        return settings_.stop && settings_.stop->load(std::memory_order_relaxed);
    }
    // Each pixel gets its first samples in any case.
    bool time_is_up() const {
        return settings_.time_limit_s > 0 && complete_ &&
               clock_.seconds() >= settings_.time_limit_s;
    }

    // What was exposed before this call.
    void develop_begun() {
        tbb::parallel_for(std::size_t{0}, plan_.tile_count(), [this](std::size_t t) {
            PixelExposure& pixel = workers_.local().pixel;
            for_each_pixel(t, [&](int, int, std::size_t index) {
                pixel.load(exposure(), index);
                pixel.develop(result_.film, index);
                plan_.measure(result_.film, index);
            });
        });
    }

    void expose(const std::vector<std::size_t>& tiles) {
        round_samples_ = 0;
        const double total = samples_wanted(tiles) + plan_.left_after_round(exposure());
        tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t i) {
            if (stop_wanted() || time_is_up()) return;
            Worker& worker = workers_.local();
            const std::uint64_t before = worker.paths;
            for_each_pixel(tiles[i], [&](int x, int y, std::size_t index) {
                expose_pixel(x, y, index, worker);
            });
            tell_progress(worker.paths - before, total);
        });
        samples_ += static_cast<double>(round_samples_);
        complete_ = complete_ || result_.complete();
    }

    void expose_pixel(int x, int y, std::size_t index, Worker& worker) {
        const std::uint32_t wanted = exposure().wanted[index];
        if (exposure().taken[index] >= wanted) return;
        PixelExposure& pixel = worker.pixel;
        pixel.load(exposure(), index);
        worker.samplers.clear();
        for (std::uint32_t r = 0; r < exposure().replicates; ++r)
            worker.samplers.emplace_back(settings_.seed, index, r, settings_.sampling);
        while (pixel.taken() < wanted) {
            for (std::uint32_t r = 0; r < exposure().replicates; ++r) sample(x, y, r, worker);
            pixel.end_sample();
            const bool keeps = pixel.taken() == checkpoint(pixel.taken());
            if (keeps && (stop_wanted() || time_is_up())) break;
        }
        pixel.store(exposure(), index);
        pixel.develop(result_.film, index);
        plan_.measure(result_.film, index);
    }

    void sample(int x, int y, std::uint32_t replicate, Worker& worker) {
        const std::uint32_t s = worker.pixel.taken();
        Path& path = worker.path;
        tracer_.trace(x, y, worker.samplers[replicate], s, path);
        tracer_.shade(path, worker.S.data());
        if (!worker.pixel.add(replicate, worker.S.data(), tracer_.stride()))
            refuse({x, y, replicate, s}, worker);
        if (path.vertices.empty())
            worker.pixel.add_sky();
        else
            worker.pixel.add_surface(path.vertices.front().instance,
                                     path.vertices.front().distance);
        ++worker.paths;
    }

    // Keeps the first in order of pixels, so that what is told does not depend on the threads.
    void refuse(const RefusedSample& sample, Worker& worker) {
        ++worker.refused;
        keep_first(worker.first_refused, sample);
    }
    static void keep_first(std::vector<RefusedSample>& first, const RefusedSample& sample) {
        const auto order = [](const RefusedSample& a, const RefusedSample& b) {
            return std::tie(a.y, a.x, a.sample, a.replicate) <
                   std::tie(b.y, b.x, b.sample, b.replicate);
        };
        first.insert(std::upper_bound(first.begin(), first.end(), sample, order), sample);
        first.resize(std::min(first.size(), RenderResult::kMostReported));
    }

    // Takes from each tile's new samples what the clock will not allow.
    void fit_into_time(const std::vector<std::size_t>& tiles) {
        if (!(settings_.time_limit_s > 0) || samples_ == 0) return;
        const double left = settings_.time_limit_s - clock_.seconds();
        const double cost = clock_.seconds() / samples_ * samples_wanted(tiles);
        if (cost <= left) return;
        for (std::size_t t : tiles)
            for_each_pixel(t, [&](int, int, std::size_t i) {
                const std::uint32_t taken = exposure().taken[i];
                const double more = left / cost * (exposure().wanted[i] - taken);
                const auto fits = taken + static_cast<std::uint32_t>(std::max(1.0, more));
                exposure().wanted[i] = std::min(exposure().wanted[i], checkpoint(fits));
            });
    }

    double samples_wanted(const std::vector<std::size_t>& tiles) {
        double samples = 0;
        for (std::size_t t : tiles)
            for_each_pixel(t, [&](int, int, std::size_t i) {
                samples +=
                    std::max(exposure().wanted[i], exposure().taken[i]) - exposure().taken[i];
            });
        return samples * exposure().replicates;
    }

    void tell_progress(std::uint64_t samples, double total) {
        round_samples_ += samples;
        if (!settings_.progress) return;
        const std::unique_lock lock(progress_, std::try_to_lock);
        if (!lock) return;
        double share = (samples_ + static_cast<double>(round_samples_)) / (samples_ + total);
        if (settings_.time_limit_s > 0)
            share = std::max(share, clock_.seconds() / settings_.time_limit_s);
        settings_.progress(std::min(1.0, share));
    }

    void end(StoppedBy why) {
        result_.stopped_by = why;
        for (const Worker& worker : workers_) {
            result_.paths += worker.paths;
            result_.rays += worker.path.rays;
            result_.refused += worker.refused;
            for (const RefusedSample& sample : worker.first_refused)
                keep_first(result_.first_refused, sample);
        }
    }

    template <class Visit>
    void for_each_pixel(std::size_t t, Visit visit) const {
        const Tile& tile = plan_.tile(t);
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x)
                visit(x, y,
                      static_cast<std::size_t>(y) * static_cast<std::size_t>(settings_.width) +
                          static_cast<std::size_t>(x));
    }

    const RenderSettings& settings_;
    const PathTracer tracer_;
    RenderResult& result_;
    SamplingPlan plan_;
    tbb::enumerable_thread_specific<Worker> workers_;
    const Clock clock_;
    bool complete_;       // each pixel has samples
    double samples_ = 0;  // of the rounds that are done
    std::atomic<std::uint64_t> round_samples_ = 0;
    std::mutex progress_;
};

void check_belongs(const Exposure& begun, const PreparedScene& scene,
                   const RenderSettings& settings) {
    const auto size = [](int width, int height) {
        return std::to_string(width) + " x " + std::to_string(height) + " pixels";
    };
    if (begun.width != settings.width || begun.height != settings.height)
        throw Error("it has " + size(begun.width, begun.height) + ", not " +
                    size(settings.width, settings.height));
    if (begun.replicates != settings.replicates)
        throw Error("it has " + std::to_string(begun.replicates) + " replicates, not " +
                    std::to_string(settings.replicates));
    const auto same = [](double a, double b) { return std::abs(a - b) < kSameWavelength_nm; };
    if (!std::equal(begun.wavelengths_nm.begin(), begun.wavelengths_nm.end(),
                    scene.wavelengths_nm().begin(), scene.wavelengths_nm().end(), same))
        throw Error("it has the wavelengths " + to_text(begun.wavelengths_nm) + " nm, not " +
                    to_text(scene.wavelengths_nm()) + " nm");
}

}  // namespace

bool RenderResult::complete() const {
    return std::all_of(exposure.taken.begin(), exposure.taken.end(),
                       [](std::uint32_t taken) { return taken > 0; });
}

RenderResult render(const PreparedScene& scene, const Camera& camera,
                    const RenderSettings& settings, Exposure begun) {
    RenderResult result;
    result.film = Film(settings.width, settings.height, scene.wavelengths_nm());
    if (begun.pixel_count() == 0)
        begun =
            Exposure(settings.width, settings.height, scene.wavelengths_nm(), settings.replicates);
    check_belongs(begun, scene, settings);
    result.exposure = std::move(begun);
    result.exposure.wavelengths_nm = scene.wavelengths_nm();
    const int threads = settings.threads > 0 ? settings.threads : tbb::info::default_concurrency();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    arena.execute([&] { Job(scene, camera, settings, result).run(); });
    return result;
}

}  // namespace malus
