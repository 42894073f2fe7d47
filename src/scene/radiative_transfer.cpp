// radiative_transfer.cpp — adding-doubling for Stokes vectors (I, Q, U).
//
// Vectors and matrices run over nodes in μ, three components each. Light that comes in is known at
// the Gauss nodes only (columns); light that leaves also at the directions asked for (more rows).
// SPDX-License-Identifier: Apache-2.0
#include "scene/radiative_transfer.h"

#include <Eigen/Dense>
#include <utility>

#include "malus/core/frame.h"
#include "malus/scene/sky.h"

namespace malus {
namespace {

using Eigen::Index, Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector3d, Eigen::VectorXd;

constexpr int kNodes = 24;
constexpr double kThinnest = 1e-9;  // optical depth that scatters once

struct Nodes {
    std::vector<double> mu, weight;
};

// Gauss-Legendre on (0, 1), by Newton's method on the Legendre polynomial.
Nodes gauss_nodes(int n) {
    Nodes nodes;
    for (int i = 0; i < n; ++i) {
        double z = std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int iteration = 0; iteration < 20; ++iteration) {
            double p = 1, before = 0;
            for (int j = 0; j < n; ++j)
                before = std::exchange(p, ((2 * j + 1) * z * p - j * before) / (j + 1));
            slope = n * (z * p - before) / (z * z - 1);
            z -= p / slope;
        }
        nodes.mu.push_back(0.5 * (1 - z));
        nodes.weight.push_back(1 / ((1 - z * z) * slope * slope));
    }
    return nodes;
}

// Where light goes: `mu` > 0 upward; from the sky at `azimuth` when it goes down.
Vec3 propagation(double mu, double azimuth) {
    const double s = std::sqrt((1 - mu) * (1 + mu));
    return {-s * std::sin(azimuth), mu, s * std::cos(azimuth)};
}

// F(Θ) for molecules of depolarization ρ; S1 > 0 in the plane of scattering.
Stokes<double> scattered(const Stokes<double>& S, double cos_angle, double rho) {
    const double D = (1 - rho) / (1 + rho / 2), c2 = cos_angle * cos_angle;
    const double a = 0.75 * D * (1 + c2), b = -0.75 * D * (1 - c2);
    return {(a + 1 - D) * S.s0 + b * S.s1, b * S.s0 + a * S.s1, 1.5 * D * cos_angle * S.s2, 0};
}

// Z between meridian frames, as a matrix on (I, Q, U).
Matrix3d phase_matrix(const Vec3& k_out, const Vec3& k_in, double rho) {
    const BeamFrame in = meridian_frame(-k_in), out = meridian_frame(-k_out);
    const Vec3 normal = cross(k_in, k_out);
    const double sine = length(normal);
    // Straight on or back every plane that holds the beam is a plane of scattering.
    const Vec3 s = sine > 1e-9 ? normal / sine : in.y();
    const Turn to_plane = turn_between(in, {k_in, cross(s, k_in)});
    const Vec3 in_plane = cross(s, k_out);
    const Turn from_plane = turn_between({k_out, in_plane / length(in_plane)}, out);
    Matrix3d Z;
    for (Index column = 0; column < 3; ++column) {
        const Stokes<double> unit{column == 0 ? 1. : 0., column == 1 ? 1. : 0.,
                                  column == 2 ? 1. : 0., 0};
        const Stokes<double> S =
            turned(scattered(turned(unit, to_plane), dot(k_in, k_out), rho), from_plane);
        Z.col(column) = Vector3d(S.s0, S.s1, S.s2);
    }
    return Z;
}

// Mode m of Z = Σ C_m cos ma + S_m sin ma, as it maps (I_m, Q_m, U_m) onto the same.
Matrix3d phase_mode(int m, double mu_out, double mu_in, double rho) {
    constexpr int kAzimuths = 8;  // exact for m ≤ 2
    Matrix3d even = Matrix3d::Zero(), odd = Matrix3d::Zero();
    for (int i = 0; i < kAzimuths; ++i) {
        const double a = 2 * kPi * (i + 0.5) / kAzimuths;
        const Matrix3d Z = phase_matrix(propagation(mu_out, a), propagation(mu_in, 0), rho);
        even += (m == 0 ? 1.0 : 2.0) / kAzimuths * std::cos(m * a) * Z;
        odd += 2.0 / kAzimuths * std::sin(m * a) * Z;
    }
    // I and Q go with cos ma, U with sin ma: ∫ sin m(a−a') sin ma' da' = −π cos ma.
    Matrix3d mode = even;
    mode.topRightCorner<2, 1>() = -odd.topRightCorner<2, 1>();
    mode.bottomLeftCorner<1, 2>() = odd.bottomLeftCorner<1, 2>();
    return mode;
}

// Once scattered by a layer τ: from incidence μ_in back to μ_out, and on to it.
double scattered_back(double tau, double mu_out, double mu_in) {
    return -std::expm1(-tau / mu_out - tau / mu_in) * mu_in / (mu_out + mu_in);
}
double scattered_on(double tau, double mu_out, double mu_in) {
    const double d = tau / mu_in - tau / mu_out;
    const double slope = std::abs(d) < 1e-9 ? 1 : -std::expm1(-d) / d;
    return tau / mu_out * std::exp(-tau / mu_out) * slope;
}

// What a homogeneous layer does to one mode of light. Lit from below it does the same with U
// reversed (the layer upside down is its mirror image).
class Layer {
  public:
    /// A layer that scatters once. `mu`: all nodes, the first `inner` with weights.
    Layer(int m, double tau, double rho, double mu0, const std::vector<double>& mu,
          const std::vector<double>& weight)
        : inner_(3 * static_cast<Index>(weight.size())), sun_passes_(std::exp(-tau / mu0)) {
        const Index rows = 3 * static_cast<Index>(mu.size());
        R_.resize(rows, inner_), T_.resize(rows, inner_);
        R_sun_.resize(rows), T_sun_.resize(rows), passes_.resize(rows), mirror_.resize(rows);
        for (std::size_t i = 0; i < mu.size(); ++i) {
            const Index row = 3 * static_cast<Index>(i);
            passes_.segment<3>(row).setConstant(std::exp(-tau / mu[i]));
            mirror_.segment<3>(row) = Vector3d(1, 1, -1);
            for (std::size_t j = 0; j < weight.size(); ++j) {
                // dω' = da' dμ'; the azimuth's integral of a mode is π, of mode 0 2π.
                const double share = (m == 0 ? 2 : 1) * kPi * weight[j] / (4 * kPi);
                const Index column = 3 * static_cast<Index>(j);
                R_.block<3, 3>(row, column) =
                    share * scattered_back(tau, mu[i], mu[j]) * phase_mode(m, mu[i], -mu[j], rho);
                T_.block<3, 3>(row, column) =
                    share * scattered_on(tau, mu[i], mu[j]) * phase_mode(m, -mu[i], -mu[j], rho);
            }
            R_sun_.segment<3>(row) = scattered_back(tau, mu[i], mu0) / (4 * kPi) *
                                     phase_mode(m, mu[i], -mu0, rho).col(0);
            T_sun_.segment<3>(row) =
                scattered_on(tau, mu[i], mu0) / (4 * kPi) * phase_mode(m, -mu[i], -mu0, rho).col(0);
        }
    }

