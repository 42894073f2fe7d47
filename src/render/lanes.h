// lanes.h — vector registers: the number types of the path loop. The one place that knows xsimd.
//
// Reals  doubles for geometry: a path a lane.
// Lanes  floats for light: the same paths at one wavelength, and once more at the next.
// Error  arithmetic as double or float; exp, log and sqrt within 1 unit in the last place, sin and cos
//        within 2 (xsimd).
// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace malus
