// benchmark.cpp — the renderer beside a bare loop of the same Embree calls, in one run.
//
// Ratio   the rays of whole paths are kept (after one another, as the renderer traces them) and traced
//         again by a loop that does nothing else, in one flat Embree scene. Both use the same threads and
//         trace as many rays. Each is the median of five rounds taken in turn, ratios that of the rounds'
//         own, since machines are shared.
// Error   of the scene that Mitsuba was timed with, at the size it was timed with and at 1 and 16
//         wavelengths, and of open ground with a box: against a reference of another seed, over all
//         pixels. The reference of the former has the sky table, without which it would take an hour; what
//         that may be off by between its nodes is below 0.0003 of S0 (sky_grid.cpp).
// Prints Markdown tables. Usage: malus-benchmark SCENE MATERIALS [THREADS]
// SPDX-License-Identifier: Apache-2.0
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <thread>

#include "malus/io/gltf.h"
#include "malus/io/material_file.h"
#include "malus/scene/clear_sky.h"
#include "render/path_tracer.h"
#include "tools/benchmark_scenes.h"

using namespace malus;

namespace {

constexpr int kWidth = 160, kHeight = 120, kRounds = 5, kBumpsSide = 512;
constexpr std::uint32_t kSpp = 64, kKept = 16;  // samples rendered, and those whose rays are kept

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

// All triangles of the scene in one Embree geometry, in double-placed float coordinates.
class BareScene {
  public:
    BareScene(const Scene& scene, const Vec3& center) : device_(rtcNewDevice(nullptr)) {
        for (const Instance& instance : scene.instances) {
            const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
            const auto first = static_cast<std::uint32_t>(positions_.size());
            for (const Vec3f& p : mesh.positions)
                positions_.push_back(Vec3f(instance.to_world.point(Vec3(p)) - center));
            for (const auto& t : mesh.triangles)
                triangles_.push_back({first + t[0], first + t[1], first + t[2]});
        }
        positions_.push_back({});
        scene_ = rtcNewScene(device_);
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   positions_.data(), 0, sizeof(Vec3f), positions_.size() - 1);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   triangles_.data(), 0, sizeof triangles_[0], triangles_.size());
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~BareScene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    BareScene(const BareScene&) = delete;
    BareScene& operator=(const BareScene&) = delete;

    // Number of rays that met something.
    std::size_t trace(const TracedRay* rays, std::size_t count) const {
        std::size_t met = 0;
        for (std::size_t i = 0; i < count; ++i) met += meets(rays[i]) ? 1 : 0;
        return met;
    }

  private:
    bool meets(const TracedRay& traced) const {
        RTCRayHit found{};
        RTCRay& ray = found.ray;
        const Vec3f o(traced.ray.origin), d(traced.ray.direction);
        ray.org_x = o.x, ray.org_y = o.y, ray.org_z = o.z;
        ray.dir_x = d.x, ray.dir_y = d.y, ray.dir_z = d.z;
        ray.tfar = std::numeric_limits<float>::infinity();
        ray.mask = ~0u;
        found.hit.geomID = found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        if (traced.kind == RayKind::kAnyHit) return rtcOccluded1(scene_, &ray), ray.tfar < 0;
        rtcIntersect1(scene_, &found);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        if (traced.kind == RayKind::kAnyHit)
            return rtcOccluded1(scene_, &context, &ray), ray.tfar < 0;
        rtcIntersect1(scene_, &context, &found);
#endif
        return found.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }

    RTCDevice device_;
    RTCScene scene_;
    std::vector<Vec3f> positions_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
};

