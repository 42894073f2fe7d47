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
#include <optional>
#include <tuple>

#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"
#include "render/occluders.h"
#include "render/open_light.h"
#include "render/path_tracer.h"
#include "render/sampling_plan.h"
#include "render/shared_errors.h"

namespace malus {
namespace {

// A smaller share of the open sky would take more time to account for than it saves.
constexpr double kLeastOpen = 0.5;
// Of the light that a pixel's first samples should have met, to believe what they say of its share.
constexpr double kLeastEvidence = 0.25;

// Samples of each replicate that are traced side by side.
constexpr std::uint32_t kTogether = 4;
// Samples of which each, as long as none of the sky table is used, decides on its use: one alone
// meets too little light to tell in a pixel of some thousands, which would stand out by its noise.
constexpr std::uint32_t kDeciding = 2;

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
    Paths paths;
    PixelExposure pixel;
    std::vector<Sampler> samplers;  // one a replicate
    std::vector<float> S;           // of a sample of each replicate
    OpenLight open;
    // Of a tile, [wavelength]: those that use the sky table.
    std::vector<std::vector<std::size_t>> open_pixels;
    std::uint64_t samples = 0, refused = 0;
    std::vector<RefusedSample> first_refused;

    explicit Worker(const Exposure& exposure)
        : pixel(exposure),
          S(exposure.pixel_stride()),
          open(exposure.wavelengths_nm.size(), exposure.replicates),
          open_pixels(exposure.wavelengths_nm.size()) {}
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
          workers_([this] { return Worker(result_.exposure); }),
          complete_(result.complete()) {
        if (settings.sky_table && settings.lighting == Lighting::kBoth) {
            table_.emplace(scene.impl(), camera, settings);
            occluders_.emplace(scene.impl(), settings.width, settings.height);
        }
    }

