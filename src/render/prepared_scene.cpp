// prepared_scene.cpp — paints brought to the wavelengths of a render.
// SPDX-License-Identifier: Apache-2.0
#include "render/prepared_scene.h"

#include <limits>
#include <set>

#include "malus/core/contract.h"

namespace malus {
namespace {

std::vector<PriestGermer<double>> rows_at(const Material& material,
                                          std::span<const double> wavelengths_nm) {
    std::vector<PriestGermer<double>> rows;
    for (double nm : wavelengths_nm) rows.push_back(parameters_at(material, nm));
    return rows;
}

// Registers of a pair of wavelengths; where there is no second, the first stands for it.
PreparedPriestGermer<Lanes> in_lanes(const std::vector<PreparedPriestGermer<double>>& rows,
                                     std::size_t pair) {
    const auto lanes = [&](const auto& parameter) {
        return lanewise<Lanes>([&](std::size_t i) {
            return parameter(rows[std::min(2 * pair + i / kSide, rows.size() - 1)]);
        });
    };
    using P = PreparedPriestGermer<double>;
    return {
        {lanes([](const P& p) { return p.contrast.re; }),
         lanes([](const P& p) { return p.contrast.im; })},
        {lanes([](const P& p) { return p.P.peak; }), lanes([](const P& p) { return p.P.width; })},
        {lanes([](const P& p) { return p.SO.fall; }),
         lanes([](const P& p) { return p.SO.inv_omega; })},
        lanes([](const P& p) { return p.rho_d; }),
        lanes([](const P& p) { return p.rho_v; })};
}

// Least RMS slope of a paint that reflects by facets; infinity where it does not.
double sharpest_slope(const Material& material, std::span<const double> wavelengths_nm) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& row : rows_at(material, wavelengths_nm))
        if (row.B > 0) least = std::min(least, row.sigma);
    return least;
}

// Of the paints in use.
double sharpest_slope(const std::vector<int>& paints, const std::vector<Material>& materials,
                      std::span<const double> wavelengths_nm) {
    double least = std::numeric_limits<double>::infinity();
    for (int paint : std::set<int>(paints.begin(), paints.end()))
        least = std::min(
            least, sharpest_slope(materials[static_cast<std::size_t>(paint)], wavelengths_nm));
    return least;
}

}  // namespace

Surface::Surface(const Material& material, std::span<const double> wavelengths_nm)
    : slopes_(material.slopes),
      attenuation_(material.attenuation),
      directions_(rows_at(material, wavelengths_nm), material.slopes),
      sharpest_slope_(malus::sharpest_slope(material, wavelengths_nm)) {
    std::vector<PreparedPriestGermer<double>> rows;
    for (const auto& row : rows_at(material, wavelengths_nm))
        rows.push_back(prepared(row, slopes_));
    for (std::size_t i = 0; i < pairs(rows.size()); ++i) rows_.push_back(in_lanes(rows, i));
}

PreparedScene::Impl::Impl(Scene s, std::vector<int> p, const std::vector<Material>& materials,
                          const Sky& map, std::vector<double> nm)
    : scene(std::move(s)),
      paints(std::move(p)),
      wavelengths_nm(std::move(nm)),
      sky(map, wavelengths_nm, sharpest_slope(paints, materials, wavelengths_nm)),
      sun(map, wavelengths_nm),
      accel(scene) {
    EXPECT(paints.size() == scene.instances.size());
    // Only paints in use must cover the wavelengths.
    std::vector<int> surface_of(materials.size(), -1);
    for (int& paint : paints) {
        const auto m = static_cast<std::size_t>(paint);
        if (surface_of[m] < 0) {
            surface_of[m] = static_cast<int>(surfaces.size());
            surfaces.emplace_back(materials[m], wavelengths_nm);
        }
        paint = surface_of[m];
    }
}

PreparedScene::PreparedScene(Scene scene, std::vector<int> paints,
                             const std::vector<Material>& materials, const Sky& sky,
                             std::vector<double> wavelengths_nm)
    : impl_(std::make_unique<Impl>(std::move(scene), std::move(paints), materials, sky,
                                   std::move(wavelengths_nm))) {}

PreparedScene::~PreparedScene() = default;
PreparedScene::PreparedScene(PreparedScene&&) noexcept = default;
PreparedScene& PreparedScene::operator=(PreparedScene&&) noexcept = default;

const Scene& PreparedScene::scene() const {
    return impl_->scene;
}
const std::vector<double>& PreparedScene::wavelengths_nm() const {
    return impl_->wavelengths_nm;
}

const SkyResampling& PreparedScene::sky_resampling() const {
    return impl_->sky.resampling();
}

}  // namespace malus
