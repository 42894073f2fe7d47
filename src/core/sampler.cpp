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

}  // namespace

Bits sobol(std::uint32_t index, std::uint32_t block) {
    EXPECT(block < kOwnBlocks);
    Bits x{};
    for (int bit = 0; index != 0; ++bit, index >>= 1) {
        const std::uint32_t mask = 0u - (index & 1u);
        for (int d = 0; d < kBlockDimensions; ++d) x[d] ^= kDirections[block][bit][d] & mask;
    }
    return x;
}

Scramble Sampler::scramble(std::uint32_t block) const {
    Scramble own;
    own.sampling = sampling_;
    own.key = hash(key_, block);
    // Shuffling the order is an Owen scramble of the index itself: aligned runs of 2^m samples
    // stay the aligned runs of the sequence that make it even.
    own.shuffled = block >= kOwnBlocks;
    own.block = own.shuffled ? 0 : block;
    for (std::size_t d = 0; d < kBlockDimensions; ++d)
        own.seeds[d] = static_cast<std::uint32_t>(mix(own.key + d + 1));
    return own;
}

std::uint32_t Scramble::index(std::uint32_t sample) const {
    return shuffled ? owen_scramble(sample, static_cast<std::uint32_t>(key >> 32)) : sample;
}

SamplePoint Scramble::point(std::uint32_t sample) const {
    SamplePoint u;
    if (sampling == Sampling::kIndependent) {
        const std::uint64_t place = hash(key, sample);
        for (std::size_t d = 0; d < kBlockDimensions; ++d)
            u[d] = fraction(static_cast<std::uint32_t>(hash(place, d) >> 32));
        return u;
    }
    const Bits x = sobol(index(sample), block);
    for (std::size_t d = 0; d < kBlockDimensions; ++d)
        u[d] = fraction(owen_scramble(x[d], seeds[d]));
    return u;
}

}  // namespace malus
