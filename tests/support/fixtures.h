// fixtures.h — small scenes, skies and paints for tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "malus/render/render.h"
#include "support/reference.h"

namespace malus {

/// The two paints of materials/paints.json.
const Material& green_paint();
const Material& black_paint();

/// B = 0, ρv = 0, ρd = albedo/π at 440, 550 and 600 nm.
Material lambertian(double albedo);

/// A paint of one wavelength, 550 nm.
Material single_row(const std::string& name, const PriestGermer<double>& p,
                    Slopes slopes = Slopes::kGaussian,
                    Attenuation attenuation = Attenuation::kNone);

/// Paints from one end of the model to the other: the two published ones, with Cauchy slopes, with
/// attenuation; glass, mirrors, a brush, n below and at 1, k = 10, a volume term that changes sign.
const std::vector<Material>& varied_paints();

/// The same paint for the reference integrator, at one wavelength.
reference::Paint reference_paint(const Material& material, double wavelength_nm);

/// A parallelogram of two flat triangles, as one instance of its own node and surface `name`.
void add_rectangle(Scene& scene, const std::string& name, const Vec3& corner, const Vec3& edge_u,
                   const Vec3& edge_v);

/// A horizontal square of 1 m about the origin, one instance, facing up.
Scene panel_scene();

/// Ground of 2 m × 2 m and a wall of 2 m × 1 m at its northern edge, facing south: two instances.
Scene corner_scene();

/// Light from w in the meridian frame: S0, linear polarization along `field` as far as it is across
/// the beam, S3.
reference::Stokes polarized_along(const Vec3& field, const Vec3& w, double s0, double linear,
                                  double s3);

/// Polarized to 0.8, with circular light; the sun 50° off the zenith, in no plane of symmetry of the
/// tests' views.
reference::SkyFunction smooth_sky(double sun_azimuth_deg = 200);

/// A map of the sky function, sampled at pixel centres, the same at each wavelength.
Sky sample_sky(const reference::SkyFunction& function, const std::vector<double>& wavelengths_nm,
               int zeniths, int azimuths);

/// An orthographic camera in direction (zenith, azimuth) of `target` that sees 2·half metres.
Camera look_at(const Vec3& target, double zenith_deg, double azimuth_deg, double half_m);

/// A render that is stopped by its `calls`-th report of progress, then by that of 10 more, and so on,
/// by turns with one and two threads, and gone on with until it is done.
struct Interrupted {
    RenderResult result;
    int stops = 0;
};
Interrupted render_with_stops(const PreparedScene& scene, const Camera& camera,
                              const RenderSettings& settings, int calls);

/// Mean Stokes vector of all pixels at a wavelength, and the standard error of each component.
struct PictureMean {
    Stokes<double> mean, error;
};
PictureMean picture_mean(const Film& film, std::size_t wavelength);

/// The cells of a table of tests/data, row by row, without its comments and its line of names.
std::vector<std::vector<std::string>> table_rows(const std::string& file);

/// A folder of its own that is removed at the end.
class TempFolder {
  public:
    TempFolder();
    ~TempFolder();
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  private:
    std::filesystem::path path_;
};

}  // namespace malus
