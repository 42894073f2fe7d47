// fixtures.cpp — small scenes, skies and paints for tests.
// SPDX-License-Identifier: Apache-2.0
#include "support/fixtures.h"

#include <unistd.h>

#include <fstream>
#include <sstream>
#include <utility>

#include "malus/core/frame.h"
#include "malus/io/material_file.h"
#include "support/catch.h"

namespace malus {
namespace {

const Material& shipped(std::size_t index) {
    static const MaterialFile file = read_materials(MALUS_SOURCE_DIR "/materials/paints.json");
    return file.materials.at(index);
}

}  // namespace

const Material& green_paint() {
    return shipped(0);
}
const Material& black_paint() {
    return shipped(1);
}

Material lambertian(double albedo) {
    Material material;
    material.name = material.place = "matte";
    for (double nm : {440.0, 550.0, 600.0})
        material.rows.push_back({nm, {1.5, 0, 0, 0.3, 1, 0, albedo / kPi, 0}});
    return material;
}

Material single_row(const std::string& name, const PriestGermer<double>& p, Slopes slopes,
                    Attenuation attenuation) {
    Material material;
    material.name = material.place = name;
    material.slopes = slopes;
    material.attenuation = attenuation;
    material.rows = {{550, p}};
    return material;
}

const std::vector<Material>& varied_paints() {
    static const std::vector<Material> list = [] {
        std::vector<Material> all{green_paint(), black_paint(), green_paint(), black_paint()};
        all[2].slopes = Slopes::kCauchy;
        all[3].attenuation = Attenuation::kTorranceSparrow;
        const auto ts = Attenuation::kTorranceSparrow;
        all.push_back(single_row("glass", {1.5, 0, 1, 0.1, 1, 0, 0, 0}));
        all.push_back(single_row("mirror", {0.2, 5, 1, 1e-5, 1, 0, 0, 0}));
        all.push_back(single_row("brush", {0.3, 10, 1, 10, 1, 0, 0, 0}, Slopes::kGaussian, ts));
        all.push_back(single_row("bubble", {0.8, 0, 1, 0.3, 0.5, 2, 0.01, 0}));
        all.push_back(single_row("air", {1, 0, 1, 0.3, 1, 0, 0.02, 0}));
        all.push_back(single_row("nearly air", {1 + 1e-6, 0, 1, 0.3, 1, 0, 0, 0}));
        all.push_back(single_row("turning", {1.4, 0.1, 0.2, 0.2, 1, 0, 0.02, -0.015}));
        all.push_back(
            single_row("Cauchy metal", {1.2, 6, 0.5, 0.2, 1, 0, 0, 0}, Slopes::kCauchy, ts));
        return all;
    }();
    return list;
}

reference::Paint reference_paint(const Material& material, double wavelength_nm) {
    const PriestGermer<double> p = parameters_at(material, wavelength_nm);
    reference::Paint paint;
    paint.n = p.n, paint.k = p.k, paint.B = p.B, paint.sigma = p.sigma;
    paint.slopes = material.slopes == Slopes::kGaussian ? reference::Slopes::gaussian
                                                        : reference::Slopes::cauchy;
    if (p.inv_omega > 0) paint.shadowing = reference::Shadowing{p.tau, 1 / p.inv_omega};
    paint.torrance_sparrow = material.attenuation == Attenuation::kTorranceSparrow;
    paint.rho_d = p.rho_d, paint.rho_v = p.rho_v;
    return paint;
}

void add_rectangle(Scene& scene, const std::string& name, const Vec3& corner, const Vec3& edge_u,
                   const Vec3& edge_v) {
    Mesh mesh;
    mesh.name = name;
    mesh.surface = static_cast<int>(scene.surfaces.size());
    for (const Vec3& p : {corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v})
        mesh.positions.push_back(Vec3f(p));
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    scene.surfaces.push_back(name);
    scene.instances.push_back(
        {static_cast<int>(scene.meshes.size()), static_cast<int>(scene.nodes.size()), Affine{}});
    scene.meshes.push_back(mesh);
    scene.nodes.push_back({name, -1});
}

Scene panel_scene() {
    Scene scene;
    add_rectangle(scene, "panel", {-0.5, 0, 0.5}, {1, 0, 0}, {0, 0, -1});
    return scene;
}

Scene corner_scene() {
    Scene scene;
    add_rectangle(scene, "ground", {-1, 0, 2}, {2, 0, 0}, {0, 0, -2});
    add_rectangle(scene, "wall", {-1, 0, 0}, {2, 0, 0}, {0, 1, 0});
    return scene;
}

reference::Stokes polarized_along(const Vec3& field, const Vec3& w, double s0, double linear,
                                  double s3) {
    const Vec3 up = reference::meridian_axis(w), side = cross(-w, up);
    const double ex = dot(field, up), ey = dot(field, side);
    const double norm = linear / (ex * ex + ey * ey);
    return {s0, norm * (ex * ex - ey * ey), norm * 2 * ex * ey, s3};
}

reference::SkyFunction smooth_sky(double sun_azimuth_deg) {
    return reference::rayleigh_sky(direction(to_radians(50), to_radians(sun_azimuth_deg)), 1.0, 0.8,
                                   0.15);
}

Sky sample_sky(const reference::SkyFunction& function, const std::vector<double>& wavelengths_nm,
               int zeniths, int azimuths) {
    Sky sky;
    sky.wavelengths_nm = wavelengths_nm;
    for (int i = 0; i < zeniths; ++i) sky.zeniths.push_back((i + 0.5) * kPi / 2 / zeniths);
    for (int i = 0; i < azimuths; ++i) sky.azimuths.push_back((i + 0.5) * 2 * kPi / azimuths);
    for (std::size_t w = 0; w < wavelengths_nm.size(); ++w)
        for (double z : sky.zeniths)
            for (double a : sky.azimuths) {
                const reference::Stokes S = function(direction(z, a));
                sky.nodes.push_back({S[0], S[1], S[2], S[3]});
            }
    return sky;
}

Camera look_at(const Vec3& target, double zenith_deg, double azimuth_deg, double half_m) {
    Box box;
    box.add(target);
    View view;
    view.zenith = to_radians(zenith_deg);
    view.azimuth = to_radians(azimuth_deg);
    Camera camera = frame_view(view, box, 1, 1);
    camera.position = target - 10.0 * camera.forward;
    camera.xmag = camera.ymag = half_m;
    return camera;
}

Interrupted render_with_stops(const PreparedScene& scene, const Camera& camera,
                              const RenderSettings& settings, int calls) {
    Interrupted part;
    do {
        std::atomic<bool> stop{false};
        int reports = 0;
        RenderSettings run = settings;
        run.stop = &stop;
        run.threads = 1 + part.stops % 2;
        run.progress = [&](double) { stop = stop || ++reports > calls + 10 * part.stops; };
        part.result = render(scene, camera, run, std::move(part.result.exposure));
    } while (part.result.stopped_by == StoppedBy::kRequest && ++part.stops < 200);
    return part;
}

PictureMean picture_mean(const Film& film, std::size_t wavelength) {
    PictureMean out;
    const double share = 1 / static_cast<double>(film.pixel_count());
    std::array<double, 4> variance{};
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        const PixelStokes& pixel = film.at(i, wavelength);
        out.mean = out.mean + share * pixel.mean;
        constexpr std::array<std::size_t, 4> kDiagonal{0, 3, 5, 6};
        for (std::size_t c = 0; c < 4; ++c)
            variance[c] += share * share * static_cast<double>(pixel.covariance[kDiagonal[c]]);
    }
    out.error = {std::sqrt(variance[0]), std::sqrt(variance[1]), std::sqrt(variance[2]),
                 std::sqrt(variance[3])};
    return out;
}

std::vector<std::vector<std::string>> table_rows(const std::string& file) {
    std::ifstream in(MALUS_SOURCE_DIR "/tests/data/" + file);
    std::vector<std::vector<std::string>> rows;
    bool names = true;
    for (std::string line; std::getline(in, line);) {
        if (line.empty() || line[0] == '#') continue;
        if (std::exchange(names, false)) continue;
        std::istringstream cells(line);
        rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    return rows;
}

TempFolder::TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "malus-test-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path_ = name;
}

TempFolder::~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

}  // namespace malus