    /// Two of these layers, one on the other. Light between them: down D, up U, with
    ///   D = (1 − R* R)⁻¹ (T + e),  U = R D
    void double_up() {
        const MatrixXd R_below = mirrored(R_), T_below = mirrored(T_);
        const MatrixXd between =
            MatrixXd::Identity(inner_, inner_) - R_below.topRows(inner_) * R_.topRows(inner_);
        const Eigen::PartialPivLU<MatrixXd> inverse(between);

        MatrixXd enters = T_.topRows(inner_);
        enters.diagonal() += passes_.head(inner_);
        const MatrixXd down = inverse.solve(enters), up = R_ * down;
        const MatrixXd down_diffuse = T_ + R_below * up.topRows(inner_);

        const VectorXd sun_down = inverse.solve(
            T_sun_.head(inner_) + sun_passes_ * R_below.topRows(inner_) * R_sun_.head(inner_));
        const VectorXd sun_up = sun_passes_ * R_sun_ + R_ * sun_down;
        const VectorXd sun_diffuse = T_sun_ + R_below * sun_up.head(inner_);

        R_sun_ += T_below * sun_up.head(inner_) + passes_.cwiseProduct(sun_up);
        T_sun_ = sun_passes_ * T_sun_ + T_ * sun_down + passes_.cwiseProduct(sun_diffuse);
        R_ += T_below * up.topRows(inner_) + passes_.asDiagonal() * up;
        T_ = T_ * down + passes_.asDiagonal() * down_diffuse;
        passes_ = passes_.cwiseProduct(passes_);
        sun_passes_ *= sun_passes_;
    }

