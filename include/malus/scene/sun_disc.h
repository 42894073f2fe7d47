// sun_disc.h — the sun as it lights a scene: an even, unpolarized disc.
//
//   L = E / (π sin²r),  r = 0.267°: a plane that faces the whole disc receives E
//   sampled evenly in solid angle, Ω = 4π sin²(r/2): density 1/Ω
//
// A direction would do for rough surfaces; the disc is what a mirror shows and what softens shadows.
// Left out: darkening toward the limb (it moves light within the disc). What of the disc lies below the
// horizon is dark.
// Units   W m⁻² sr⁻¹ nm⁻¹; directions are unit vectors of the world.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "malus/core/frame.h"
#include "malus/scene/sky.h"

namespace malus {

inline constexpr double kSunRadius = to_radians(0.267);

class SunDisc {
  public:
    /// The sun of a sky at some of its wavelengths; none where the sky declares no irradiance. Throws
    /// Error when the sky lacks one of the wavelengths.
    SunDisc(const Sky& sky, std::span<const double> wavelengths_nm);

    /// Is there a sun, of which some may stand above the horizon?
    bool present() const { return present_; }
    /// Does w lead to the disc, above the horizon?
    template <class R>
    auto contains(const Vector3<R>& w) const {
        const Vector3<R> chord = w - Vector3<R>(toward_.n);
        return w.y >= real<R>(0) && dot(chord, chord) < real<R>(present_ ? kEdge2 : 0.0);
    }
    /// A direction to the disc from two numbers in (0,1); it may lie below the horizon.
    template <class R>
    Vector3<R> sample(const R& u1, const R& u2) const;
    /// Density of sample() all over the disc, sr⁻¹.
    double pdf() const;
    /// S0, one float a wavelength; may be read up to SkyDome::kPadding floats beyond its end.
    const float* radiance() const { return radiance_.data(); }

  private:
    bool present_ = false;
    Basis toward_{Vec3{0, 1, 0}};  // its n: the middle of the disc
    std::vector<float> radiance_;
    static const double kEdge2;  // square of the chord from the disc's middle to its edge
};

// Even in solid angle means even in the square of the chord.
template <class R>
Vector3<R> SunDisc::sample(const R& u1, const R& u2) const {
    using std::sqrt;
    const R one = real<R>(1), chord2 = real<R>(kEdge2) * u1;
    const R cosine = one - real<R>(0.5) * chord2;
    const R sine = sqrt(chord2 * (one - real<R>(0.25) * chord2));
    const CosSin<R> turn = cos_sin(real<R>(2 * kPi) * u2);
    return sine * turn.cos * Vector3<R>(toward_.s) + sine * turn.sin * Vector3<R>(toward_.t) +
           cosine * Vector3<R>(toward_.n);
}

}  // namespace malus