// The rays of kKept samples of every pixel.
std::vector<TracedRay> gather_rays(const PreparedScene& scene, const Camera& camera,
                                   const RenderSettings& settings) {
    std::vector<TracedRay> rays;
    const PathTracer tracer(scene.impl(), camera, settings);
    Paths paths;
    paths.log = &rays;
    for (int y = 0; y < settings.height; ++y)
        for (int x = 0; x < settings.width; ++x) {
            const auto pixel = static_cast<std::uint64_t>(y * settings.width + x);
            const Sampler replicate(settings.seed, pixel, 0);
            paths.begin({&replicate, 1});
            tracer.trace(x, y, 0, kKept, paths);
        }
    return rays;
}

// Traces all rays kSpp / kKept times; a thread that is free takes the next some.
double bare_rays_per_s(const BareScene& bare, const std::vector<TracedRay>& rays, int threads) {
    constexpr std::size_t kChunk = 4096, kTimes = kSpp / kKept;
    const std::size_t chunks = (rays.size() + kChunk - 1) / kChunk;
    std::atomic<std::size_t> next = 0, met = 0;
    const auto work = [&] {
        std::size_t here = 0;
        for (std::size_t i = next++; i < kTimes * chunks; i = next++) {
            const std::size_t from = i % chunks * kChunk;
            here += bare.trace(&rays[from], std::min(kChunk, rays.size() - from));
        }
        met += here;
    };
    const double start = now();
    std::vector<std::thread> workers;
    for (int t = 0; t < threads; ++t) workers.emplace_back(work);
    for (std::thread& worker : workers) worker.join();
    const double seconds = now() - start;
    if (met == 0) std::printf("no ray met anything\n");
    return static_cast<double>(kTimes * rays.size()) / seconds;
}

std::vector<double> spread(std::size_t count) {
    std::vector<double> nm;
    for (std::size_t i = 0; i < count; ++i)
        nm.push_back(count == 1
                         ? 440
                         : 440 + 160.0 * static_cast<double>(i) / static_cast<double>(count - 1));
    return nm;
}

BenchmarkScene shipped(const std::string& file, const std::vector<Material>& materials) {
    BenchmarkScene to{file, read_gltf(file), {}, materials, 2};
    to.paints = assign_paints(to.scene, {}, materials);
    return to;
}

Sky sky_for(const BenchmarkScene& scene, const std::vector<double>& nm) {
    return scene.max_depth == 3 ? even_sky(nm) : make_clear_sky({}, nm, 45, 180);
}

double median(std::vector<double>& x) {
    std::nth_element(x.begin(), x.begin() + std::ssize(x) / 2, x.end());
    return x[x.size() / 2];
}

// One line of the table.
void measure(const BenchmarkScene& of, std::size_t wavelengths, int threads) {
    const std::vector<double> nm = spread(wavelengths);
    const Sky sky = sky_for(of, nm);
    const double start = now();
    const PreparedScene prepared(of.scene, of.paints, of.materials, sky, nm);
    const double build = now() - start;
    const Camera camera = of.scene.cameras.at(0);
    RenderSettings settings;
    settings.threads = threads, settings.max_depth = of.max_depth;
    settings.width = kWidth, settings.height = kHeight, settings.spp = kSpp;
    const std::vector<TracedRay> rays = gather_rays(prepared, camera, settings);
    const BareScene bare(of.scene, prepared.impl().accel.center());
    std::vector<double> bare_speed, speed, samples_per_s, ratio, table_time;
    for (int round = 0; round < kRounds; ++round) {
        bare_speed.push_back(bare_rays_per_s(bare, rays, threads));
        std::array<double, 2> seconds;  // without, with the sky table
        RenderResult result;
        for (std::size_t table : {1u, 0u}) {
            settings.sky_table = table == 1;
            const double begin = now();
            result = render(prepared, camera, settings);
            seconds[table] = now() - begin;
        }
        speed.push_back(static_cast<double>(result.rays) / seconds[0]);
        samples_per_s.push_back(static_cast<double>(result.paths) / seconds[0]);
        ratio.push_back(speed.back() / bare_speed.back());
        table_time.push_back(seconds[1] / seconds[0]);
    }
    std::printf("| %s | %zu | %.2f | %.2f | %.2f | %.2f | %.2f | %.0f |\n", of.name.c_str(),
                wavelengths, median(samples_per_s) / 1e6, median(speed) / 1e6,
                median(bare_speed) / 1e6, median(ratio), median(table_time), 1e3 * build);
    std::fflush(stdout);
}