    /// Diffuse light below the layer on black ground.
    const VectorXd& light_below() const { return T_sun_; }
    /// What comes back down of an even, unpolarized glow of 1 from below.
    VectorXd returned_glow() const {
        VectorXd glow = VectorXd::Zero(inner_);
        for (Index i = 0; i < inner_; i += 3) glow(i) = 1;
        return mirrored(R_) * glow;
    }
    /// Share of the sun's light that comes through unscattered.
    double sun_passes() const { return sun_passes_; }

  private:
    MatrixXd mirrored(const MatrixXd& M) const {
        return mirror_.asDiagonal() * M * mirror_.head(inner_).asDiagonal();
    }

    Index inner_;             // rows of the Gauss nodes
    MatrixXd R_, T_;          // reflected and diffusely transmitted, of light from above
    VectorXd R_sun_, T_sun_;  // the same of the sun's beam of irradiance 1
    VectorXd passes_;         // what goes through without scattering
    double sun_passes_;
    VectorXd mirror_;
};

// Light added by a ground that reflects `albedo` of what reaches it, evenly and unpolarized:
//   u = (A/π) (E + u E_back),  E the irradiance on the ground, E_back what of u's comes back
VectorXd light_over_ground(const Layer& layer, double albedo, double mu0, const Nodes& nodes) {
    const auto irradiance = [&](const VectorXd& S) {
        double sum = 0;
        for (std::size_t i = 0; i < nodes.weight.size(); ++i)
            sum += 2 * kPi * nodes.weight[i] * nodes.mu[i] * S(3 * static_cast<Index>(i));
        return sum;
    };
    const VectorXd back = layer.returned_glow();
    const double direct = mu0 * layer.sun_passes();
    const double u = albedo / kPi * (irradiance(layer.light_below()) + direct) /
                     (1 - albedo / kPi * irradiance(back));
    return layer.light_below() + u * back;
}

}  // namespace

Stokes<double> SkyModes::at(double azimuth) const {
    Stokes<double> S;
    for (std::size_t m = 0; m < kCount; ++m) {
        const double c = std::cos(static_cast<double>(m) * azimuth);
        const double s = std::sin(static_cast<double>(m) * azimuth);
        S = S + Stokes<double>{I[m] * c, Q[m] * c, U[m] * s, 0};
    }
    return S;
}

std::vector<SkyModes> light_at_ground(const RayleighLayer& air, double mu0,
                                      std::span<const double> mu) {
    const Nodes nodes = gauss_nodes(kNodes);
    std::vector<double> all = nodes.mu;
    // The meridian of the zenith itself is known only beside it.
    for (double cosine : mu) all.push_back(std::min(cosine, 1 - 1e-15));
    const int doublings =
        std::max(0, static_cast<int>(std::ceil(std::log2(air.optical_depth / kThinnest))));
    std::vector<SkyModes> sky(mu.size());
    for (int m = 0; m < SkyModes::kCount; ++m) {
        Layer layer(m, std::ldexp(air.optical_depth, -doublings), air.depolarization, mu0, all,
                    nodes.weight);
        for (int i = 0; i < doublings; ++i) layer.double_up();
        // The ground's glow is even: mode 0 alone.
        const VectorXd light =
            m == 0 ? light_over_ground(layer, air.ground_albedo, mu0, nodes) : layer.light_below();
        for (std::size_t i = 0; i < mu.size(); ++i) {
            const Index row = 3 * static_cast<Index>(nodes.mu.size() + i);
            const auto mode = static_cast<std::size_t>(m);
            sky[i].I[mode] = light(row);
            sky[i].Q[mode] = light(row + 1);
            sky[i].U[mode] = light(row + 2);
        }
    }
    return sky;
}

}  // namespace malus
