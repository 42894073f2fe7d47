// material_check.cpp — quadrature and rules for one row of a paint.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/material_check.h"

#include <array>
#include <cstdio>

namespace malus {
namespace {

const Vec3 kNormal{0, 0, 1};

// Far off the lobe the exponential leaves double's range; what is darker has no digits to judge.
constexpr double kDarkest = 1e-250;

Vec3 local_direction(double cos_theta, double phi) {
    const double sin_theta = std::sqrt((1 - cos_theta) * (1 + cos_theta));
    return {sin_theta * std::cos(phi), sin_theta * std::sin(phi), cos_theta};
}

// ∫ f00 cosθo dωo of the facets: midpoint rule over facet normals, in v with tanθ = σ v/(1−v) and
// half the azimuths (the other half is alike).
double facet_reflectance(const Material& material, const PriestGermer<double>& p, const Vec3& wi,
                         int steps) {
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double v = (i + 0.5) / steps, t = p.sigma * v / (1 - v);
        const double cos_theta = 1 / std::sqrt(1 + t * t);
        // sinθ dθ = t cos³θ dt
        const double ring = t * cos_theta * cos_theta * cos_theta * p.sigma / sqr(1 - v) / steps;
        for (int j = 0; j < steps; ++j) {
            const Vec3 h = local_direction(cos_theta, kPi * (j + 0.5) / steps);
            const double cos_beta = dot(wi, h);
            const Vec3 wo = 2 * cos_beta * h - wi;
            if (!(cos_beta > 0) || !(wo.z > 0)) continue;
            const auto f =
                eval(p, material.slopes, material.attenuation, reflection(kNormal, wi, wo));
            // dωo = 4 cosβ dω_h
            sum += f.facet.a() * wo.z * 4 * cos_beta * ring * 2 * kPi / steps;
        }
    }
    return sum;
}

double volume_reflectance(const PriestGermer<double>& p, double cos_i, int steps) {
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double cos_o = (i + 0.5) / steps;
        sum += volume(p.rho_d, p.rho_v, cos_i, cos_o) * cos_o * 2 * kPi / steps;
    }
    return sum;
}

// The facet matrix between its own frames, fed with the six pure states and natural light.
double most_dop(const BrdfMueller<double>& f) {
    double most = 0;
    for (const Stokes<double>& in :
         {Stokes<double>{1, 0, 0, 0}, Stokes<double>{1, 1, 0, 0}, Stokes<double>{1, -1, 0, 0},
          Stokes<double>{1, 0, 1, 0}, Stokes<double>{1, 0, -1, 0}, Stokes<double>{1, 0, 0, 1},
          Stokes<double>{1, 0, 0, -1}})
        if (const Stokes<double> out = f * in; out.s0 > kDarkest) most = std::max(most, dop(out));
    return most;
}

// |M(wo→wi) − D Mᵀ D| / m00, D = diag(1,1,−1,1): of the block form, b stays and im turns over twice.
double reciprocity(const BrdfMueller<double>& there, const BrdfMueller<double>& back) {
    const double m00 = there.facet.a() + there.volume;
    if (!(m00 > kDarkest)) return 0;
    return std::max({std::abs(there.facet.a() + there.volume - back.facet.a() - back.volume),
                     std::abs(there.facet.b() - back.facet.b()),
                     std::abs(there.facet.re - back.facet.re),
                     std::abs(there.facet.im - back.facet.im)}) /
           m00;
}

std::string formatted(const char* form, double a, double b = 0) {
    std::array<char, 200> text{};
    std::snprintf(text.data(), text.size(), form, a, b);
    return text.data();
}

}  // namespace

Reflectance reflectance(const Material& material, const MaterialRow& row, double zenith_deg) {
    const Vec3 wi = local_direction(std::cos(to_radians(zenith_deg)), 0);
    const auto with = [&](int steps) {
        return facet_reflectance(material, row.p, wi, steps) +
               volume_reflectance(row.p, wi.z, 16 * steps);
    };
    const double coarse = with(100), fine = with(200);
    return {zenith_deg, fine, std::abs(fine - coarse)};
}

RowCheck check_row(const Material& material, const MaterialRow& row) {
    RowCheck check{row.wavelength_nm, {}, HUGE_VAL, 0, 0, 0};
    for (double zenith_deg : {0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 80.0, 85.0, 89.0})
        check.reflectance.push_back(reflectance(material, row, zenith_deg));
    constexpr int kCosines = 40, kAzimuths = 24;
    double count = 0;
    for (int i = 0; i < kCosines; ++i)
        for (int o = 0; o < kCosines; ++o)
            for (int a = 0; a < kAzimuths; ++a) {
                const Vec3 wi = local_direction((i + 0.5) / kCosines, 0);
                const Vec3 wo = local_direction((o + 0.5) / kCosines, kPi * (a + 0.5) / kAzimuths);
                const auto f =
                    eval(row.p, material.slopes, material.attenuation, reflection(kNormal, wi, wo));
                const auto back =
                    eval(row.p, material.slopes, material.attenuation, reflection(kNormal, wo, wi));
                const double f00 = f.facet.a() + row.p.rho_d + 2 * row.p.rho_v / (wi.z + wo.z);
                check.least_f00 = std::min(check.least_f00, f00);
                check.share_negative += f00 < 0 ? 1 : 0;
                check.most_dop = std::max(check.most_dop, most_dop(f));
                check.reciprocity_error = std::max(check.reciprocity_error, reciprocity(f, back));
                count += 1;
            }
    check.share_negative /= count;
    return check;
}

std::vector<std::string> verdicts(const Material& material, const RowCheck& check) {
    std::vector<std::string> words;
    double most = 0, first_over = -1;
    for (const Reflectance& r : check.reflectance) {
        most = std::max(most, r.value);
        if (r.value > 1 && first_over < 0) first_over = r.zenith_deg;
    }
    if (first_over < 0)
        words.push_back(formatted("energy: reflects at most %.3g of what it receives", most));
    else
        words.push_back(
            formatted("energy: reflects more than it receives from %.0f degrees on (%.3g at most)",
                      first_over, most) +
            (material.attenuation == Attenuation::kNone
                 ? "; \"attenuation\": \"torrance-sparrow\" keeps facets within 1"
                 : "; B or rho are too large"));
    if (check.share_negative > 0)
        words.push_back(
            formatted("f00: as printed negative in %.0f %% of directions (least %.3g /sr)",
                      100 * check.share_negative, check.least_f00) +
            "; clamped to 0 there, mend the fit if you can");
    else
        words.push_back(formatted("f00: nowhere negative (least %.3g /sr)", check.least_f00));
    words.push_back(check.most_dop <= 1 + 1e-12
                        ? std::string("polarization: never more than whole")
                        : formatted("polarization: DoP up to 1 + %.2g", check.most_dop - 1));
    words.push_back(check.reciprocity_error < 1e-12
                        ? std::string("reciprocity: kept")
                        : formatted("reciprocity: broken by %.2g", check.reciprocity_error));
    return words;
}

}  // namespace malus
