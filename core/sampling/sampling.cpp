#include "core/sampling/sampling.hpp"

#include <algorithm>
#include <cmath>

namespace penumbra {

SobolPoint sobol(std::uint32_t index) {
    // Dimension 0 is the radical inverse; the direction numbers of dimension 1 (polynomial x + 1)
    // follow from each other by v ^= v >> 1.
    SobolPoint p{reverseBits(index), 0};
    for (std::uint32_t v = 1u << 31; index != 0; index >>= 1, v ^= v >> 1)
        if (index & 1u) p.y ^= v;
    return p;
}

std::uint32_t owenScramble(std::uint32_t x, std::uint32_t seed) {
    // The permutation lets low bits alter only higher ones; reversed, each digit of the coordinate
    // is permuted depending on those above it.
    x = reverseBits(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

SobolPoint owenSobol(std::uint32_t index, std::uint32_t seed) {
    const SobolPoint p = sobol(index);
    return {owenScramble(p.x, hash(seed, 0u)), owenScramble(p.y, hash(seed, 1u))};
}

glm::vec2 vogelDisc(int index, int count, float phaseRad) {
    constexpr float kGoldenAngleRad = 2.39996323f;
    const float radius = std::sqrt((static_cast<float>(index) + 0.5f) / static_cast<float>(count));
    const float angle = static_cast<float>(index) * kGoldenAngleRad + phaseRad;
    return radius * glm::vec2(std::cos(angle), std::sin(angle));
}

std::vector<glm::vec2> poissonDisc(int count) {
    const float apart = poissonDiscDistance(count);
    std::vector<glm::vec2> points;
    for (std::uint32_t dart = 0; points.size() < static_cast<std::size_t>(count); ++dart) {
        const glm::vec2 p =
            2.0f * glm::vec2(toUnitFloat(hash(dart, 0u)), toUnitFloat(hash(dart, 1u))) - 1.0f;
        if (glm::dot(p, p) > 1.0f) continue;
        if (std::ranges::all_of(points,
                                [&](const glm::vec2& q) { return glm::distance(p, q) >= apart; }))
            points.push_back(p);
    }
    return points;
}

float poissonDiscDistance(int count) {
    return 1.2f / std::sqrt(static_cast<float>(count));
}

}  // namespace penumbra
