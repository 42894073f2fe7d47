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

#include "malus/core/frame.h"
#include "malus/optics/stokes.h"
#include "malus/scene/guided_axis.h"

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
/// The same for w.y ≥ 0; below the horizon, where no light is, it is no frame.
template <class R>
BeamFrameOf<R> fixed_frame_above(const Vector3<R>& w) {
    using std::max;
    const R one = real<R>(1), q = w.z / max(one + w.y, real<R>(1e-9));  // finite below, too
    return {-w, {-w.x * q, -w.z, one - w.z * q}};
}

/// Where a direction lies between the nodes of a SkyDome.
struct SkyLookup {
    std::array<std::uint32_t, 4> node{};
    std::array<float, 4> weight{};  ///< ≥ 0, sum 1; all 0 below the horizon
};

/// Some wavelengths of a sky map, made ready to be read at any direction. Immutable; many threads may
/// share it.
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
    /// The same in another frame of that beam, such as meridian_frame(w).
    Stokes<double> radiance_in(const BeamFrame& frame, std::size_t wavelength) const;

    std::size_t wavelength_count() const { return wavelength_count_; }
    bool circular() const { return circular_; }  ///< is S3 other than 0 anywhere?
    /// The map's finest step, rad: of zenith angle, or of azimuth at the horizon.
    double spacing() const;
    /// Where the azimuths of the map begin, rad.
    double first_azimuth() const { return azimuth_.node(0); }
    double azimuth_spacing() const;  ///< the finest step, rad
    const GuidedAxis& zenith_axis() const { return zenith_; }
    /// Calls visit(w, solid_angle, lookup) for parts that fill the dome, `spacing` rad wide or less:
    /// the middle of each part, which lies between four nodes.
    template <class Visit>
    void for_each_part(double spacing, const Visit& visit) const;

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

    void fill_nodes(const Sky& sky, const std::vector<Column>& columns,
                    std::span<const std::size_t> which);
    void store(std::size_t row, std::size_t column, std::size_t w, const Stokes<double>& S);
    double wrapped(double azimuth) const;
    SkyLookup lookup(std::size_t r, std::size_t c, double v, double u) const;

    std::size_t wavelength_count_ = 0;
    bool circular_ = false;
    GuidedAxis zenith_, azimuth_;  // with pole, horizon and the first azimuth once more
    std::vector<float> data_;      // [node][component][wavelength]
};

/// What the map of a sky was made into to light a scene: an equal-area grid as fine as the sharpest paint
/// can tell. Changes are point by point over the dome and all wavelengths, before a surface evens them
/// out.
struct SkyResampling {
    std::size_t cells = 0;                  ///< along the grid's side; 0: the map itself is used
    double rms_s0 = 0, largest_s0 = 0;      ///< change of S0, relative
    double rms_dolp = 0, largest_dolp = 0;  ///< change of DoLP
};

/// One wavelength of the light at a place among rows (of a SkyDome, or a grid made of one).
template <class Rows>
Stokes<double> light_at(const Rows& rows, const SkyLookup& at, std::size_t wavelength) {
    std::array<double, 4> S{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t c = 0; c < 4; ++c)
            S[c] += static_cast<double>(at.weight[i]) *
                    static_cast<double>(rows.row(at.node[i], static_cast<int>(c))[wavelength]);
    return {S[0], S[1], S[2], S[3]};
}

template <class Visit>
void SkyDome::for_each_part(double spacing, const Visit& visit) const {
    const auto parts_of = [&](double width) {
        return static_cast<std::size_t>(std::max(1.0, std::ceil(width / spacing - 1e-9)));
    };
    for (std::size_t r = 0; r < zenith_.cells(); ++r) {
        const double z0 = zenith_.node(r), height = zenith_.node(r + 1) - z0;
        const std::size_t bands = parts_of(height);
        for (std::size_t band = 0; band < bands; ++band) {
            const double v0 = static_cast<double>(band) / static_cast<double>(bands);
            const double v1 = static_cast<double>(band + 1) / static_cast<double>(bands);
            const double v = 0.5 * (v0 + v1), z = z0 + v * height;
            const double across = std::cos(z0 + v0 * height) - std::cos(z0 + v1 * height);
            for (std::size_t c = 0; c < azimuth_.cells(); ++c) {
                const double a0 = azimuth_.node(c), width = azimuth_.node(c + 1) - a0;
                const std::size_t parts = parts_of(width * std::sin(z));
                for (std::size_t part = 0; part < parts; ++part) {
                    const double u = (static_cast<double>(part) + 0.5) / static_cast<double>(parts);
                    visit(direction(z, a0 + u * width), across * width / static_cast<double>(parts),
                          lookup(r, c, v, u));
                }
            }
        }
    }
}

}  // namespace malus
