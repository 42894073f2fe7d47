// direction_sampler.cpp — lobes of facets by inversion, and their mixture.
// SPDX-License-Identifier: Apache-2.0
#include "render/direction_sampler.h"

#include <algorithm>

namespace malus {
namespace {

const double kInvSqrtPi = 1 / std::sqrt(kPi);

// y with ½ erfc(−y) = u: a slope of density e^{−y²}/√π. Winitzki's approximation (2008; 2e-3),
// then one step of Halley, which leaves 1e-8.
double gaussian_slope(double u) {
    constexpr double a = 0.147;
    const double log_term = std::log(4 * u * (1 - u));
    const double b = 2 / (kPi * a) + 0.5 * log_term;
    const double y0 =
        std::copysign(std::sqrt(std::max(0.0, std::sqrt(b * b - log_term / a) - b)), u - 0.5);
    const double error = u < 0.5 ? 0.5 * std::erfc(-y0) - u : (1 - u) - 0.5 * std::erfc(y0);
    const double newton = error / (kInvSqrtPi * std::exp(-y0 * y0));
    return y0 - newton / (1 + y0 * newton);
}

// A view stretched so that slopes have unit roughness: cosine and sine to the normal, and the
// stretched length.
struct StretchedView {
    double cos, sin, length;
};
StretchedView stretched(const Vec3& wo, double alpha) {
    const double across = alpha * std::sqrt(wo.x * wo.x + wo.y * wo.y);
    const double norm = std::sqrt(across * across + wo.z * wo.z);
    return {wo.z / norm, across / norm, norm};
}

// ∫_{−∞}^{X} (cos − x sin) e^{−x²}/√π dx: facets of slope below X, weighed by how much the view
// sees of them.
double seen_below(const StretchedView& view, double X) {
    return 0.5 * view.cos * std::erfc(-X) + 0.5 * view.sin * kInvSqrtPi * std::exp(-X * X);
}

// The steepest slope that the view sees, cot of its stretched angle.
double last_slope(const StretchedView& view) {
    return view.sin > 0 ? view.cos / view.sin : HUGE_VAL;
}

// X with seen_below(X) = u · seen_below(last): Newton's method kept inside a shrinking bracket.
double visible_slope(const StretchedView& view, double u) {
    double low = -6.5, high = std::min(last_slope(view), 6.5);
    const double target = u * seen_below(view, last_slope(view));
    // Exact for a view along the normal, near for others: the visible slopes' mean is shifted.
    double X = std::clamp(gaussian_slope(u) - 0.5 * view.sin * (1 - 0.3 * view.cos), low, high);
    for (int i = 0; i < 40; ++i) {
        const double gauss = kInvSqrtPi * std::exp(-X * X);
        const double error = 0.5 * view.cos * std::erfc(-X) + 0.5 * view.sin * gauss - target;
        (error > 0 ? high : low) = X;
        const double density = (view.cos - X * view.sin) * gauss;
        double next = density > 0 ? X - error / density : HUGE_VAL;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (std::abs(next - X) < 1e-9) return next;
        X = next;
    }
    return X;
}

Vec3 reflect(const Vec3& wo, const Vec3& h) {
    return 2 * dot(wo, h) * h - wo;
}

Vec3 cosine_hemisphere(double u1, double u2) {
    const double r = std::sqrt(u1), phi = 2 * kPi * u2;
    return {r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - u1)};
}

// A facet normal of the Beckmann distribution as seen from wo.
Vec3 visible_normal(const Vec3& wo, double sigma, double u1, double u2) {
    const double alpha = std::sqrt(2.0) * sigma;
    const double along = alpha * visible_slope(stretched(wo, alpha), u1);
    const double across = alpha * gaussian_slope(u2);
    // Slopes are along and across the view's azimuth; the normal is (−slope, 1).
    const double r = std::sqrt(wo.x * wo.x + wo.y * wo.y);
    const double c = r > 0 ? wo.x / r : 1, s = r > 0 ? wo.y / r : 0;
    return normalize(Vec3{-(c * along - s * across), -(s * along + c * across), 1});
}

// tan²θ of Cauchy slopes by inversion of ∫ dt/((1+t)(a+t)) = ln[(a+t)/(a(1+t))]/(1−a), a = σ².
double cauchy_tan2(double sigma, double u) {
    const double a = sigma * sigma, log_a = std::log(a);
    if (std::abs(log_a) < 1e-9) return u / (1 - u);
    return a * std::expm1(-u * log_a) / -std::expm1((1 - u) * log_a);
}

// ∫ P dΩ / B of Cauchy slopes: π ln(1/a)/(1−a).
double cauchy_norm(double sigma) {
    const double a = sigma * sigma;
    return std::abs(a - 1) < 1e-9 ? kPi : -kPi * std::log(a) / (1 - a);
}

Vec3 cauchy_normal(double sigma, double u1, double u2) {
    const double tan_theta = std::sqrt(cauchy_tan2(sigma, u1)), phi = 2 * kPi * u2;
    return normalize(Vec3{tan_theta * std::cos(phi), tan_theta * std::sin(phi), 1});
}

// What facets and volume of a row reflect at this view, about.
struct Parts {
    double facets, volume;
};
Parts reflected_parts(const PriestGermer<double>& p, Slopes slopes, double cos_o) {
    const double norm = slopes == Slopes::kGaussian ? 1 : cauchy_norm(p.sigma);
    // f_vol is monotone in cosθi: if it is positive anywhere, it is so at one of the ends.
    const auto f_vol = [&](double cos_i) {
        return volume(p.rho_d, p.rho_v, cos_i, std::max(cos_o, 0.1));
    };
    return {p.B * norm * fresnel(p.n, p.k, cos_o).a(),
            kPi * std::max({f_vol(0.5), 0.25 * f_vol(0), 0.25 * f_vol(1)})};
}

}  // namespace

