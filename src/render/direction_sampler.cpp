// direction_sampler.cpp — lobes of facets by inversion, and their mixture.
// SPDX-License-Identifier: Apache-2.0
#include "render/direction_sampler.h"

#include <algorithm>

namespace malus {
namespace {

// A view stretched so that slopes have unit roughness: cosine and sine to the normal, and the
// stretched length.
template <class R>
struct StretchedView {
    R cos, sin, length;
};
template <class R>
StretchedView<R> stretched(const Vector3<R>& wo, const R& alpha) {
    using std::sqrt;
    const R across = alpha * sqrt(wo.x * wo.x + wo.y * wo.y);
    const R norm = sqrt(across * across + wo.z * wo.z);
    return {wo.z / norm, across / norm, norm};
}

// Slopes beyond have no weight in a double.
constexpr double kSteepest = 6.5;

// The steepest slope that the view sees, cot of its stretched angle, or kSteepest.
template <class R>
R last_slope(const StretchedView<R>& view) {
    using std::max, std::min;
    const R steepest = real<R>(kSteepest);
    return min(steepest, view.cos / max(view.sin, view.cos / (steepest + steepest)));
}

// ∫_{−∞}^{X} (cos − x sin) e^{−x²}/√π dx: facets of slope below X, weighed by how much the view
// sees of them.
template <class R>
R seen_below(const StretchedView<R>& view, const GaussTail<R>& minus_X) {
    return real<R>(0.5) * (view.cos * minus_X.erfc + view.sin * minus_X.gauss);
}

// X with seen_below(X) = u · seen_below(last), from a first guess: Halley's method kept inside a shrinking
// bracket. `at_last`: of −last_slope().
template <class R>
R visible_slope(const StretchedView<R>& view, const GaussTail<R>& at_last, const R& u,
                const R& guess) {
    using std::abs, std::max, std::min, std::sqrt;
    const R half = real<R>(0.5), one = real<R>(1), last = last_slope(view);
    R low = real<R>(-kSteepest), high = last;
    const R area = seen_below(view, at_last), target = u * area;
    // What is seen falls to 0 at the last slope: from there the root is nearly that of a square.
    const auto near_last = guess > last - real<R>(0.1);
    const R beyond = (one - u) * area / max(view.sin * at_last.gauss, real<R>(1e-30));
    R X = max(select(near_last, last - sqrt(beyond + beyond), guess), low);
    for (int i = 0; i < 40; ++i) {
        const GaussTail<R> tail = gauss_tail(-X);
        const R error = seen_below(view, tail) - target;
        const auto above = error > real<R>(0);
        high = select(above, X, high);
        low = select(above, low, X);
        const R weight = view.cos - X * view.sin, density = weight * tail.gauss;
        const R slope = -view.sin * tail.gauss - (X + X) * density;  // of the density
        const R divisor = density * density - half * error * slope;
        const auto sound = divisor > real<R>(0);
        R next = X - error * density / select(sound, divisor, one);
        const auto inside = sound && (next > low) && (next < high);
        next = select(inside, next, half * (low + high));
        const R step = abs(next - X);
        X = next;
        // The error after a step is of its cube.
        if (!any(step > real<R>(3e-3) * min(last - X, one))) break;
    }
    return X;
}

// First guesses of visible slopes, which are functions of u and of the stretched view alone: in between nodes,
// even in √u/(√u + √(1−u)) and in sin/(sin + cos), linear. Of 1000 slopes 6 are off by more than 0.003 (or that
// part of the way to the last slope), and take two steps instead of one.
class SlopeGuesses {
  public:
    SlopeGuesses() {
        for (std::size_t j = 0; j <= kViews; ++j)
            for (std::size_t i = 0; i <= kNumbers; ++i) {
                const double p = static_cast<double>(i) / kNumbers,
                             a = static_cast<double>(j) / kViews, norm = std::hypot(a, 1 - a);
                const double u = std::clamp(sqr(p) / (sqr(p) + sqr(1 - p)), 1e-7, 1 - 1e-12);
                const StretchedView<double> view{std::max(1 - a, 1e-6) / norm, a / norm, 1};
                const double last = last_slope(view);
                slope_[j][i] = visible_slope(view, gauss_tail(-last), u, 0.5 * (last - kSteepest));
            }
    }