    void run() {
        if (table_) look_around();
        if (any_exposed()) develop_begun();
        while (true) {
            if (const auto why = plan_.plan_round(exposure())) return end(*why);
            const std::vector<std::size_t> tiles = plan_.round(exposure());
            fit_into_time(tiles);
            if (table_) refine_sky();
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

    // To look at sums of nothing would make all their memory real, by one touch more than it takes.
    bool any_exposed() const {
        const std::vector<std::uint32_t>& taken = result_.exposure.taken;
        return std::any_of(taken.begin(), taken.end(), [](std::uint32_t n) { return n > 0; });
    }

    // What was exposed before this call.
    void develop_begun() {
        tbb::parallel_for(std::size_t{0}, plan_.tile_count(), [this](std::size_t t) {
            Worker& worker = workers_.local();
            develop(t, worker,
                    [&](int, int, std::size_t index) { worker.pixel.load(exposure(), index); });
        });
    }

    // `load` brings each pixel of the tile to the worker.
    template <class Load>
    void develop(std::size_t tile, Worker& worker, const Load& load) {
        PixelExposure& pixel = worker.pixel;
        for (std::vector<std::size_t>& pixels : worker.open_pixels) pixels.clear();
        for_each_pixel(tile, [&](int x, int y, std::size_t index) {
            load(x, y, index);
            pixel.develop(result_.film, index, table_ ? table_->error(x, y) : 0);
            if (!table_ || result_.film.samples[index] == 0) return;
            for (std::size_t w = 0; w < worker.open_pixels.size(); ++w)
                if (pixel.is_open(w)) worker.open_pixels[w].push_back(index);
        });
        for (std::size_t w = 0; w < worker.open_pixels.size(); ++w)
            share_errors(result_.film, w, worker.open_pixels[w]);
        for_each_pixel(tile,
                       [&](int, int, std::size_t index) { plan_.measure(result_.film, index); });
    }

    // Which geometries the picture shows, and what hides the sky from them.
    void look_around() {
        constexpr int kSquare = Occluders::kSquare;
        constexpr std::size_t kPixels = kSquare * kSquare;
        const int squares = (settings_.width + kSquare - 1) / kSquare;
        std::vector<std::array<std::optional<Hit>, kPixels>> seen(
            static_cast<std::size_t>(squares));
        const auto hit = [&](int x, int y) -> std::optional<Hit>& {
            return seen[static_cast<std::size_t>(x / kSquare)]
                       [static_cast<std::size_t>(y % kSquare * kSquare + x % kSquare)];
        };
        for (int top = 0; top < settings_.height; top += kSquare) {
            const int bottom = std::min(top + kSquare, settings_.height);
            tbb::parallel_for(0, squares, [&](int square) {
                const int left = square * kSquare,
                          right = std::min(left + kSquare, settings_.width);
                seen[static_cast<std::size_t>(square)].fill(std::nullopt);
                for (int y = top; y < bottom; ++y)
                    for (int x = left; x < right; ++x) hit(x, y) = tracer_.look(x, y);
                look_rays_ +=
                    occluders_->look(square, top / kSquare, seen[static_cast<std::size_t>(square)]);
            });
            for (int y = top; y < bottom; ++y)
                for (int x = 0; x < settings_.width; ++x)
                    if (const auto& met = hit(x, y)) table_->look(x, y, met->instance, met->n);
        }
        table_->settle();
    }

    // Brings the light of the open sky to what the round needs.
    void refine_sky() {
        const std::vector<std::uint32_t> goals = table_->goals(exposure());
        const std::size_t wavelengths = exposure().wavelengths_nm.size();
        tbb::parallel_for(std::size_t{0}, goals.size(), [&](std::size_t node) {
            if (table_->samples(node) >= goals[node]) return;
            Worker& worker = workers_.local();
            // Numbers that no pixel has.
            begin(exposure().pixel_count() + node, worker);
            while (table_->samples(node) < goals[node]) {
                if (table_->samples(node) % 256 == 0 && (stop_wanted() || time_is_up())) return;
                tracer_.sample_open(table_->node(node), table_->samples(node), worker.paths);
                worker.paths.light(0, wavelengths, worker.S.data());
                table_->add(node, worker.S.data());
            }
            table_->develop(node);
        });
    }

    void expose(const std::vector<std::size_t>& tiles) {
        round_samples_ = 0;
        const double total = samples_wanted(tiles) + plan_.left_after_round(exposure());
        tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t i) {
            if (stop_wanted() || time_is_up()) return;
            Worker& worker = workers_.local();
            const std::uint64_t before = worker.samples;
            develop(tiles[i], worker,
                    [&](int x, int y, std::size_t index) { expose_pixel(x, y, index, worker); });
            tell_progress(worker.samples - before, total);
        });
        samples_ += static_cast<double>(round_samples_);
        complete_ = complete_ || result_.complete();
    }

    void expose_pixel(int x, int y, std::size_t index, Worker& worker) {
        const std::uint32_t wanted = exposure().wanted[index];
        PixelExposure& pixel = worker.pixel;
        pixel.load(exposure(), index);
        if (pixel.taken() >= wanted) return;
        begin(index, worker);
        if (table_) worker.open.begin(*table_, x, y);
        while (pixel.taken() < wanted) {
            const std::uint32_t count = samples_together(pixel.taken(), wanted);
            trace(x, y, count, worker);
            if (pixel.taken() < kDeciding) find_open(x, y, worker);
            for (std::uint32_t s = 0; s < count; ++s) {
                add(x, y, s, worker);
                pixel.end_sample();
            }
            const bool keeps = pixel.taken() == checkpoint(pixel.taken());
            if (keeps && (stop_wanted() || time_is_up())) break;
        }
        pixel.store(exposure(), index);
    }

    // Numbers for a pixel, or what else has some of its own.
    void begin(std::size_t index, Worker& worker) const {
        worker.samplers.clear();
        for (std::uint32_t r = 0; r < result_.exposure.replicates; ++r)
            worker.samplers.emplace_back(settings_.seed, index, r, settings_.sampling);
        worker.paths.begin(worker.samplers);
    }

    // The first sample stands alone: what it meets decides how the others are counted.
    static std::uint32_t samples_together(std::uint32_t taken, std::uint32_t wanted) {
        const std::uint32_t next = taken == 0 ? 1 : taken / kTogether * kTogether + kTogether;
        return std::min(next, wanted) - taken;
    }

