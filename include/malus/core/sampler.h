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

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

/// A random permutation of 32-bit numbers in which each bit is flipped by a function of the bits
/// below it only (Laine & Karras): on bit-reversed numbers it is an Owen scramble. Every step, an
/// addition or a multiplication by an odd or even-plus-xor factor, carries upward only. The
/// multipliers are Vegdahl's, found by measuring how well each bit avalanches.
constexpr std::uint32_t laine_karras(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

constexpr std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) {
    return reverse_bits(laine_karras(reverse_bits(x), seed));
}

/// The number in (0,1) that 32 bits stand for.
constexpr double fraction(std::uint32_t bits) {
    return (bits + 0.5) * 0x1p-32;
}

/// Finalizer of MurmurHash3 (public domain) in the constants of Stafford's variant 13.
constexpr std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

/// A well-mixed 64-bit function of two 64-bit numbers.
constexpr std::uint64_t hash(std::uint64_t a, std::uint64_t b) {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ull;  // 2⁶⁴/φ, as in splitmix64
    return mix(mix(a + kGolden) ^ (b + kGolden));
}

/// Which numbers: Owen-scrambled Sobol' points, or independent ones, each a hash of its place.
enum class Sampling { kSobol, kIndependent };

/// What makes one block of a replicate's points its own; good for any number of points.
struct Scramble {
    Sampling sampling = Sampling::kSobol;
    std::uint32_t block = 0;  ///< of sobol()
    std::uint64_t key = 0;
    bool shuffled = false;  ///< is the order of the points shuffled?
    std::array<std::uint32_t, kBlockDimensions> seeds{};

    /// Index of point `sample` in the Sobol' sequence.
    std::uint32_t index(std::uint32_t sample) const;
    SamplePoint point(std::uint32_t sample) const;
};

/// The numbers of replicate `replicate` of pixel `pixel`.
class Sampler {
  public:
    Sampler(std::uint64_t seed, std::uint64_t pixel, std::uint32_t replicate,
            Sampling sampling = Sampling::kSobol)
        : key_(hash(hash(seed, pixel), replicate)), sampling_(sampling) {}

    Scramble scramble(std::uint32_t block) const;
    /// Point `sample` of block `block`.
    SamplePoint point(std::uint32_t sample, std::uint32_t block) const {
        return scramble(block).point(sample);
    }

  private:
    std::uint64_t key_;
    Sampling sampling_;
};

}  // namespace malus
