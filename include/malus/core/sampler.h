// sampler.h — the random numbers of a path: Owen-scrambled Sobol' points.
//
// A pixel has R independent scrambles (replicates); the spread of their means is the error bar.
// A number depends on (seed, pixel, replicate, sample, block, dimension) alone: any machine and any
// thread can compute it, and a render can continue where another stopped.
//
// Blocks  a path needs a few numbers a vertex: a block of 8. Blocks 0 and 1 are dimensions 1 to 8 and
//         9 to 16 of one Sobol' sequence, so that two vertices together are sampled evenly, too.
//         Blocks beyond visit the first 8 dimensions in an independently shuffled order
//         ("padding"), which keeps each well distributed and all independent of each other.
// Plain   on request independent random numbers instead, so that plain Monte Carlo can be compared.
// Range   each number in (0,1), a multiple of 2⁻³² plus 2⁻³³.
// Source  Owen, Randomly permuted (t,m,s)-nets (1995); Joe & Kuo (2008) for the direction numbers;
//         Laine & Karras (2011) and Burley, JCGT 9(4) (2020) for the hash-based scrambling.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace malus {

inline constexpr int kBlockDimensions = 8;

/// Coordinates of one point of a block.
using SamplePoint = std::array<double, kBlockDimensions>;

/// The unscrambled Sobol' point `index` in the dimensions of block 0 or 1: 32-bit fractions.
std::array<std::uint32_t, kBlockDimensions> sobol(std::uint32_t index, std::uint32_t block);

/// A well-mixed 64-bit function of two 64-bit numbers.
std::uint64_t hash(std::uint64_t a, std::uint64_t b);

/// Which numbers: Owen-scrambled Sobol' points, or independent ones, each a hash of its place.
enum class Sampling { kSobol, kIndependent };

/// The numbers of replicate `replicate` of pixel `pixel`.
class Sampler {
  public:
    Sampler(std::uint64_t seed, std::uint64_t pixel, std::uint32_t replicate,
            Sampling sampling = Sampling::kSobol)
        : key_(hash(hash(seed, pixel), replicate)), sampling_(sampling) {}

    /// Point `sample` of block `block`.
    SamplePoint point(std::uint32_t sample, std::uint32_t block) const;

  private:
    std::uint64_t key_;
    Sampling sampling_;
};

}  // namespace malus
