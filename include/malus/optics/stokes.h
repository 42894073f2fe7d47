// stokes.h — Stokes vectors, the frames they are measured in, and turning one into another.
//
//   S0 = I,  S1 = I(x) − I(y),  S2 = I(+45°) − I(−45°),  S3 = I_right − I_left
//   (+45° from x toward y); with the axis turned by α from x toward y:
//   S1' = S1 cos2α + S2 sin2α,  S2' = −S1 sin2α + S2 cos2α
//
// Frame   a beam that propagates along k has a reference axis x ⟂ k and y = k × x; the receiver,
//         looking into the beam, sees x to the right when y is up. Fields go as exp(−iωt), so
//         S2 + i S3 = 2⟨Ex Ey*⟩ and right-handed light turns clockwise for the receiver.
// Range   |(S1,S2,S3)| ≤ S0; DoLP in [0,1]; AoLP in [0,π), both 0 where S0 = 0.
// Source  Born & Wolf, Principles of Optics, 7th ed., §1.4.2 and §10.8.3; signs as IEEE 211.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "malus/core/contract.h"
#include "malus/core/real.h"
#include "malus/core/vec.h"

namespace malus {

template <class T>
struct Stokes {
    T s0{}, s1{}, s2{}, s3{};

    friend Stokes operator+(const Stokes& a, const Stokes& b) {
        return {a.s0 + b.s0, a.s1 + b.s1, a.s2 + b.s2, a.s3 + b.s3};
    }
    friend Stokes operator*(const T& w, const Stokes& a) {
        return {w * a.s0, w * a.s1, w * a.s2, w * a.s3};
    }
};

/// The frame of a beam: propagation direction and reference axis, both unit, perpendicular.
template <class R>
struct BeamFrameOf {
    Vector3<R> k, x;
    Vector3<R> y() const { return cross(k, x); }
};
using BeamFrame = BeamFrameOf<double>;

/// A turn of the reference axis by α from x toward y, kept as what Stokes vectors need of it.
template <class R>
struct TurnOf {
    R cos2 = 1, sin2 = 0;  ///< cos 2α, sin 2α
};
using Turn = TurnOf<double>;

/// The turn from one frame of a beam to another frame of the same beam.
template <class R>
TurnOf<R> turn_between(const BeamFrameOf<R>& from, const BeamFrameOf<R>& to) {
    EXPECT(!any(length(from.k - to.k) >= real<R>(1e-6)));
    const R c = dot(to.x, from.x), s = dot(to.x, from.y());
    const R inverse = real<R>(1) / (c * c + s * s);  // 1 but for rounding
    return {(c * c - s * s) * inverse, (c + c) * s * inverse};
}

template <class T, class R>
Stokes<T> turned(const Stokes<T>& S, const TurnOf<R>& turn) {
    const T c = real<T>(turn.cos2), s = real<T>(turn.sin2);
    return {S.s0, S.s1 * c + S.s2 * s, S.s2 * c - S.s1 * s, S.s3};
}

/// A Stokes vector together with the frame it is measured in.
template <class T>
struct Beam {
    Stokes<T> stokes;
    BeamFrame frame;
};

/// The same beam, measured in another frame.
template <class T>
Beam<T> measured_in(const Beam<T>& beam, const BeamFrame& frame) {
    return {turned(beam.stokes, turn_between(beam.frame, frame)), frame};
}

/// Degree of linear polarization, [0,1] for physical light.
inline double dolp(const Stokes<double>& S) {
    return S.s0 == 0 ? 0 : std::hypot(S.s1, S.s2) / S.s0;
}
/// Degree of polarization, [0,1] for physical light.
inline double dop(const Stokes<double>& S) {
    return S.s0 == 0 ? 0 : std::hypot(S.s1, S.s2, S.s3) / S.s0;
}
/// Angle of linear polarization from x toward y, rad, [0, π).
inline double aolp(const Stokes<double>& S) {
    if (S.s0 == 0) return 0;
    const double angle = 0.5 * std::atan2(S.s2, S.s1);
    // A tiny negative angle plus π rounds to π, which is the same axis as 0.
    const double folded = angle < 0 ? angle + kPi : angle;
    return folded < kPi ? folded : 0;
}

}  // namespace malus
