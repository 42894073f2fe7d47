// radiative_transfer.cpp — adding-doubling for Stokes vectors (I, Q, U).
//
// Vectors and matrices run over nodes in μ, three components each. Light that comes in is known at
// the Gauss nodes only (columns); light that leaves also at the directions asked for (more rows).
// SPDX-License-Identifier: Apache-2.0
#include "scene/radiative_transfer.h"

#include <Eigen/Dense>
#include <algorithm>
#include <optional>

#include "malus/core/frame.h"
#include "malus/scene/sky.h"
#include "scene/scattering_expansion.h"

namespace malus {
namespace {

using Eigen::Index, Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector3d, Eigen::VectorXd;

constexpr int kNodes = 24, kNodesOfPeaks = 40;
constexpr double kPeak = 1e-4;      // share of light scattered straight on that asks for more nodes
constexpr double kThinnest = 1e-9;  // optical depth that scatters once
constexpr double kLeastMode = 1e-9;  // of mode 0: azimuth modes beyond are left out

// The directions of a calculation: Gauss nodes, then those asked for; the sun's.
struct Directions {
    GaussNodes nodes;
    std::vector<double> mu;
    double mu0;

    Index inner() const { return 3 * static_cast<Index>(nodes.x.size()); }
    Index all() const { return 3 * static_cast<Index>(mu.size()); }
};

// Where light goes: `mu` > 0 upward; from the sky at `azimuth` when it goes down.
Vec3 propagation(double mu, double azimuth) {
    const double s = std::sqrt((1 - mu) * (1 + mu));
    return {-s * std::sin(azimuth), mu, s * std::cos(azimuth)};
}

Stokes<double> scattered(const ScatteringElements& F, const Stokes<double>& S) {
    return {F.F11 * S.s0 + F.F12 * S.s1, F.F12 * S.s0 + F.F22 * S.s1, F.F33 * S.s2, 0};
}

// Z between meridian frames, as a matrix on (I, Q, U). `F` maps cosΘ to elements.
template <class Matrix>
Matrix3d phase_matrix(const Vec3& k_out, const Vec3& k_in, const Matrix& F) {
    const BeamFrame in = meridian_frame(-k_in), out = meridian_frame(-k_out);
    const Vec3 normal = cross(k_in, k_out);
    const double sine = length(normal);
    // Straight on or back every plane that holds the beam is a plane of scattering.
    const Vec3 s = sine > 1e-9 ? normal / sine : in.y();
    const Turn to_plane = turn_between(in, {k_in, cross(s, k_in)});
    const Vec3 in_plane = cross(s, k_out);
    const Turn from_plane = turn_between({k_out, in_plane / length(in_plane)}, out);
    const ScatteringElements elements = F(dot(k_in, k_out));
    Matrix3d Z;
    for (Index column = 0; column < 3; ++column) {
        const Stokes<double> unit{column == 0 ? 1. : 0., column == 1 ? 1. : 0.,
                                  column == 2 ? 1. : 0., 0};
        const Stokes<double> S = turned(scattered(elements, turned(unit, to_plane)), from_plane);
        Z.col(column) = Vector3d(S.s0, S.s1, S.s2);
    }
    return Z;
}

// A layer without its forward peak: optical depth, albedo and matrix of what is left.
class Medium {
  public:
    Medium(const std::vector<Scatterer>& mixture, int nodes)
        : mixture_(mixture), expansion_([this](double c) { return whole(c); }, 2 * nodes) {
        double depth = 0, scattering = 0;
        for (const Scatterer& kind : mixture_) {
            depth += kind.optical_depth;
            scattering += kind.optical_depth * kind.single_scattering_albedo;
        }
        tau = depth - peak() * scattering;
        albedo = tau > 0 ? scattering * (1 - peak()) / tau : 0;
    }

    double tau, albedo;

    double peak() const { return expansion_.peak(); }
    int degree() const { return expansion_.degree(); }
    /// The matrix that belongs to tau and albedo; ½ ∫ F11 dcosΘ = 1.
    ScatteringElements smooth(double c) const { return (1 / (1 - peak())) * expansion_.smooth(c); }
    /// The whole matrix, in the unit of smooth().
    ScatteringElements whole_above_peak(double c) const { return (1 / (1 - peak())) * whole(c); }

