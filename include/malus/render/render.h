// render.h — from a scene under a sky to a film.
//
// A PreparedScene is built once and shared by any number of renders (other cameras, seeds, sizes).
// A film depends on the scene, the camera and the settings alone, not on the number of threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>

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
    std::uint32_t spp = 64;         ///< samples a pixel; rounded up to a multiple of kReplicates
    int max_depth = 2;              ///< surface reflections on a path, ≥ 1
    std::uint64_t seed = 0;
    int threads = 0;  ///< 0: as many as the machine has
    Lighting lighting = Lighting::kBoth;
    /// Called now and then with the share that is done, from one thread at a time.
    std::function<void(double)> progress;
    const std::atomic<bool>* stop = nullptr;  ///< set it to end the render early
};

/// Samples a pixel rounded up to the same number in each replicate.
constexpr std::uint32_t whole_spp(std::uint32_t spp) {
    return (spp + kReplicates - 1) / kReplicates * kReplicates;
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

struct RenderResult {
    Film film;
    bool stopped = false;  ///< ended early: pixels not reached have 0 samples
    std::uint64_t paths = 0, rays = 0;
    std::uint64_t refused = 0;
    std::vector<RefusedSample> first_refused;  ///< at most kMostReported, in order of pixels
    static constexpr std::size_t kMostReported = 16;
};

RenderResult render(const PreparedScene& scene, const Camera& camera,
                    const RenderSettings& settings);

}  // namespace malus
