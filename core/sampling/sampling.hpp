#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

/// Sample points and hashes. All randomness of the project comes from here as a pure function of
/// its arguments, so that no result depends on thread count or order.
namespace penumbra {

/// A well-mixed bijection of 32 bits ("lowbias32" constants of Wellons' hash prospector).
constexpr std::uint32_t hash(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    x ^= x >> 15;
    return x;
}

/// Hash of a sequence of values; the order matters.
template <class... Rest>
constexpr std::uint32_t hash(std::uint32_t first, Rest... rest) {
    return hash(first + 0x9e3779b9u * hash(static_cast<std::uint32_t>(rest)...));
}

/// [0, 1): 24 bits, so that 1.0 never appears (METHODS.md R4).
constexpr float toUnitFloat(std::uint32_t x) {
    // Signed, because SSE2 converts four such at once.
    return static_cast<float>(static_cast<std::int32_t>(x >> 8)) * 0x1p-24f;
}

constexpr std::uint32_t reverseBits(std::uint32_t x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    return __builtin_bswap32(x);
}

/// Two coordinates in [0, 1) as 32-bit fixed point.
struct SobolPoint {
    std::uint32_t x = 0, y = 0;
    glm::vec2 unit() const { return {toUnitFloat(x), toUnitFloat(y)}; }
};

/// Point `index` of the Sobol sequence in dimensions 0 and 1, a (0,2)-sequence in base 2: every
/// aligned block of 2^m points has exactly one point in every elementary interval of area 2^-m.
SobolPoint sobol(std::uint32_t index);

/// Nested uniform (Owen) scramble of the binary digits of x: a random permutation of each digit
/// that depends on all digits above it, by Vegdahl's improved Laine-Karras hash (METHODS.md R4).
std::uint32_t owenScramble(std::uint32_t x, std::uint32_t seed);

/// Point `index` of the Owen-scrambled Sobol sequence; each seed is an independent scramble. Any
/// prefix may be used; those of a power of two points are (0,2)-nets.
SobolPoint owenSobol(std::uint32_t index, std::uint32_t seed);

/// Point `index` of `count` on the unit disc by Vogel's spiral, turned by `phaseRad`: evenly dense
/// for any count.
glm::vec2 vogelDisc(int index, int count, float phaseRad);

/// `count` points (1 to 1024) on the unit disc, no two nearer than poissonDiscDistance(count), else
/// at random; the same ones every time.
std::vector<glm::vec2> poissonDisc(int count);

/// 1.2 / sqrt(count): 0.63 of what the densest packing has, which darts reach in a few throws per
/// point (random sequential packing ends at 0.78).
float poissonDiscDistance(int count);

}  // namespace penumbra