  private:
    // The matrices of all kinds, as each scatters.
    ScatteringElements whole(double c) const {
        ScatteringElements sum{};
        double scattering = 0;
        for (const Scatterer& kind : mixture_) {
            const double share = kind.optical_depth * kind.single_scattering_albedo;
            sum = sum + share * kind.matrix(c);
            scattering += share;
        }
        return (scattering > 0 ? 1 / scattering : 0) * sum;
    }

    std::vector<Scatterer> mixture_;
    ScatteringExpansion expansion_;
};

// Z of a medium from all directions light comes from to all it goes to, over azimuth.
class PhaseModes {
  public:
    PhaseModes(const Medium& medium, const Directions& at)
        : degree_(medium.degree()), azimuths_(degree_ + 2), columns_(at.nodes.x.size() + 1) {
        // Z is even or odd in azimuth: half the circle says all.
        for (double out : at.mu)
            for (std::size_t j = 0; j < columns_; ++j)
                for (double side : {1.0, -1.0}) {
                    const Vec3 k_in = propagation(j + 1 < columns_ ? -at.nodes.x[j] : -at.mu0, 0);
                    for (int i = 0; i < azimuths_; ++i)
                        Z_.push_back(phase_matrix(propagation(side * out, azimuth(i)), k_in,
                                                  [&](double c) { return medium.smooth(c); }));
                }
    }

    void choose(int m) {
        cos_.clear(), sin_.clear();
        const double scale = m > degree_ ? 0 : 1.0 / azimuths_;
        for (int i = 0; i < azimuths_; ++i) {
            cos_.push_back((m == 0 ? 1.0 : 2.0) * scale * std::cos(m * azimuth(i)));
            sin_.push_back(2.0 * scale * std::sin(m * azimuth(i)));
        }
    }
    /// The chosen mode of Z = Σ C_m cos ma + S_m sin ma, as it maps (I_m, Q_m, U_m) onto the same:
    /// to direction `out`, back up or on down, from Gauss node `in` or, after the last, the sun.
    Matrix3d back(std::size_t out, std::size_t in) const { return mode(2 * (out * columns_ + in)); }
    Matrix3d on(std::size_t out, std::size_t in) const {
        return mode(2 * (out * columns_ + in) + 1);
    }

  private:
    double azimuth(int i) const { return kPi * (i + 0.5) / azimuths_; }
    Matrix3d mode(std::size_t pair) const {
        const auto count = static_cast<std::size_t>(azimuths_);
        const Matrix3d* Z = &Z_[pair * count];
        Matrix3d even = Matrix3d::Zero(), odd = Matrix3d::Zero();
        for (std::size_t i = 0; i < count; ++i) {
            even += cos_[i] * Z[i];
            odd += sin_[i] * Z[i];
        }
        // I and Q go with cos ma, U with sin ma: ∫ sin m(a−a') sin ma' da' = −π cos ma.
        Matrix3d mode = even;
        mode.topRightCorner<2, 1>() = -odd.topRightCorner<2, 1>();
        mode.bottomLeftCorner<1, 2>() = odd.bottomLeftCorner<1, 2>();
        return mode;
    }

