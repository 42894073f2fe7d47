// lanes.h — wavelengths side by side in vector registers: the T of the optics headers in renders.
//
// Error   arithmetic as float (2⁻²⁴); exp and sqrt within 1 unit in the last place (xsimd).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <xsimd/xsimd.hpp>

namespace malus {

using Lanes = xsimd::batch<float>;
inline constexpr std::size_t kLanes = Lanes::size;

/// Number of floats that hold `count` wavelengths in whole registers.
constexpr std::size_t padded(std::size_t count) {
    return (count + kLanes - 1) / kLanes * kLanes;
}

}  // namespace malus
