// sky_monte_carlo.cpp — random walks against the light.
// SPDX-License-Identifier: Apache-2.0
#include "support/sky_monte_carlo.h"

#include <algorithm>
#include <cmath>

#include "malus/core/vec.h"
#include "support/statistics.h"

namespace malus::sky_monte_carlo {
namespace {

// What becomes of fields along the plane of scattering and across it:
//   ⟨E_a²⟩' = along ⟨E_a²⟩ + exchange ⟨E_c²⟩,  ⟨E_c²⟩' = exchange ⟨E_a²⟩ + across ⟨E_c²⟩,
//   ⟨E_a E_c⟩' = correlation ⟨E_a E_c⟩;  natural light in: F11, of mean 1 over the sphere
struct Powers {
    double along, across, exchange, correlation;

    double F11() const { return 0.5 * (along + across) + exchange; }
};

// Dipoles send D of the light; the rest goes out evenly, natural.
double dipole_share(const Molecules& air) {
    return (1 - air.depolarization) / (1 + air.depolarization / 2);
}
Powers powers(const Molecules& air, double c) {
    const double D = dipole_share(air), even = 0.5 * (1 - D);
    return {1.5 * D * c * c + even, 1.5 * D + even, even, 1.5 * D * c};
}
Powers powers(const HenyeyGreenstein& haze, double c) {
    const double g = haze.asymmetry, x = 1 + g * g - 2 * g * c;
    const double F11 = (1 - g * g) / (x * std::sqrt(x));
    const double polarized = haze.polarization * (1 - c * c) / (1 + c * c);
    return {F11 * (1 - polarized), F11 * (1 + polarized), 0, F11 * 2 * c / (1 + c * c)};
}

// cosΘ, distributed as F11.
double drawn_cosine(const Molecules& air, Uniform& random) {
    // ¾ D (1 + c²) + 1 − D = (1 − D/4) · 1 + D/4 · 3c²
    const bool even = random() > dipole_share(air) / 4;
    const double u = 2 * random() - 1;
    return even ? u : std::cbrt(u);
}
double drawn_cosine(const HenyeyGreenstein& haze, Uniform& random) {
    const double g = haze.asymmetry;
    const double x = (1 - g * g) / (1 + g * (2 * random() - 1));
    return std::clamp((1 + g * g - x * x) / (2 * g), -1.0, 1.0);
}

// Reads W_xx ⟨E_x²⟩ + 2 W_xy ⟨E_x E_y⟩ + W_yy ⟨E_y²⟩ of a beam.
struct Analyzer {
    double xx, xy, yy;

    // The same on the axes (c, s) and (−s, c).
    Analyzer on_axes(double c, double s) const {
        return {xx * c * c + 2 * xy * c * s + yy * s * s, (yy - xx) * c * s + xy * (c * c - s * s),
                xx * s * s - 2 * xy * c * s + yy * c * c};
    }
    // What it reads of natural light of intensity 1.
    double of_natural() const { return 0.5 * (xx + yy); }
    // Placed before the scatterer it reads what this one reads behind; x lies along on both sides.
    Analyzer before(const Powers& p) const {
        return {xx * p.along + yy * p.exchange, xy * p.correlation,
                xx * p.exchange + yy * p.across};
    }
};
Analyzer operator*(double f, const Analyzer& a) {
    return {f * a.xx, f * a.xy, f * a.yy};
}

// Where the walk goes, and the axes of the light that comes against it.
struct Heading {
    Vec3 w, x, y;
};
Heading heading(double zenith, double azimuth) {
    const Vec3 side{std::cos(azimuth), -std::sin(azimuth), 0}, up{0, 0, 1};
    const Vec3 w = std::sin(zenith) * side + std::cos(zenith) * up;
    const Vec3 x = std::sin(zenith) * up - std::cos(zenith) * side;
    return {w, x, cross(-w, x)};
}

struct Layer {
    struct Kind {
        double share;  // of what the layer scatters
        Particles particles;
    };
    std::vector<Kind> kinds;
    double bottom;  // optical depth below it
    double albedo = 0;

    Powers powers_at(double c) const {
        Powers sum{};
        for (const auto& [share, particles] : kinds) {
            const Powers p =
                std::visit([&](auto& kind) { return powers(kind, c); }, particles.kind);
            sum = {sum.along + share * p.along, sum.across + share * p.across,
                   sum.exchange + share * p.exchange, sum.correlation + share * p.correlation};
        }
        return sum;
    }
    double cosine(Uniform& random) const {
        double u = random();
        std::size_t i = 0;
        while (i + 1 < kinds.size() && u >= kinds[i].share) u -= kinds[i++].share;
        return std::visit([&](auto& kind) { return drawn_cosine(kind, random); },
                          kinds[i].particles.kind);
    }
};

class Walker {
  public:
    Walker(const Air& air, double sun_zenith)
        : sun_(heading(sun_zenith, 0).w), ground_albedo_(air.ground_albedo) {
        for (auto mixture = air.layers.rbegin(); mixture != air.layers.rend(); ++mixture) {
            Layer layer;
            layer.bottom = depth_;
            double extinct = 0, scattered = 0;
            for (const Particles& p : *mixture) {
                extinct += p.optical_depth;
                scattered += p.optical_depth * p.albedo;
            }
            for (const Particles& p : *mixture)
                layer.kinds.push_back({p.optical_depth * p.albedo / scattered, p});
            layer.albedo = scattered / extinct;
            depth_ += extinct;
            layers_.push_back(layer);
        }
    }