    // The next samples of all replicates.
    void trace(int x, int y, std::uint32_t count, Worker& worker) {
        const std::uint32_t first = worker.pixel.taken();
        const bool open = table_ && (first < kDeciding || worker.pixel.is_open());
        tracer_.trace(x, y, first, count, worker.paths, open ? open_view(x, y) : OpenView{});
        tracer_.shade(worker.paths);
        worker.samples += worker.paths.size();
    }

    OpenView open_view(int x, int y) const { return {&*table_, toward_occluders(x, y)}; }

    // What draws directions toward what hides the sky, where light of the open sky is known; or null.
    const SkyDensity* toward_occluders(int x, int y) const {
        return table_ && table_->knows(x, y) ? occluders_->find(x, y) : nullptr;
    }

    // How much of the open sky's light reaches the pixel, for each replicate by the others' first
    // samples; none where these met too little of that light to tell, until the second ones are asked.
    // Where directions lead to what hides the sky, all of a C that reaches it to half: X and C then
    // differ by what is hidden, and C alone varies more.
    void find_open(int x, int y, Worker& worker) {
        const std::size_t W = exposure().wavelengths_nm.size(), R = exposure().replicates;
        const bool hidden_known = toward_occluders(x, y) != nullptr;
        if (!worker.open.find(worker.paths, 0)) return;
        const float* T = worker.open.light();
        struct Light {
            double whole = 0, seen = 0;
        };
        std::vector<Light> light(R * W);
        for (std::size_t r = 0; r < R; ++r)
            if (const Paths::Open open = worker.paths.open(r, W); open.spot)
                for (std::size_t w = 0; w < W; ++w)
                    light[r * W + w] = {static_cast<double>(open.light[w * kSide]),
                                        static_cast<double>(open.light[(4 * W + w) * kSide])};
        for (std::uint32_t r = 0; r < R; ++r)
            for (std::size_t w = 0; w < W; ++w) {
                if (worker.pixel.is_open(r, w)) continue;
                double whole = 0, seen = 0, expected = 0;
                for (std::size_t other = 0; other < R; ++other) {
                    if (other == r) continue;
                    whole += light[other * W + w].whole;
                    seen += light[other * W + w].seen;
                    expected += static_cast<double>(T[w * R + other]);
                }
                const bool known = whole > kLeastEvidence * expected && expected > 0;
                const double share = known ? std::clamp(seen / whole, 0.0, 1.0) : 0;
                worker.pixel.set_open(r, w, share < kLeastOpen ? 0 : hidden_known ? 1 : share);
            }
    }

    // A sample of each replicate to the sums.
    void add(int x, int y, std::size_t sample, Worker& worker) {
        const Paths& paths = worker.paths;
        const std::size_t W = exposure().wavelengths_nm.size(), R = exposure().replicates;
        paths.light(sample, W, worker.S.data());
        const bool open = table_ && worker.pixel.is_open() && worker.open.find(paths, sample);
        if (open) worker.open.subtract(paths, sample);
        if (!worker.pixel.add_all(worker.S.data(), open ? worker.open.light() : nullptr))
            for (std::size_t r = 0; r < R; ++r) add_one(x, y, r, open, worker);
        for (std::size_t i = sample * R; i < (sample + 1) * R; ++i)
            if (paths.instance(i) < 0)
                worker.pixel.add_sky();
            else
                worker.pixel.add_surface(paths.instance(i), paths.distance(i));
    }

    // Of a sample of which some are refused, one.
    void add_one(int x, int y, std::size_t replicate, bool open, Worker& worker) {
        const std::size_t W = exposure().wavelengths_nm.size(), R = exposure().replicates;
        std::vector<float> S(4 * W), D(4 * W);
        for (std::size_t j = 0; j < 4 * W; ++j)
            S[j] = worker.S[j * R + replicate], D[j] = worker.open.light()[j * R + replicate];
        const auto r = static_cast<std::uint32_t>(replicate);
        if (!worker.pixel.add(r, S.data(), W, open ? D.data() : nullptr))
            refuse({x, y, r, worker.pixel.taken()}, worker);
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
        result_.rays += look_rays_;
        for (const Worker& worker : workers_) {
            result_.paths += worker.samples;
            result_.rays += worker.paths.rays;
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
    std::optional<SkyTable> table_;
    std::optional<Occluders> occluders_;  // with the table
    std::atomic<std::uint64_t> look_rays_ = 0;
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