struct Errors {
    double median, rms;
};
Errors summary(std::vector<double>& errors) {
    double squares = 0;
    for (double e : errors) squares += sqr(e);
    return {median(errors), std::sqrt(squares / static_cast<double>(errors.size()))};
}

// A row a wavelength of what a film is off by.
void tell_errors(const Film& film, const Film& reference, bool table, std::uint32_t spp,
                 double seconds) {
    for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w) {
        std::vector<double> s0, p;
        for (std::size_t i = 0; i < film.pixel_count(); ++i) {
            const Stokes<double>&S = film.at(i, w).mean, &R = reference.at(i, w).mean;
            s0.push_back(std::abs(S.s0 / R.s0 - 1));
            p.push_back(std::abs(dolp(S) - dolp(R)));
        }
        const Errors of_s0 = summary(s0), of_p = summary(p);
        std::printf("| %s | %u | %.2f | %.0f | %.2f %% | %.2f %% | %.5f | %.4f |\n",
                    table ? "with" : "without", spp, seconds, film.wavelengths_nm[w],
                    100 * of_s0.median, 100 * of_s0.rms, of_p.median, of_p.rms);
    }
    std::fflush(stdout);
}

struct Reference {
    std::uint32_t spp;
    bool table;
};

// Error against samples, without and with the sky table.
void measure_errors(const BenchmarkScene& of, std::size_t wavelengths, int width, int height,
                    const Reference& by, const std::vector<std::uint32_t>& without,
                    const std::vector<std::uint32_t>& with, int threads) {
    const std::vector<double> nm = spread(wavelengths);
    const PreparedScene prepared(of.scene, of.paints, of.materials, sky_for(of, nm), nm);
    const Camera camera = of.scene.cameras.at(0);
    RenderSettings settings;
    settings.threads = threads, settings.max_depth = of.max_depth;
    settings.width = width, settings.height = height;
    settings.spp = by.spp, settings.seed = 1, settings.sky_table = by.table;
    std::printf(
        "\n%s, depth %d; %d x %d pixels, reference of %u samples a pixel\n\n"
        "| sky table | samples a pixel | time, s | wavelength, nm | S0, median | S0, rms | "
        "DoLP, median | DoLP, rms |\n|---|---|---|---|---|---|---|---|\n",
        of.name.c_str(), of.max_depth, width, height, by.spp);
    const Film reference = render(prepared, camera, settings).film;
    settings.seed = 0;
    for (bool table : {false, true})
        for (std::uint32_t spp : table ? with : without) {
            settings.spp = spp, settings.sky_table = table;
            const double begin = now();
            const Film film = render(prepared, camera, settings).film;
            tell_errors(film, reference, table, spp, now() - begin);
        }
}

}  // namespace