DirectionSampler::DirectionSampler(std::span<const PriestGermer<double>> rows, Slopes slopes)
    : slopes_(slopes) {
    // Lobes, from the roughest down: each takes the rows that are smoother by up to a fifth.
    std::vector<double> sigmas;
    for (const PriestGermer<double>& p : rows)
        if (p.B > 0) sigmas.push_back(p.sigma);
    std::sort(sigmas.begin(), sigmas.end(), std::greater<>());
    double ratio = 1.2;
    do {
        sigmas_.clear();
        for (double sigma : sigmas)
            if (sigmas_.empty() || sigma * ratio < sigmas_.back()) sigmas_.push_back(sigma);
        ratio *= 1.2;
    } while (sigmas_.size() > kMostLobes);

    for (std::size_t i = 0; i < kViews; ++i) {
        const double cos_o = std::max(1e-3, static_cast<double>(i) / (kViews - 1));
        shares_[i] = shares_for(rows, cos_o);
        for (const PriestGermer<double>& p : rows) {
            const Parts parts = reflected_parts(p, slopes, cos_o);
            if (parts.facets + parts.volume > 0) black_ = false;
        }
    }
}

// A wavelength's error² from light that a part carries falls as (its fraction)²/share; the sum over
// the wavelengths is least when share ∝ √Σ fraction².
DirectionSampler::Shares DirectionSampler::shares_for(std::span<const PriestGermer<double>> rows,
                                                      double cos_o) const {
    Shares shares;
    // No part may starve: its share bounds the weight of its light.
    const auto add = [](double& share, double fraction) {
        share += sqr(std::clamp(fraction, 0.1, 0.9));
    };
    for (const PriestGermer<double>& p : rows) {
        const Parts parts = reflected_parts(p, slopes_, cos_o);
        const double whole = parts.facets + parts.volume;
        if (!(whole > 0)) continue;
        if (parts.volume > 0) add(shares.volume, parts.volume / whole);
        if (parts.facets > 0) add(shares.lobe[lobe_of(p.sigma)], parts.facets / whole);
    }
    shares.volume = std::sqrt(shares.volume);
    double sum = shares.volume;
    for (double& share : shares.lobe) {
        share = std::sqrt(share);
        sum += share;
    }
    if (!(sum > 0)) return {1, {}};
    shares.volume /= sum;
    for (double& share : shares.lobe) share /= sum;
    return shares;
}