    template <class R>
    R operator()(const StretchedView<R>& view, const R& u) const {
        using std::floor, std::max, std::min, std::sqrt;
        const R root = sqrt(u), other = sqrt(max(real<R>(1) - u, real<R>(0)));
        const R p = real<R>(kNumbers) * root / (root + other);
        const R a = real<R>(kViews) * view.sin / (view.sin + view.cos);
        const R i = min(floor(p), real<R>(kNumbers - 1)), j = min(floor(a), real<R>(kViews - 1));
        const auto number = stored(i), row = stored(j);
        const auto node = [&](std::size_t down, std::size_t right) {
            return lanewise<R>([&](std::size_t l) {
                return slope_[static_cast<std::size_t>(row[l]) + down]
                             [static_cast<std::size_t>(number[l]) + right];
            });
        };
        const R at = p - i;
        const R upper = node(0, 0) + at * (node(0, 1) - node(0, 0)),
                lower = node(1, 0) + at * (node(1, 1) - node(1, 0));
        return upper + (a - j) * (lower - upper);
    }

  private:
    static constexpr std::size_t kNumbers = 64, kViews = 32;
    std::array<std::array<double, kNumbers + 1>, kViews + 1> slope_;
};

template <class R>
Vector3<R> reflect(const Vector3<R>& wo, const Vector3<R>& h) {
    const R twice = dot(wo, h) + dot(wo, h);
    return twice * h - wo;
}

template <class R>
Vector3<R> cosine_hemisphere(const R& u1, const R& u2) {
    using std::sqrt;
    const R r = sqrt(u1);
    const CosSin<R> at = cos_sin(real<R>(2 * kPi) * u2);
    return {r * at.cos, r * at.sin, sqrt(real<R>(1) - u1)};
}

// A facet normal of the Beckmann distribution as seen from wo.
template <class R>
Vector3<R> visible_normal(const Vector3<R>& wo, const R& sigma, const GaussTail<R>& at_last,
                          const R& u1, const R& u2) {
    using std::sqrt;
    const R one = real<R>(1), zero = real<R>(0);
    const R alpha = real<R>(std::sqrt(2.0)) * sigma;
    static const SlopeGuesses guesses;
    const StretchedView<R> view = stretched(wo, alpha);
    const R along = alpha * visible_slope(view, at_last, u1, guesses(view, u1));
    const R across = alpha * gaussian_slope(u2);
    // Slopes are along and across the view's azimuth; the normal is (−slope, 1).
    const R r = sqrt(wo.x * wo.x + wo.y * wo.y);
    const auto tilted = r > zero;
    const R safe = select(tilted, r, one);
    const R c = select(tilted, wo.x / safe, one), s = wo.y / safe;
    return normalize(Vector3<R>{-(c * along - s * across), -(s * along + c * across), one});
}

// tan²θ of Cauchy slopes by inversion of ∫ dt/((1+t)(a+t)) = ln[(a+t)/(a(1+t))]/(1−a), a = σ².
template <class R>
R cauchy_tan2(const R& sigma, const R& u) {
    using std::abs, std::expm1, std::log;
    const R one = real<R>(1), a = sigma * sigma, log_a = log(a);
    const auto even = abs(log_a) < real<R>(1e-9);
    const R b = select(even, one, log_a);
    return select(even, u / (one - u), a * expm1(-u * b) / -expm1((one - u) * b));
}

// ∫ P dΩ / B of Cauchy slopes: π ln(1/a)/(1−a).
double cauchy_norm(double sigma) {
    const double a = sigma * sigma;
    return std::abs(a - 1) < 1e-9 ? kPi : -kPi * std::log(a) / (1 - a);
}

template <class R>
Vector3<R> cauchy_normal(const R& sigma, const R& u1, const R& u2) {
    using std::sqrt;
    const R tan_theta = sqrt(cauchy_tan2(sigma, u1));
    const CosSin<R> at = cos_sin(real<R>(2 * kPi) * u2);
    return normalize(Vector3<R>{tan_theta * at.cos, tan_theta * at.sin, real<R>(1)});
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

template <class R>
DirectionSampler::View<R>::View(const DirectionSampler& sampler, const Vector3<R>& wo)
    : sampler_(sampler), wo_(wo) {
    using std::min;
    const auto x = stored(min(wo.z, real<R>(1)) * real<R>(kViews - 1));
    std::array<std::size_t, kLaneCount<R>> node;
    for (std::size_t i = 0; i < node.size(); ++i)
        node[i] = std::min(static_cast<std::size_t>(x[i]), kViews - 2);
    const auto between = [&](const auto& share) {
        return lanewise<R>([&](std::size_t i) {
            const double t = x[i] - static_cast<double>(node[i]);
            return (1 - t) * share(sampler.shares_[node[i]]) +
                   t * share(sampler.shares_[node[i] + 1]);
        });
    };
    volume_share_ = between([](const Shares& shares) { return shares.volume; });
    for (std::size_t j = 0; j < sampler.sigmas_.size(); ++j) {
        lobe_share_[j] = between([j](const Shares& shares) { return shares.lobe[j]; });
        at_last_[j] = {};
        if (sampler.slopes_ != Slopes::kGaussian) continue;
        const StretchedView<R> view = stretched(wo, real<R>(std::sqrt(2.0) * sampler.sigmas_[j]));
        at_last_[j] = gauss_tail(R(-last_slope(view)));
        visible_area_[j] = view.length * seen_below(view, at_last_[j]);
    }
}

template <class R>
Vector3<R> DirectionSampler::View<R>::sample(const R& u_lobe, const R& u1, const R& u2) const {
    const R zero = real<R>(0);
    R rest = u_lobe - volume_share_;
    const auto by_volume = rest < zero;
    if (sampler_.sigmas_.empty()) return cosine_hemisphere(u1, u2);
    R sigma = real<R>(sampler_.sigmas_.front());
    GaussTail<R> at_last = at_last_.front();
    for (std::size_t j = 0; j + 1 < sampler_.sigmas_.size(); ++j) {
        rest = rest - lobe_share_[j];
        const auto further = rest >= zero;
        sigma = select(further, real<R>(sampler_.sigmas_[j + 1]), sigma);
        at_last = {select(further, at_last_[j + 1].gauss, at_last.gauss),
                   select(further, at_last_[j + 1].erfc, at_last.erfc)};
    }
    const Vector3<R> h = sampler_.slopes_ == Slopes::kGaussian
                             ? visible_normal(wo_, sigma, at_last, u1, u2)
                             : cauchy_normal(sigma, u1, u2);
    const Vector3<R> wi = reflect(wo_, h);
    return any(by_volume) ? select(by_volume, cosine_hemisphere(u1, u2), wi) : wi;
}

template <class R>
R DirectionSampler::View<R>::pdf(const Vector3<R>& wi) const {
    using std::sqrt;
    const R zero = real<R>(0), one = real<R>(1), four = real<R>(4);
    const auto above = wi.z > zero;
    const Vector3<R> sum = wi + wo_;
    const R norm2 = dot(sum, sum), z2 = select(above, sum.z * sum.z, one);
    const R cos2 = z2 / norm2;
    const R tan2 = (sum.x * sum.x + sum.y * sum.y) / z2;
    R facets = zero;
    for (std::size_t j = 0; j < sampler_.sigmas_.size(); ++j) {
        const double sigma = sampler_.sigmas_[j];
        if (sampler_.slopes_ == Slopes::kGaussian) {
            const R alpha2 = real<R>(2 * sigma * sigma);
            const R D = decay(-tan2 / alpha2) / (real<R>(kPi) * alpha2 * cos2 * cos2);
            facets = facets + lobe_share_[j] * D / (four * visible_area_[j]);
        } else {
            const R wo_h = real<R>(0.5) * sqrt(norm2);
            const R P = one / (sqrt(cos2) * (real<R>(sigma * sigma) + tan2));
            facets = facets + lobe_share_[j] * P / (four * wo_h * real<R>(cauchy_norm(sigma)));
        }
    }
    return select(above, volume_share_ * wi.z * real<R>(1 / kPi) + facets, zero);
}

template class DirectionSampler::View<double>;
template class DirectionSampler::View<Reals>;

}  // namespace malus