    int degree_, azimuths_;  // exact for all degrees of the medium
    std::size_t columns_;
    std::vector<Matrix3d> Z_;  // [out][in][up, down][azimuth]
    std::vector<double> cos_, sin_;
};

// Once scattered by a layer τ: from incidence μ_in back to μ_out, and on to it.
double scattered_back(double tau, double mu_out, double mu_in) {
    return -std::expm1(-tau / mu_out - tau / mu_in) * mu_in / (mu_out + mu_in);
}
double scattered_on(double tau, double mu_out, double mu_in) {
    // By the shorter of both ways: the other's exponential may vanish.
    const double in = tau / mu_in, out = tau / mu_out, d = std::abs(in - out);
    const double slope = d < 1e-9 ? 1 : -std::expm1(-d) / d;
    return out * std::exp(-std::min(in, out)) * slope;
}

// What homogeneous layers, one or more, do to one mode of light. Marked * below: to light that
// comes from below.
struct Slab {
    MatrixXd R, T;          // reflected and diffusely transmitted, of light from above
    MatrixXd R_up, T_up;    // R*, T*
    VectorXd R_sun, T_sun;  // the same as R and T of the sun's beam of irradiance 1
    VectorXd passes;        // what goes through without scattering
    double sun_passes;
};

// A homogeneous layer turned upside down is its mirror image, in which U is reversed.
MatrixXd mirrored(const MatrixXd& M) {
    MatrixXd result = M;
    for (Index row = 0; row < M.rows(); ++row)
        for (Index column = row % 3 == 2 ? 0 : 2; column < M.cols(); ++column)
            if ((row % 3 == 2) != (column % 3 == 2)) result(row, column) = -M(row, column);
    return result;
}

// A layer that scatters once.
Slab thin_slab(int m, double tau, double albedo, const PhaseModes& Z, const Directions& at) {
    Slab slab;
    slab.R.resize(at.all(), at.inner()), slab.T.resize(at.all(), at.inner());
    slab.R_sun.resize(at.all()), slab.T_sun.resize(at.all()), slab.passes.resize(at.all());
    slab.sun_passes = std::exp(-tau / at.mu0);
    const std::size_t sun = at.nodes.x.size();
    for (std::size_t i = 0; i < at.mu.size(); ++i) {
        const Index row = 3 * static_cast<Index>(i);
        slab.passes.segment<3>(row).setConstant(std::exp(-tau / at.mu[i]));
        for (std::size_t j = 0; j < sun; ++j) {
            // dω' = da' dμ'; the azimuth's integral of a mode is π, of mode 0 2π.
            const double share = albedo * (m == 0 ? 2 : 1) * at.nodes.weight[j] / 4;
            const Index column = 3 * static_cast<Index>(j);
            slab.R.block<3, 3>(row, column) =
                share * scattered_back(tau, at.mu[i], at.nodes.x[j]) * Z.back(i, j);
            slab.T.block<3, 3>(row, column) =
                share * scattered_on(tau, at.mu[i], at.nodes.x[j]) * Z.on(i, j);
        }
        const double share = albedo / (4 * kPi);
        slab.R_sun.segment<3>(row) =
            share * scattered_back(tau, at.mu[i], at.mu0) * Z.back(i, sun).col(0);
        slab.T_sun.segment<3>(row) =
            share * scattered_on(tau, at.mu[i], at.mu0) * Z.on(i, sun).col(0);
    }
    return slab;
}

// Two equal homogeneous layers, one on the other. Light between them: down D, up U, with
//   D = (1 − R* R)⁻¹ (T + e),  U = R D
void double_up(Slab& s) {
    const Index inner = s.R.cols();
    const MatrixXd R_up = mirrored(s.R), T_up = mirrored(s.T);
    const MatrixXd between =
        MatrixXd::Identity(inner, inner) - R_up.topRows(inner) * s.R.topRows(inner);
    const Eigen::PartialPivLU<MatrixXd> inverse(between);

    MatrixXd enters = s.T.topRows(inner);
    enters.diagonal() += s.passes.head(inner);
    const MatrixXd down = inverse.solve(enters), up = s.R * down;
    const MatrixXd down_diffuse = s.T + R_up * up.topRows(inner);

    const VectorXd sun_down = inverse.solve(
        s.T_sun.head(inner) + s.sun_passes * R_up.topRows(inner) * s.R_sun.head(inner));
    const VectorXd sun_up = s.sun_passes * s.R_sun + s.R * sun_down;
    const VectorXd sun_diffuse = s.T_sun + R_up * sun_up.head(inner);

    s.R_sun += T_up * sun_up.head(inner) + s.passes.cwiseProduct(sun_up);
    s.T_sun = s.sun_passes * s.T_sun + s.T * sun_down + s.passes.cwiseProduct(sun_diffuse);
    s.R += T_up * up.topRows(inner) + s.passes.asDiagonal() * up;
    s.T = s.T * down + s.passes.asDiagonal() * down_diffuse;
    s.passes = s.passes.cwiseProduct(s.passes);
    s.sun_passes *= s.sun_passes;
}

// A homogeneous layer of any depth.
Slab homogeneous_slab(int m, const Medium& medium, const PhaseModes& Z, const Directions& at) {
    // A medium has no modes above its degree: it only lets through.
    const int doublings =
        m > medium.degree()
            ? 0
            : std::max(0, static_cast<int>(std::ceil(std::log2(medium.tau / kThinnest))));
    Slab slab = thin_slab(m, std::ldexp(medium.tau, -doublings), medium.albedo, Z, at);
    for (int i = 0; i < doublings; ++i) double_up(slab);
    slab.R_up = mirrored(slab.R);
    slab.T_up = mirrored(slab.T);
    return slab;
}

// `lower` below `upper`: what both do to the sun's beam and to light from below (R and T of the two
// are left out: no light but the sun's comes from above). Light between them as in double_up.
Slab stacked(const Slab& upper, const Slab& lower) {
    const Index inner = upper.R_up.cols();
    const Eigen::PartialPivLU<MatrixXd> inverse(MatrixXd(
        MatrixXd::Identity(inner, inner) - lower.R.topRows(inner) * upper.R_up.topRows(inner)));
    Slab both;
    both.passes = upper.passes.cwiseProduct(lower.passes);
    both.sun_passes = upper.sun_passes * lower.sun_passes;

    const VectorXd up = inverse.solve(lower.R.topRows(inner) * upper.T_sun.head(inner) +
                                      upper.sun_passes * lower.R_sun.head(inner));
    const VectorXd down = upper.T_sun + upper.R_up * up;
    const VectorXd up_all = upper.sun_passes * lower.R_sun + lower.R * down.head(inner);
    both.R_sun = upper.R_sun + upper.T_up * up + upper.passes.cwiseProduct(up_all);
    both.T_sun = upper.sun_passes * lower.T_sun + lower.T * down.head(inner) +
                 lower.passes.cwiseProduct(down);

    MatrixXd enters = lower.T_up.topRows(inner);
    enters.diagonal() += lower.passes.head(inner);
    const MatrixXd rises = inverse.solve(enters), falls = upper.R_up * rises;
    const MatrixXd rises_all = lower.T_up + lower.R * falls.topRows(inner);
    both.R_up = lower.R_up + lower.T * falls.topRows(inner) + lower.passes.asDiagonal() * falls;
    both.T_up = upper.T_up * rises + upper.passes.asDiagonal() * rises_all;
    return both;
}

// ∫ over the hemisphere of I cosθ, by the Gauss nodes.
double flux(const VectorXd& S, const GaussNodes& nodes) {
    double sum = 0;
    for (std::size_t i = 0; i < nodes.x.size(); ++i)
        sum += 2 * kPi * nodes.weight[i] * nodes.x[i] * S(3 * static_cast<Index>(i));
    return sum;
}

// Mode 0 with a ground that reflects `albedo` of what reaches it, evenly and unpolarized:
//   u = (A/π) (E + u E_back),  E the irradiance on the ground, E_back what of u's comes back
struct OverGround {
    VectorXd down, up;  // diffuse, at the ground and at the top
};
OverGround over_ground(const Slab& air, double albedo, const Directions& at) {
    VectorXd glow = VectorXd::Zero(at.all());
    for (Index i = 0; i < at.all(); i += 3) glow(i) = 1;
    const VectorXd back = air.R_up * glow.head(at.inner());
    const VectorXd through = air.T_up * glow.head(at.inner()) + air.passes.cwiseProduct(glow);
    const double reaching = flux(air.T_sun, at.nodes) + at.mu0 * air.sun_passes;
    const double u = albedo / kPi * reaching / (1 - albedo / kPi * flux(back, at.nodes));
    return {air.T_sun + u * back, air.R_sun + u * through};
}

// What the whole matrix scatters once beyond what the smooth one does, seen in direction (mu, azimuth)
// from below, or from above (up).
Stokes<double> once_scattered_rest(const std::vector<Medium>& media, double mu0, double mu,
                                   double azimuth, bool up) {
    Stokes<double> sum;
    double below = 0;
    for (const Medium& medium : media) below += medium.tau;
    double above = 0;
    for (const Medium& medium : media) {
        below -= medium.tau;
        if (medium.peak() != 0) {
            const auto rest = [&](double c) {
                return medium.whole_above_peak(c) + -1 * medium.smooth(c);
            };
            const Vector3d Z =
                phase_matrix(propagation(up ? mu : -mu, azimuth), propagation(-mu0, 0), rest)
                    .col(0);
            const double strength =
                medium.albedo / (4 * kPi) * std::exp(-above / mu0 - (up ? above : below) / mu) *
                (up ? scattered_back(medium.tau, mu, mu0) : scattered_on(medium.tau, mu, mu0));
            sum = sum + strength * Stokes<double>{Z(0), Z(1), Z(2), 0};
        }
        above += medium.tau;
    }
    return sum;
}

void add_mode(int m, const VectorXd& mode, std::span<const double> azimuths,
              std::vector<Stokes<double>>& sky) {
    for (std::size_t j = 0; j < azimuths.size(); ++j) {
        const double c = std::cos(m * azimuths[j]), s = std::sin(m * azimuths[j]);
        for (Index i = 0; i < mode.size() / 3; ++i) {
            Stokes<double>& S = sky[static_cast<std::size_t>(i) * azimuths.size() + j];
            S = S + Stokes<double>{c * mode(3 * i), c * mode(3 * i + 1), s * mode(3 * i + 2), 0};
        }
    }
}

std::vector<Medium> media_of(const Atmosphere& air, int nodes) {
    std::vector<Medium> media;
    for (const std::vector<Scatterer>& layer : air.layers) {
        double depth = 0;
        for (const Scatterer& kind : layer) depth += kind.optical_depth;
        if (depth > 0) media.emplace_back(layer, nodes);
    }
    return media;
}

double largest_peak(const std::vector<Medium>& media) {
    double largest = 0;
    for (const Medium& medium : media) largest = std::max(largest, medium.peak());
    return largest;
}

}  // namespace

GroundLight light_at_ground(const Atmosphere& air, double mu0, std::span<const double> mu,
                            std::span<const double> azimuths) {
    std::vector<Medium> media = media_of(air, kNodes);
    int nodes = kNodes;
    if (largest_peak(media) > kPeak) media = media_of(air, nodes = kNodesOfPeaks);

    Directions at{gauss_nodes(nodes), {}, mu0};
    at.mu = at.nodes.x;
    // The meridian of the zenith itself is known only beside it.
    for (double cosine : mu) at.mu.push_back(std::min(cosine, 1 - 1e-15));
    std::vector<PhaseModes> Z;
    double depth = 0;
    int last_mode = 0;
    for (const Medium& medium : media) {
        Z.emplace_back(medium, at);
        last_mode = std::max(last_mode, medium.degree());
    }
    for (const auto& layer : air.layers)
        for (const Scatterer& kind : layer) depth += kind.optical_depth;

    const std::vector<Stokes<double>> dark(mu.size() * azimuths.size());
    GroundLight light{dark, dark, std::exp(-depth / mu0), 0, 0};
    double brightest = 0;
    for (int m = 0; m <= last_mode && !media.empty(); ++m) {
        std::optional<Slab> slab;
        for (std::size_t i = 0; i < media.size(); ++i) {
            Z[i].choose(m);
            const Slab layer = homogeneous_slab(m, media[i], Z[i], at);
            slab = slab ? stacked(*slab, layer) : layer;
        }
        VectorXd down = slab->T_sun, up = slab->R_sun;
        // The ground's glow is even: mode 0 alone.
        if (m == 0) {
            const OverGround all = over_ground(*slab, air.ground_albedo, at);
            down = all.down, up = all.up;
            light.diffuse = flux(down, at.nodes) + mu0 * (slab->sun_passes - light.direct);
            light.escaping = flux(all.up, at.nodes);
            if (mu.empty()) break;
        }
        add_mode(m, down.tail(at.all() - at.inner()), azimuths, light.sky);
        add_mode(m, up.tail(at.all() - at.inner()), azimuths, light.top);
        const double amplitude =
            std::max(down.lpNorm<Eigen::Infinity>(), up.lpNorm<Eigen::Infinity>());
        brightest = std::max(brightest, amplitude);
        if (m >= 2 && amplitude < kLeastMode * brightest) break;
    }
    if (largest_peak(media) > 0)
        for (std::size_t i = 0; i < mu.size(); ++i)
            for (std::size_t j = 0; j < azimuths.size(); ++j) {
                const std::size_t k = i * azimuths.size() + j;
                const double cosine = at.mu[at.nodes.x.size() + i];
                light.sky[k] =
                    light.sky[k] + once_scattered_rest(media, mu0, cosine, azimuths[j], false);
                light.top[k] =
                    light.top[k] + once_scattered_rest(media, mu0, cosine, azimuths[j], true);
            }
    return light;
}

}  // namespace malus