// One reflection in the registers of a render, that is 2 kSide of (path, wavelength): Fresnel, slopes,
// shadowing, both turns.
void measure_reflection(const Material& paint) {
    const Surface surface(paint, std::vector<double>{440, 600});
    const Vec3 n{0, 0, 1}, wi = normalize(Vec3{0.4, 0.1, 0.8}),
                           wo = normalize(Vec3{-0.3, 0.2, 0.9});
    const ReflectionOf<Reals> geometry = reflection(Vec3s(n), Vec3s(wi), Vec3s(wo));
    auto facet = facet_geometry<Lanes>(Mask(false), geometry);
    const TurnOf<Lanes> turn{Lanes(0.8f), Lanes(0.6f)};
    Stokes<Lanes> S{Lanes(1.f), Lanes(0.2f), Lanes(0.1f), Lanes(0.f)};
    constexpr int kTimes = 1000000;
    double best = HUGE_VAL;
    for (int round = 0; round < kRounds; ++round) {
        const double begin = now();
        for (int i = 0; i < kTimes; ++i) {
            facet.cos_beta = facet.cos_beta * Lanes(0.9999999f);
            const BrdfMueller<Lanes> f = eval(surface.lanes(0), surface.slopes(), facet);
            S = S + turned(Lanes(1e-9f) * (f * turned(S, turn)), turn);
        }
        best = std::min(best, now() - begin);
    }
    std::printf("\n%s: one reflection of %zu (paths x wavelengths) in %.0f ns (S0 %g)\n",
                paint.name.c_str(), Lanes::size, 1e9 * best / kTimes,
                static_cast<double>(lane(S.s0, 0)));
}

// Renders and nothing else, for tools/profile: about 10 s.
void render_again(const BenchmarkScene& of, std::size_t wavelengths) {
    const std::vector<double> nm = spread(wavelengths);
    const PreparedScene prepared(of.scene, of.paints, of.materials, sky_for(of, nm), nm);
    RenderSettings settings;
    settings.max_depth = of.max_depth, settings.sky_table = false;
    settings.width = kWidth, settings.height = kHeight, settings.spp = kSpp;
    for (const double begin = now(); now() - begin < 10;)
        render(prepared, of.scene.cameras.at(0), settings);
}

int main(int argc, char** argv) {
    const bool profiled = argc == 5 && argv[1] == std::string_view("--profile");
    if (!profiled && (argc < 3 || argc > 4)) {
        std::fprintf(
            stderr,
            "usage: malus-benchmark SCENE MATERIALS [THREADS]\n"
            "       malus-benchmark --profile MATERIALS relief|canyon|bumps WAVELENGTHS\n");
        return 2;
    }
    if (profiled) {
        const std::string_view name = argv[3];
        const std::vector<Material> materials = read_materials(argv[2]).materials;
        render_again(name == "relief"   ? relief_scene(materials)
                     : name == "canyon" ? canyon_scene(materials)
                                        : bumps_scene(),
                     static_cast<std::size_t>(std::max(1, std::atoi(argv[4]))));
        return 0;
    }
    try {
        const int threads = argc == 4 ? std::max(1, std::atoi(argv[3]))
                                      : static_cast<int>(std::thread::hardware_concurrency());
        const std::vector<Material> materials = read_materials(argv[2]).materials;
        std::printf("%d x %d pixels, %u samples a pixel, %d threads\n\n", kWidth, kHeight, kSpp,
                    threads);
        std::printf(
            "| scene | wavelengths | samples/s, million | rays/s, million | bare Embree rays/s, "
            "million | ratio | sky table, × time | build, ms "
            "|\n|---|---|---|---|---|---|---|---|\n");
        const BenchmarkScene bumps = bumps_scene();
        for (std::size_t wavelengths : {1u, 2u, 8u, 16u, 32u, 64u})
            measure(shipped(argv[1], materials), wavelengths, threads);
        for (const BenchmarkScene& scene :
             {relief_scene(materials), canyon_scene(materials), bumps})
            for (std::size_t wavelengths : {1u, 8u, 32u}) measure(scene, wavelengths, threads);
        measure_errors(bumps, 1, kBumpsSide, kBumpsSide, {1024, true}, {8, 64, 256}, {8, 16, 64},
                       threads);
        measure_errors(bumps, 16, kBumpsSide, kBumpsSide, {256, true}, {}, {8}, threads);
        measure_errors(plain_scene(materials), 2, kWidth, kHeight, {16384, false}, {8, 16, 64, 256},
                       {8, 16, 64, 256}, threads);
        for (const Material& paint : materials) measure_reflection(paint);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "malus-benchmark: %s\n", error.what());
        return 1;
    }
    return 0;
}
