// neutral_points.cpp — a walk along the sun's vertical.
//
// Places on it are angles from the zenith, positive toward the sun's azimuth a:
//   w = direction(t, a),  x = dw/dt = direction(t + π/2, a)
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/neutral_points.h"

#include <algorithm>
#include <optional>

#include "malus/core/frame.h"

namespace malus {
namespace {

constexpr double kStep = to_radians(0.25);
constexpr double kAroundSun = to_radians(2);
constexpr double kLeastDolp = 1e-6;  // below this, 32-bit rounding decides the sign

class Vertical {
  public:
    Vertical(const SkyDome& dome, std::size_t wavelength, double azimuth)
        : dome_(dome), wavelength_(wavelength), azimuth_(azimuth) {}

    // Where S1 turns from above zero to below it for the first time on the way; below the horizon
    // it is zero.
    std::optional<double> end_of_polarization_in_plane(double from, double to) const {
        const int steps = static_cast<int>(std::ceil(std::abs(to - from) / kStep));
        std::optional<double> last_above;
        for (int i = 0; i <= steps; ++i) {
            const double t = i == steps ? to : from + i * std::copysign(kStep, to - from);
            const int sign = sign_of_s1(t);
            if (sign > 0) last_above = t;
            if (sign < 0 && last_above) return zero_between(*last_above, t);
        }
        return {};
    }

  private:
    int sign_of_s1(double t) const {
        const Vec3 w = direction(t, azimuth_);
        const Stokes<double> S =
            dome_.radiance_in({-w, direction(t + kPi / 2, azimuth_)}, wavelength_);
        return (S.s1 > kLeastDolp * S.s0) - (S.s1 < -kLeastDolp * S.s0);
    }

    double zero_between(double above, double below) const {
        for (int halving = 0; halving < 30; ++halving) {
            const double middle = (above + below) / 2;
            (sign_of_s1(middle) > 0 ? above : below) = middle;
        }
        return (above + below) / 2;
    }

    const SkyDome& dome_;
    std::size_t wavelength_;
    double azimuth_;
};

}  // namespace

std::vector<NeutralPoint> neutral_points(const SkyDome& dome, std::size_t wavelength,
                                         const Sun& sun) {
    const double antisun = sun.zenith - kPi;
    // Sun and antisun have the halves of the vertical that are nearer to them.
    const double middle = sun.zenith - kPi / 2;
    const Vertical vertical(dome, wavelength, sun.azimuth);
    std::vector<NeutralPoint> found;
    const auto look = [&](const char* name, double origin, double from, double to) {
        const auto t = vertical.end_of_polarization_in_plane(from, to);
        if (!t) return;
        const double azimuth = azimuth_of(direction(*t, sun.azimuth));
        found.push_back({name, std::abs(*t), azimuth, std::abs(*t - origin)});
    };
    look("Babinet", sun.zenith, sun.zenith - kAroundSun, middle);
    look("Brewster", sun.zenith, sun.zenith + kAroundSun, kPi / 2);
    look("Arago", antisun, antisun, middle);
    return found;
}

}  // namespace malus
