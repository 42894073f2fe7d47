// sky.h — the light of the sky dome: Stokes vectors over direction and wavelength.
//
// Frame   maps are in the meridian frame: at sky direction w (light propagates along k = −w) the
//         axis is x = normalize(up − (up·w) w), toward the zenith. That frame spins at the zenith,
//         so SkyDome turns every node by its azimuth into a frame that does not (Ludwig's third
//         definition, IEEE Trans. AP-21, 116 (1973)) before it interpolates. Where a map's azimuths
//         are far apart it first adds some between, carried along the circle of their zenith angle.
//         Where its rows end above the horizon it continues the line of the last two.
// Units   W m⁻² sr⁻¹ nm⁻¹, nm; zenith and azimuth in radians, azimuth clockwise from north.
// Below the horizon the sky is black.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "malus/optics/stokes.h"

namespace malus {

/// The sun's disc as a sky file declares it.
struct Sun {
    double zenith = 0, azimuth = 0;  ///< rad
    std::vector<double> irradiance;  ///< W m⁻² nm⁻¹ facing the sun; one a wavelength, or empty
};

/// A sky map as read or computed: a full grid of nodes in the meridian frame.
struct Sky {
    std::vector<double> wavelengths_nm;     ///< ascending
    std::vector<double> zeniths, azimuths;  ///< rad, ascending, in [0, π/2] and [0, 2π]
    std::vector<Stokes<double>> nodes;      ///< [wavelength][zenith][azimuth]
    std::optional<Sun> sun;
    std::string source;
    std::vector<std::string> warnings;  ///< what the map leaves out, one line each

    const Stokes<double>& at(std::size_t w, std::size_t zenith, std::size_t azimuth) const {
        return nodes[(w * zeniths.size() + zenith) * azimuths.size() + azimuth];
    }
};

/// Where each wavelength stands in the map. Throws Error when the sky lacks one.
std::vector<std::size_t> wavelength_indices(const Sky& sky, std::span<const double> wavelengths_nm);

/// The meridian frame of the light that comes from sky direction w; at the zenith itself the
/// frame of azimuth 0.
BeamFrame meridian_frame(const Vec3& w);

/// The frame of the light from w that does not spin: the meridian frame turned back by the azimuth.
BeamFrame fixed_frame(const Vec3& w);

/// Where a direction lies between the nodes of a SkyDome.
struct SkyLookup {
    std::array<std::uint32_t, 4> node{};
    std::array<float, 4> weight{};  ///< ≥ 0, sum 1; all 0 below the horizon
    double pdf = 0;                 ///< density of SkyDome::sample() there, sr⁻¹
};

/// A direction drawn from the sky, and where it lies.
struct SkySample {
    Vec3 w;
    SkyLookup at;
};

/// A sky prepared for rendering some of its wavelengths. Immutable; many threads may share it.
class SkyDome {
  public:
    /// Throws Error when the sky lacks one of the wavelengths.
    SkyDome(const Sky& sky, std::span<const double> wavelengths_nm);

    SkyLookup locate(const Vec3& w) const;

    /// Component c of node: a row of one float a wavelength, in fixed_frame(w). Rows may be read
    /// up to kPadding floats beyond their end.
    const float* row(std::uint32_t node, int c) const {
        return &data_[(std::size_t{node} * 4 + static_cast<std::size_t>(c)) * wavelength_count_];
    }
    /// One wavelength of the light from w, in fixed_frame(w).
    Stokes<double> radiance(const Vec3& w, std::size_t wavelength) const;

    /// Draws a direction by S0 (each wavelength weighs the same) from two numbers in (0,1).
    /// at.pdf = 0 where the whole sky is black.
    SkySample sample(double u1, double u2) const;

    static constexpr std::size_t kPadding = 64;

  private:
    // A column of nodes: at an azimuth between two columns of the map, t of the way from one to the
    // other, each turn rad away.
    struct Column {
        double azimuth;
        std::size_t left, right;
        double t, from_left, from_right;
    };
    static std::vector<Column> columns_of(const Sky& sky);
    static Stokes<double> interpolated(const Sky& sky, std::size_t w, std::size_t row,
                                       const Column& column);
    static Stokes<double> at_horizon(const Sky& sky, std::size_t w, const Column& column);

    // Ascending coordinates with a guide table, so that a search takes constant time.
    class Axis {
      public:
        Axis() = default;
        explicit Axis(std::vector<double> nodes);
        std::size_t cell(double x) const;  // largest i with nodes[i] ≤ x, kept in range
        double node(std::size_t i) const { return nodes_[i]; }
        std::size_t cells() const { return nodes_.size() - 1; }
        /// Where x lies in cell i, brought to [0,1].
        double fraction(std::size_t i, double x) const {
            return std::clamp((x - nodes_[i]) / (nodes_[i + 1] - nodes_[i]), 0.0, 1.0);
        }

      private:
        std::vector<double> nodes_;
        std::vector<std::uint32_t> guide_;
        double scale_ = 0;
    };

    void fill_nodes(const Sky& sky, const std::vector<Column>& columns,
                    std::span<const std::size_t> which);
    void store(std::size_t row, std::size_t column, std::size_t w, const Stokes<double>& S);
    void build_distribution();
    double wrapped(double azimuth) const;
    SkyLookup lookup(std::size_t r, std::size_t c, double v, double u) const;

    std::size_t wavelength_count_ = 0;
    Axis zenith_, azimuth_;           // with pole, horizon and the first azimuth once more
    std::vector<float> data_;         // [node][component][wavelength]
    std::vector<double> cos_zenith_;  // of the zenith nodes
    std::vector<double> row_cdf_;     // over zenith cells
    std::vector<double> column_cdf_;  // [zenith cell][azimuth cell + 1]
    std::vector<double> density_;     // [zenith cell][azimuth cell], sr⁻¹
};

}  // namespace malus
