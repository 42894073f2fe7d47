// sampler.cpp — Sobol' points and their hash-based Owen scrambling.
// SPDX-License-Identifier: Apache-2.0
#include "malus/core/sampler.h"

#include "malus/core/contract.h"

namespace malus {
namespace {

constexpr int kBits = 32;
constexpr std::uint32_t kOwnBlocks = 2;  // with Sobol' dimensions of their own
using Bits = std::array<std::uint32_t, kBlockDimensions>;

struct Polynomial {
    int degree;
    std::uint32_t a;
    std::array<std::uint32_t, 6> m;
};

constexpr std::array<Polynomial, kOwnBlocks * kBlockDimensions - 1> kPolynomials{{
#include "joe_kuo_16.inc"
}};

// Direction numbers, bit by bit of the index, all dimensions of a block side by side so that one bit
// is one vector operation. Recurrence of Bratley & Fox, ACM TOMS 14, 88 (1988).
constexpr std::array<Bits, kBits> direction_numbers(int block) {
    std::array<Bits, kBits> v{};
    for (int d = 0; d < kBlockDimensions; ++d) {
        const int dimension = block * kBlockDimensions + d;
        for (int i = 0; i < kBits; ++i) {
            if (dimension == 0) {
                v[i][d] = 1u << (kBits - 1 - i);
                continue;
            }
            const Polynomial& p = kPolynomials[dimension - 1];
            if (i < p.degree) {
                v[i][d] = p.m[i] << (kBits - 1 - i);
                continue;
            }
            v[i][d] = v[i - p.degree][d] ^ (v[i - p.degree][d] >> p.degree);
            for (int k = 1; k < p.degree; ++k)
                if ((p.a >> (p.degree - 1 - k)) & 1) v[i][d] ^= v[i - k][d];
        }
    }
    return v;
}

constexpr std::array<std::array<Bits, kBits>, kOwnBlocks> kDirections{direction_numbers(0),
                                                                      direction_numbers(1)};

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

// A random permutation of 32-bit numbers in which each bit is flipped by a function of the bits
// below it only (Laine & Karras): on bit-reversed numbers it is an Owen scramble. Every step, an
// addition or a multiplication by an odd or even-plus-xor factor, carries upward only. The
// multipliers are Vegdahl's, found by measuring how well each bit avalanches.
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

// Finalizer of MurmurHash3 (public domain) in the constants of Stafford's variant 13.
constexpr std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

constexpr double fraction(std::uint32_t bits) {
    return (bits + 0.5) * 0x1p-32;
}

SamplePoint sobol_point(std::uint64_t key, std::uint32_t sample, std::uint32_t block) {
    // Shuffling the order is an Owen scramble of the index itself: aligned runs of 2^m samples
    // stay the aligned runs of the sequence that make it even.
    const bool own = block < kOwnBlocks;
    const std::uint32_t index =
        own ? sample : owen_scramble(sample, static_cast<std::uint32_t>(key >> 32));
    const Bits x = sobol(index, own ? block : 0);
    SamplePoint u;
    for (int d = 0; d < kBlockDimensions; ++d) {
        const auto seed = static_cast<std::uint32_t>(mix(key + static_cast<std::uint64_t>(d + 1)));
        u[d] = fraction(owen_scramble(x[d], seed));
    }
    return u;
}

SamplePoint independent_point(std::uint64_t key) {
    SamplePoint u;
    for (int d = 0; d < kBlockDimensions; ++d)
        u[d] = fraction(static_cast<std::uint32_t>(hash(key, static_cast<std::uint64_t>(d)) >> 32));
    return u;
}

}  // namespace

std::uint64_t hash(std::uint64_t a, std::uint64_t b) {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ull;  // 2⁶⁴/φ, as in splitmix64
    return mix(mix(a + kGolden) ^ (b + kGolden));
}

Bits sobol(std::uint32_t index, std::uint32_t block) {
    EXPECT(block < kOwnBlocks);
    Bits x{};
    for (int bit = 0; index != 0; ++bit, index >>= 1) {
        const std::uint32_t mask = 0u - (index & 1u);
        for (int d = 0; d < kBlockDimensions; ++d) x[d] ^= kDirections[block][bit][d] & mask;
    }
    return x;
}

SamplePoint Sampler::point(std::uint32_t sample, std::uint32_t block) const {
    const std::uint64_t key = hash(key_, block);
    return sampling_ == Sampling::kSobol ? sobol_point(key, sample, block)
                                         : independent_point(hash(key, sample));
}

}  // namespace malus
