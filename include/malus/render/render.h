// render.h — from a scene under a sky to a film.
//
// A PreparedScene is built once and shared by any number of renders (other cameras, seeds, sizes).
// A film depends on the scene, the camera and the settings alone, not on the number of threads;
// under a time limit, how many samples a pixel gets depends on the machine, too.
//
// Adaptive  with a target error or a time limit, samples go where the error is. The error of a pixel
//           is the larger of SE(DoLP) and SE(S0)/S0, at the wavelength where it is largest, and the
//           target is met when 95 % of the pixels that show a surface are at or below it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>

#include "malus/core/sampler.h"
#include "malus/render/exposure.h"
#include "malus/render/film.h"
#include "malus/scene/camera.h"
#include "malus/scene/material.h"
#include "malus/scene/sky.h"

namespace malus {

/// Which samples light a surface: drawn by sky and sun, by the surface's lobes, or both, unless a test
/// or a comparison of methods wants one.
enum class Lighting { kBoth, kLightSamples, kSurfaceSamples };

struct RenderSettings {
    int width = 512, height = 512;  ///< pixels
    std::uint32_t spp = 64;         ///< samples a pixel (adaptive: at most); rounded by whole_spp()
    std::uint32_t replicates = kReplicates;  ///< independent scrambles a pixel, ≥ 2
    double target_error = 0;                 ///< of DoLP, and of S0 relative to it; 0: none
    double time_limit_s = 0;                 ///< of render(), seconds; 0: none
    int max_depth = 2;                       ///< surface reflections on a path, ≥ 1
    std::uint64_t seed = 0;
    int threads = 0;  ///< 0: as many as the machine has
    Lighting lighting = Lighting::kBoth;
    Sampling sampling = Sampling::kSobol;
    /// Take the light of the open sky from samples without rays, and from paths what occluders
    /// change of it (sky_table.h). Of use with Lighting::kBoth alone.
    bool sky_table = true;
    /// Called now and then with the share that is done, from one thread at a time.
    std::function<void(double)> progress;
    const std::atomic<bool>* stop = nullptr;  ///< set it to end the render early
};

/// Samples a pixel rounded up to the same number in each replicate, and that to a checkpoint
/// (exposure.h): to a multiple of R, beyond 64 R to one of R/32 of the power of two below.
constexpr std::uint32_t whole_spp(std::uint32_t spp, std::uint32_t replicates = kReplicates) {
    return checkpoint((spp + replicates - 1) / replicates) * replicates;
}

/// A scene ready to be traced: geometry sorted, paints and sky at the wavelengths of the render.
class PreparedScene {
  public:
    /// `paints`: per instance an index into `materials`. Throws Error when the sky or a material
    /// lacks a wavelength.
    PreparedScene(Scene scene, std::vector<int> paints, const std::vector<Material>& materials,
                  const Sky& sky, std::vector<double> wavelengths_nm);
    ~PreparedScene();
    PreparedScene(PreparedScene&&) noexcept;
    PreparedScene& operator=(PreparedScene&&) noexcept;

    const Scene& scene() const;
    const std::vector<double>& wavelengths_nm() const;
    const SkyResampling& sky_resampling() const;

    struct Impl;
    const Impl& impl() const { return *impl_; }

  private:
    std::unique_ptr<Impl> impl_;
};

/// What ended a render: its samples, an error small enough, the clock, or RenderSettings::stop.
enum class StoppedBy { kSamples, kTargetError, kTimeLimit, kRequest };

/// A sample that was kept out because it was not finite or had S0 < 0.
struct RefusedSample {
    int x, y;
    std::uint32_t replicate, sample;
};

struct RenderResult {
    Film film;
    Exposure exposure;  ///< what to go on from
    StoppedBy stopped_by = StoppedBy::kSamples;
    // Of this call:
    std::uint64_t paths = 0, rays = 0;
    std::uint64_t refused = 0;
    std::vector<RefusedSample> first_refused;  ///< at most kMostReported, in order of pixels
    static constexpr std::size_t kMostReported = 16;

    /// False when stopped on request before each pixel had its first samples.
    bool complete() const;
};

/// Goes on from `begun`, which must come from the same scene, camera, size, seed and replicates, as
/// if that render had never stopped. Throws Error when size, wavelengths or replicates differ.
RenderResult render(const PreparedScene& scene, const Camera& camera,
                    const RenderSettings& settings, Exposure begun = {});

}  // namespace malus
