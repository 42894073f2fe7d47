// lanes.h — vector registers: the number types of the path loop. The one place that knows xsimd.
//
// Reals  doubles for geometry: a path a lane.
// Lanes  floats for light: the same paths at one wavelength, and once more at the next.
// Error  arithmetic as double or float; exp, log and sqrt within 1 unit in the last place, sin and cos
//        within 2 (xsimd).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <xsimd/xsimd.hpp>

#include "malus/core/frame.h"

namespace malus {

using Reals = xsimd::batch<double>;
using Mask = Reals::batch_bool_type;
using Vec3s = Vector3<Reals>;
inline constexpr std::size_t kSide = Reals::size;  ///< paths side by side

using Lanes = xsimd::batch<float>;
static_assert(Lanes::size == 2 * kSide);

/// Number of registers that hold `count` wavelengths.
constexpr std::size_t pairs(std::size_t count) {
    return (count + 1) / 2;
}

/// Reals for both wavelengths of Lanes.
template <>
struct Conversion<Lanes, Reals> {
    static Lanes of(const Reals& x) {
#if defined(__AVX512DQ__)
        return _mm512_broadcast_f32x8(_mm512_cvtpd_ps(x));
#elif defined(__AVX__)
        const __m128 half = _mm256_cvtpd_ps(x);
        return _mm256_set_m128(half, half);
#else
        alignas(64) std::array<double, kSide> from;
        alignas(64) std::array<float, 2 * kSide> to;
        x.store_aligned(from.data());
        for (std::size_t i = 0; i < 2 * kSide; ++i) to[i] = static_cast<float>(from[i % kSide]);
        return Lanes::load_aligned(to.data());
#endif
    }
};

#if defined(__AVX512F__)
/// An estimate of 14 bits and one step of Newton's method.
template <>
struct Inverses<Lanes> {
    static Lanes of(const Lanes& x) {
        const Lanes estimate = _mm512_rcp14_ps(x);
        return estimate + estimate * (Lanes(1.f) - estimate * x);
    }
    static Lanes of_sqrt(const Lanes& x) {
        const Lanes estimate = _mm512_rsqrt14_ps(x);
        return estimate + Lanes(0.5f) * estimate * (Lanes(1.f) - estimate * x * estimate);
    }
};
#endif

/// Rounded to floats, kSide of them.
inline void store_floats(const Reals& x, float* to) {
#if defined(__AVX512F__)
    _mm256_storeu_ps(to, _mm512_cvtpd_ps(x));
#elif defined(__AVX__)
    _mm_storeu_ps(to, _mm256_cvtpd_ps(x));
#else
    alignas(64) std::array<double, kSide> from;
    x.store_aligned(from.data());
    for (std::size_t i = 0; i < kSide; ++i) to[i] = static_cast<float>(from[i]);
#endif
}

/// Of kSide floats.
inline Reals load_floats(const float* from) {
#if defined(__AVX512F__)
    return _mm512_cvtps_pd(_mm256_loadu_ps(from));
#elif defined(__AVX__)
    return _mm256_cvtps_pd(_mm_loadu_ps(from));
#else
    alignas(64) std::array<double, kSide> to;
    for (std::size_t i = 0; i < kSide; ++i) to[i] = static_cast<double>(from[i]);
    return Reals::load_aligned(to.data());
#endif
}

namespace detail {
template <class T, class Read, std::size_t... I>
T lanewise(const Read& read, std::index_sequence<I...>) {
    if constexpr (sizeof...(I) == 1)
        return read(0);
    else
        return T(typename T::register_type{static_cast<typename T::value_type>(read(I))...});
}
}  // namespace detail

/// A T of read(lane).
template <class T, class Read>
T lanewise(const Read& read) {
    return detail::lanewise<T>(read, std::make_index_sequence<kLaneCount<T>>());
}

/// The numbers of a register in memory, to be read one by one.
template <class T>
auto stored(const T& x) {
    if constexpr (kLaneCount<T> == 1) {
        return std::array<T, 1>{x};
    } else {
        std::array<typename T::value_type, T::size> values;
        x.store_unaligned(values.data());
        return values;
    }
}

/// The sum of the lanes.
inline double total(const Reals& x) {
#if defined(__AVX512F__)
    return _mm512_reduce_add_pd(x);
#else
    double sum = 0;
    for (double each : stored(x)) sum += each;
    return sum;
#endif
}

inline std::array<Vec3, kSide> stored(const Vec3s& v) {
    const auto x = stored(v.x), y = stored(v.y), z = stored(v.z);
    std::array<Vec3, kSide> all;
    for (std::size_t i = 0; i < kSide; ++i) all[i] = {x[i], y[i], z[i]};
    return all;
}

/// Vectors of read(lane).
template <class Read>
Vec3s vectors(const Read& read) {
    return {lanewise<Reals>([&](std::size_t i) { return read(i).x; }),
            lanewise<Reals>([&](std::size_t i) { return read(i).y; }),
            lanewise<Reals>([&](std::size_t i) { return read(i).z; })};
}

/// The lanes for which it holds, as bits.
inline unsigned bits(const Mask& mask) {
#if defined(__AVX512F__)
    return static_cast<unsigned>(static_cast<__mmask8>(mask.data));
#elif defined(__AVX__)
    return static_cast<unsigned>(_mm256_movemask_pd(mask.data));
#else
    unsigned set = 0;
    for (std::size_t i = 0; i < kSide; ++i) set |= static_cast<unsigned>(mask.get(i)) << i;
    return set;
#endif
}

/// All lanes.
inline constexpr unsigned kAllLanes = (1u << kSide) - 1;

/// The mask of the lanes in `set`.
inline Mask mask_of(unsigned set) {
#if defined(__AVX512F__)
    return Mask(static_cast<__mmask8>(set));
#else
    const Reals bit = lanewise<Reals>([&](std::size_t i) { return set >> i & 1 ? 1.0 : 0.0; });
    return bit > Reals(0.5);
#endif
}

/// kSide rows of 2 kSide numbers, into 2 kSide rows of kSide.
inline void transpose(const std::array<Lanes, kSide>& rows, float* to) {
#if defined(__AVX512DQ__)
    // Unpacking twice brings four rows' numbers of a column side by side.
    __m512 quads[8];  // [columns 4q + m of rows 0..3: m][of rows 4..7: 4 + m]
    for (std::size_t half = 0; half < 8; half += 4) {
        const __m512 a = rows[half], b = rows[half + 1], c = rows[half + 2], d = rows[half + 3];
        const __m512d ab = _mm512_castps_pd(_mm512_unpacklo_ps(a, b)),
                      cd = _mm512_castps_pd(_mm512_unpacklo_ps(c, d)),
                      AB = _mm512_castps_pd(_mm512_unpackhi_ps(a, b)),
                      CD = _mm512_castps_pd(_mm512_unpackhi_ps(c, d));
        quads[half] = _mm512_castpd_ps(_mm512_unpacklo_pd(ab, cd));
        quads[half + 1] = _mm512_castpd_ps(_mm512_unpackhi_pd(ab, cd));
        quads[half + 2] = _mm512_castpd_ps(_mm512_unpacklo_pd(AB, CD));
        quads[half + 3] = _mm512_castpd_ps(_mm512_unpackhi_pd(AB, CD));
    }
    const __m512i low = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
    const __m512i high =
        _mm512_setr_epi32(8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
    for (std::size_t m = 0; m < 4; ++m) {
        const __m512 a = _mm512_permutex2var_ps(quads[m], low, quads[m + 4]),
                     b = _mm512_permutex2var_ps(quads[m], high, quads[m + 4]);
        _mm256_storeu_ps(to + m * 8, _mm512_castps512_ps256(a));
        _mm256_storeu_ps(to + (m + 4) * 8, _mm512_extractf32x8_ps(a, 1));
        _mm256_storeu_ps(to + (m + 8) * 8, _mm512_castps512_ps256(b));
        _mm256_storeu_ps(to + (m + 12) * 8, _mm512_extractf32x8_ps(b, 1));
    }
#else
    for (std::size_t i = 0; i < kSide; ++i) {
        const auto row = stored(rows[i]);
        for (std::size_t j = 0; j < 2 * kSide; ++j) to[j * kSide + i] = row[j];
    }
#endif
}

/// The same for Lanes, at both wavelengths.
inline Lanes::batch_bool_type lanes_mask_of(unsigned set) {
#if defined(__AVX512F__)
    return Lanes::batch_bool_type(static_cast<__mmask16>(set | set << kSide));
#else
    const Lanes bit =
        lanewise<Lanes>([&](std::size_t i) { return set >> (i % kSide) & 1 ? 1.f : 0.f; });
    return bit > Lanes(0.5f);
#endif
}

/// Calls visit(value, its lanes) for each value among the lanes.
template <class Visit>
void for_each_value(const std::array<int, kSide>& values, const Visit& visit) {
    for (unsigned left = kAllLanes; left;) {
        const int value = values[static_cast<std::size_t>(std::countr_zero(left))];
        unsigned same = 0;
        for (std::size_t i = 0; i < kSide; ++i) same |= (values[i] == value ? 1u : 0u) << i;
        visit(value, same);
        left &= ~same;
    }
}

}  // namespace malus