    // One walk's I, Q and U.
    Stokes operator()(Heading to, Uniform& random) {
        // The first step ends in the air always; the weight says how likely that is.
        const double stays = -std::expm1(-depth_ / to.w.z);
        read_ = {stays * Analyzer{1, 0, 1}, stays * Analyzer{1, 0, -1}, stays * Analyzer{0, 1, 0}};
        sum_ = {};
        double below = -std::log1p(-stays * random()) * to.w.z;  // optical depth
        while (below < depth_) {
            // What air and ground absorb ends the walk with the chance of that.
            if (below > 0) {
                const Layer& layer = layer_at(below);
                add_sun(to, layer, below);
                if (random() >= layer.albedo) break;
                to = scattered(to, layer, random);
            } else {
                below = 0;
                add_sunlit_ground();
                if (random() >= ground_albedo_) break;
                to = reflected(random);
            }
            below -= std::log(random()) * to.w.z;
        }
        return sum_;
    }

  private:
    const Layer& layer_at(double below) const {
        std::size_t i = layers_.size() - 1;
        while (below < layers_[i].bottom) --i;
        return layers_[i];
    }
    double sunlight(double below) const { return std::exp((below - depth_) / sun_.z); }

    void add_sun(const Heading& to, const Layer& layer, double below) {
        const double u = dot(to.x, sun_), v = dot(to.y, sun_), sine = std::sqrt(u * u + v * v);
        // Straight on or back, any plane holds both beams.
        const double cos_turn = sine > 0 ? u / sine : 1, sin_turn = sine > 0 ? v / sine : 0;
        const Powers p = layer.powers_at(dot(to.w, sun_));
        const double scattered = layer.albedo / (4 * kPi) * sunlight(below);
        for (std::size_t i = 0; i < 3; ++i)
            sum_[i] += scattered * read_[i].on_axes(cos_turn, sin_turn).before(p).of_natural();
    }
    Heading scattered(const Heading& to, const Layer& layer, Uniform& random) {
        const double c = layer.cosine(random), s = std::sqrt((1 - c) * (1 + c));
        const double turn = 2 * kPi * random(), cos_turn = std::cos(turn),
                     sin_turn = std::sin(turn);
        const Powers p = layer.powers_at(c);
        for (Analyzer& a : read_) a = (1 / p.F11()) * a.on_axes(cos_turn, sin_turn).before(p);
        const Vec3 along = cos_turn * to.x + sin_turn * to.y;
        return {c * to.w + s * along, c * along - s * to.w, cos_turn * to.y - sin_turn * to.x};
    }

    // The ground sends π⁻¹ of what it reflects into each direction, natural.
    void add_sunlit_ground() {
        for (std::size_t i = 0; i < 3; ++i)
            sum_[i] += ground_albedo_ / kPi * sun_.z * sunlight(0) * read_[i].of_natural();
    }
    Heading reflected(Uniform& random) {
        for (Analyzer& a : read_) a = a.of_natural() * Analyzer{1, 0, 1};
        const double sine = std::sqrt(random());
        return heading(std::asin(sine), 2 * kPi * random());
    }

    Vec3 sun_;
    double ground_albedo_, depth_ = 0;
    std::vector<Layer> layers_;  // from below
    std::array<Analyzer, 3> read_{};
    Stokes sum_{};
};

}  // namespace

Estimate random_walks(const Air& air, double sun_zenith, double zenith, double azimuth, int walks,
                      unsigned seed) {
    Walker walk(air, sun_zenith);
    Uniform random(seed);
    const Heading view = heading(zenith, azimuth);
    Stokes sum{}, squares{};
    for (int i = 0; i < walks; ++i) {
        const Stokes S = walk(view, random);
        for (std::size_t c = 0; c < 3; ++c) {
            sum[c] += S[c];
            squares[c] += S[c] * S[c];
        }
    }
    Estimate result;
    for (std::size_t c = 0; c < 3; ++c) {
        result.mean[c] = sum[c] / walks;
        result.error[c] = std::sqrt((squares[c] / walks - sqr(result.mean[c])) / (walks - 1));
    }
    return result;
}

}  // namespace malus::sky_monte_carlo