// The smoothest lobe that is as rough as sigma.
std::size_t DirectionSampler::lobe_of(double sigma) const {
    std::size_t j = 0;
    while (j + 1 < sigmas_.size() && sigma <= sigmas_[j + 1]) ++j;
    return j;
}

DirectionSampler::Shares DirectionSampler::shares_at(double cos_o) const {
    const double x = std::min(cos_o, 1.0) * (kViews - 1);
    const auto i = std::min(static_cast<std::size_t>(x), kViews - 2);
    const double t = x - static_cast<double>(i);
    const auto between = [t](double a, double b) { return (1 - t) * a + t * b; };
    Shares shares{between(shares_[i].volume, shares_[i + 1].volume), {}};
    for (std::size_t j = 0; j < sigmas_.size(); ++j)
        shares.lobe[j] = between(shares_[i].lobe[j], shares_[i + 1].lobe[j]);
    return shares;
}

DirectionSampler::View::View(const DirectionSampler& sampler, const Vec3& wo)
    : sampler_(sampler), wo_(wo), share_(sampler.shares_at(wo.z)), visible_area_{} {
    if (sampler.slopes_ != Slopes::kGaussian) return;
    for (std::size_t j = 0; j < sampler.sigmas_.size(); ++j) {
        const StretchedView view = stretched(wo, std::sqrt(2.0) * sampler.sigmas_[j]);
        visible_area_[j] = view.length * seen_below(view, last_slope(view));
    }
}

Vec3 DirectionSampler::View::sample(double u_lobe, double u1, double u2) const {
    double rest = u_lobe - share_.volume;
    if (rest < 0 || sampler_.sigmas_.empty()) return cosine_hemisphere(u1, u2);
    std::size_t j = 0;
    while (j + 1 < sampler_.sigmas_.size() && rest >= share_.lobe[j]) rest -= share_.lobe[j++];
    const double sigma = sampler_.sigmas_[j];
    const Vec3 h = sampler_.slopes_ == Slopes::kGaussian ? visible_normal(wo_, sigma, u1, u2)
                                                         : cauchy_normal(sigma, u1, u2);
    return reflect(wo_, h);
}

double DirectionSampler::View::pdf(const Vec3& wi) const {
    if (!(wi.z > 0)) return 0;
    const Vec3 sum = wi + wo_;
    const double norm2 = dot(sum, sum);
    const double cos2 = sum.z * sum.z / norm2;
    const double tan2 = (sum.x * sum.x + sum.y * sum.y) / (sum.z * sum.z);
    const double wo_h = 0.5 * std::sqrt(norm2);
    double facets = 0;
    for (std::size_t j = 0; j < sampler_.sigmas_.size(); ++j) {
        const double sigma = sampler_.sigmas_[j], share = share_.lobe[j];
        if (sampler_.slopes_ == Slopes::kGaussian) {
            const double alpha2 = 2 * sigma * sigma;
            const double D = std::exp(-tan2 / alpha2) / (kPi * alpha2 * cos2 * cos2);
            facets += share * D / (4 * visible_area_[j]);
        } else {
            const double P = 1 / (std::sqrt(cos2) * (sigma * sigma + tan2));
            facets += share * P / (4 * wo_h * cauchy_norm(sigma));
        }
    }
    return share_.volume * wi.z / kPi + facets;
}

}  // namespace malus
