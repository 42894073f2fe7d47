// color_maps.h — colours of numbers, by formula in the OKLab colour space.
//
//   a = C cos h,  b = C sin h
//   sequential   L = 0.15 + 0.80 t,   C = 0.155,   h = 280° + 190° t: violet, red, yellow
//   cyclic       L = 0.74,  C = 0.125,  h = 29° + 2 AoLP: 0° red, 45° green, 90° cyan, 135° violet
//   diverging    L = 0.97 − 0.42 |t|,   C = 0.19 |t|,   h = 260° (blue) for t < 0, 29° (red) for t > 0
//   combined     L = 0.97 (1 − p) l + p (0.59 + 0.21 l),   C = 0.1 p,   h as cyclic
//
// Range   L from 0 (black) to 1 (white); hue h in degrees; colours fit the sRGB gamut.
// Source  B. Ottosson, "A perceptual color space for image processing" (2020),
//         https://bottosson.github.io/posts/oklab/; sRGB curve: IEC 61966-2-1.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "preview/picture.h"

namespace malus::preview {

struct OkLab {
    double L = 0, a = 0, b = 0;
};
/// Linear in light, in the primaries of sRGB; 0 to 1 when it can be shown.
struct LinearRgb {
    double r = 0, g = 0, b = 0;
};

LinearRgb linear_rgb(const OkLab& color);
bool in_gamut(const LinearRgb& color);

/// The transfer curve of sRGB and its inverse, [0,1] to [0,1].
double srgb_from_linear(double linear);
double linear_from_srgb(double encoded);

/// To 8 bits; what lies outside the gamut is clipped.
Color to_color(const LinearRgb& color);

/// Lightness L, hue h and chroma C, the chroma reduced as far as the gamut asks.
OkLab fit_to_gamut(double L, double C, double hue_deg);

/// From dark to bright in even steps of lightness for t in [0,1]; t is clipped.
OkLab sequential(double t);

/// Colour of an angle with period 180°, all equally light. `vividness` 0 is the grey of that
/// lightness, 1 the full colour.
OkLab cyclic(double aolp_deg, double vividness = 1);

/// From blue over white to red for t in [−1,1], both sides equally light; t is clipped.
OkLab diverging(double t);

/// Hue by angle, strength p by degree of polarization, lightness l by radiance, [0,1] each: the more
/// polarized, the less of the lightness is the radiance's, so that the dark hides no colour.
OkLab combined(double aolp_deg, double strength, double lightness);

/// How far an angle can be trusted, 0 to 1: 1 for a standard error up to 5°; 0 from 30° on and
/// where DoLP is less than 3 of its standard errors. NaN is no trust.
double vividness(double stderr_aolp_deg, double dolp, double stderr_dolp);

}  // namespace malus::preview
