// film.cpp — means, covariances and their propagation to DoLP and AoLP, pixels side by side.
// SPDX-License-Identifier: Apache-2.0
#include "malus/render/film.h"

#include <algorithm>

#include "render/lanes.h"

namespace malus {
namespace {

// W m⁻² sr⁻¹ nm⁻¹; the covariance of fainter light is lost in floats, whose least is 1e-45.
constexpr double kFaintest = 1e-18;
// In place of a divisor that may be 0; its square is a number.
constexpr double kLeast = 1e-150;

enum Entry { k00, k01, k02, k11, k12, k22, k33 };

// Of one pixel, or of pixels side by side.
template <class T>
struct Light {
    Stokes<T> mean;
    std::array<T, 7> covariance;
    T replicates;
};

Light<double> light_of(const PixelStokes& pixel) {
    Light<double> light{pixel.mean, {}, static_cast<double>(pixel.replicates)};
    std::copy(pixel.covariance.begin(), pixel.covariance.end(), light.covariance.begin());
    return light;
}

// kSide pixels, `stride` apart.
Light<Reals> light_of(const PixelStokes* first, std::size_t stride) {
    const auto each = [&](const auto& read) {
        return lanewise<Reals>([&](std::size_t i) { return read(first[i * stride]); });
    };
    Light<Reals> light;
    light.mean = {each([](const PixelStokes& p) { return p.mean.s0; }),
                  each([](const PixelStokes& p) { return p.mean.s1; }),
                  each([](const PixelStokes& p) { return p.mean.s2; }),
                  each([](const PixelStokes& p) { return p.mean.s3; })};
    for (std::size_t e = 0; e < light.covariance.size(); ++e)
        light.covariance[e] = each([e](const PixelStokes& p) { return p.covariance[e]; });
    light.replicates = each([](const PixelStokes& p) { return p.replicates; });
    return light;
}

// What polarized light there is: P, cosine and sine of twice its angle, p.
template <class T>
struct Polarized {
    T P, q, u, p;
};

template <class T>
Polarized<T> polarized(const Stokes<T>& S) {
    using std::max, std::sqrt;
    const T least = real<T>(kLeast);
    const T P = sqrt(S.s1 * S.s1 + S.s2 * S.s2), inverse = real<T>(1) / max(P, least);
    return {P, S.s1 * inverse, S.s2 * inverse, P / max(S.s0, least)};
}

// Standard errors of DoLP, and of AoLP in rad.
template <class T>
struct Errors {
    T dolp, aolp;
};

template <class T>
Errors<T> errors(const Light<T>& light, const Polarized<T>& polarized) {
    using std::max, std::min, std::sqrt;
    const auto& [P, q, u, p] = polarized;
    const auto& C = light.covariance;
    const T zero = real<T>(0), one = real<T>(1), two = real<T>(2), right = real<T>(kPi / 2);
    const T S0 = max(light.mean.s0, real<T>(kFaintest)), R = light.replicates;

    // How much more the error of a ratio is than first-order propagation says when few replicates
    // carry the light: DoLP is then a weighted mean of few, and pulled toward the very ones that are
    // to tell its spread. Kish's effective number m of replicates; 1 when all weigh the same,
    // infinite below m = 2.
    const T m = R / (one + (R - one) * (C[k00] / (S0 * S0)));
    const auto known = (m >= two) && (light.mean.s0 >= real<T>(kFaintest));
    const T wider = sqrt((R - one) / R * m / (max(m, two) - one));

    const T crossed = two * q * u * C[k12];
    const T along = q * q * C[k11] + u * u * C[k22] + crossed + p * p * C[k00] -
                    two * p * (q * C[k01] + u * C[k02]);
    const T across = q * q * C[k22] + u * u * C[k11] - crossed;
    // Unpolarized: the gradient has no direction; the larger axis of the error ellipse bounds it.
    const T variance = select(P > zero, max(along, zero), max(C[k11], C[k22]));
    const T of_known = select(known, min(one, wider * sqrt(variance) / S0), one);
    const T of_none = select(C[k00] > zero, one, zero);
    const T dolp = select(light.mean.s0 > zero, of_known, of_none);

    // An axis of light that may well be unpolarized can point anywhere.
    const auto anywhere = (P <= zero) || (p < real<T>(3) * dolp);
    const T turned = wider * sqrt(max(across, zero)) / (two * max(P, real<T>(kLeast)));
    return {dolp, select(anywhere, right, min(right, turned))};
}

template <class T>
T relative_error_s0(const Light<T>& light) {
    using std::max, std::sqrt;
    const T zero = real<T>(0), S0 = light.mean.s0, C00 = light.covariance[k00];
    const T without_light = select(C00 > zero, real<T>(1), zero);
    return select(S0 > zero, sqrt(C00) / max(S0, real<T>(kLeast)), without_light);
}

// The larger error of a pixel; of the largest lane.
template <class T>
double largest_error(const Light<T>& light) {
    using std::max;
    const T larger = max(errors(light, polarized(light.mean)).dolp, relative_error_s0(light));
    const auto each = stored(larger);
    return *std::max_element(each.begin(), each.end());
}

// Degrees that stay below 180 when rounded to a float.
template <class T>
T axis_degrees(const Stokes<T>& S) {
    const T zero = real<T>(0), angle = real<T>(to_degrees(0.5)) * angle_of(S.s2, S.s1);
    const T folded = select(angle < zero, angle + real<T>(180), angle);
    return select((folded < real<T>(180 - 0x1p-17)) && (S.s0 > zero), folded, zero);
}

// Into number `at` of each row, and on.
void derive(const Light<Reals>& light, std::size_t at, float* const* rows) {
    const auto put = [&](FilmQuantity of, const Reals& x) { store_floats(x, rows[of] + at); };
    const Stokes<Reals>& S = light.mean;
    const auto& C = light.covariance;
    const Polarized<Reals> linear = polarized(S);
    const Errors<Reals> error = errors(light, linear);
    put(kS0, S.s0), put(kS1, S.s1), put(kS2, S.s2), put(kS3, S.s3);
    put(kDolp, min(Reals(1), linear.p));
    put(kAolp, axis_degrees(S));
    put(kErrorS0, sqrt(C[k00])), put(kErrorS1, sqrt(C[k11]));
    put(kErrorS2, sqrt(C[k22])), put(kErrorS3, sqrt(C[k33]));
    put(kCovS0S1, C[k01]), put(kCovS0S2, C[k02]), put(kCovS1S2, C[k12]);
    put(kErrorDolp, error.dolp);
    put(kErrorAolp, Reals(to_degrees(1)) * error.aolp);
}

}  // namespace

Stokes<double> held_physical(const Stokes<double>& S, double noise) {
    constexpr double kRoundings = 1e-5, kFloat = 0x1p-22;
    const double polarized = std::sqrt(sqr(S.s1) + sqr(S.s2) + sqr(S.s3)),
                 most = (1 - kFloat) * S.s0;
    if (polarized <= most || polarized > (1 + kRoundings) * S.s0 + noise) return S;
    if (S.s0 <= 0) return {};
    const double shrink = most / polarized;
    return {S.s0, shrink * S.s1, shrink * S.s2, shrink * S.s3};
}

double relative_stderr_s0(const PixelStokes& pixel) {
    return relative_error_s0(light_of(pixel));
}

double stderr_dolp(const PixelStokes& pixel) {
    const Light<double> light = light_of(pixel);
    return errors(light, polarized(light.mean)).dolp;
}

double stderr_aolp(const PixelStokes& pixel) {
    const Light<double> light = light_of(pixel);
    return errors(light, polarized(light.mean)).aolp;
}

double debiased_dolp(const PixelStokes& pixel) {
    const Stokes<double>& S = pixel.mean;
    const auto c = [&](Entry e) { return static_cast<double>(pixel.covariance[e]); };
    const double p = std::min(1.0, dolp(S)), P = std::hypot(S.s1, S.s2);
    if (p == 0) return 0;
    const double q = S.s1 / P, u = S.s2 / P;
    const double b2 = (q * q * c(k22) + u * u * c(k11) - 2 * q * u * c(k12)) / sqr(S.s0);
    if (!(b2 > 0)) return p;
    return std::max(0.0, p + b2 * std::expm1(-p * p / b2) / (2 * p));
}

Film::Film(int w, int h, std::vector<double> wavelengths)
    : width(w), height(h), wavelengths_nm(std::move(wavelengths)) {
    const std::size_t pixels = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    stokes.resize(pixels * wavelengths_nm.size());
    coverage.resize(pixels);
    distance.resize(pixels);
    instance.resize(pixels, -1);
    samples.resize(pixels);
}

double aolp_degrees(const Stokes<double>& S) {
    return axis_degrees(S);
}

void derive(const Film& film, std::size_t wavelength, std::size_t from, std::size_t to,
            float* const* rows) {
    const std::size_t stride = film.wavelengths_nm.size();
    std::size_t i = from;
    for (; i + kSide <= to; i += kSide)
        derive(light_of(&film.at(i, wavelength), stride), i - from, rows);
    if (i == to) return;
    // Fewer than a register holds: beside as many of the last one, and only what was asked for kept.
    std::array<PixelStokes, kSide> last;
    for (std::size_t k = 0; k < kSide; ++k) last[k] = film.at(std::min(i + k, to - 1), wavelength);
    std::array<std::array<float, kSide>, kFilmQuantities> numbers;
    std::array<float*, kFilmQuantities> into;
    for (std::size_t q = 0; q < kFilmQuantities; ++q) into[q] = numbers[q].data();
    derive(light_of(last.data(), 1), 0, into.data());
    for (std::size_t q = 0; q < kFilmQuantities; ++q)
        std::copy_n(into[q], to - i, rows[q] + (i - from));
}

std::optional<double> pixel_error(const Film& film, std::size_t pixel) {
    if (!(film.coverage[pixel] > 0)) return std::nullopt;
    const std::size_t count = film.wavelengths_nm.size();
    double largest = 0;
    std::size_t w = 0;
    for (; w + kSide <= count; w += kSide)
        largest = std::max(largest, largest_error(light_of(&film.at(pixel, w), 1)));
    for (; w < count; ++w) largest = std::max(largest, largest_error(light_of(film.at(pixel, w))));
    return largest;
}

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    const auto count = static_cast<double>(values.size());
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>(std::max(0.0, std::ceil(share * count) - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

double error_of_most(const Film& film) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < film.pixel_count(); ++i)
        if (const auto error = pixel_error(film, i)) errors.push_back(*error);
    return quantile(std::move(errors), 0.95);
}

}  // namespace malus
