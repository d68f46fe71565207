#include "core/sampling/sampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace penumbra {
namespace {

/// Whether each elementary interval of area 1/n holds exactly one of the first n = 2^bits points.
bool isNet(std::uint32_t seed, int bits, SobolPoint shift) {
    const std::uint32_t n = 1u << bits;
    for (int xBits = 0; xBits <= bits; ++xBits) {
        std::vector<bool> taken(n);
        for (std::uint32_t i = 0; i < n; ++i) {
            SobolPoint p = owenSobol(i, seed);
            p = {p.x ^ shift.x, p.y ^ shift.y};
            const std::uint64_t column = std::uint64_t{p.x} >> (32 - xBits);
            const std::uint64_t row = std::uint64_t{p.y} >> (32 - (bits - xBits));
            const std::size_t interval = (column << (bits - xBits)) | row;
            if (taken[interval]) return false;
            taken[interval] = true;
        }
    }
    return true;
}

TEST(Sampling, OwenScrambledSobolIsANetForEveryPowerOfTwo) {
    for (int bits = 4; bits <= 10; ++bits)
        for (std::uint32_t seed = 0; seed < 20; ++seed)
            EXPECT_TRUE(isNet(hash(seed), bits, {})) << (1 << bits) << " points, seed " << seed;
}

TEST(Sampling, DigitalShiftKeepsTheNet) {
    for (std::uint32_t seed = 0; seed < 20; ++seed)
        EXPECT_TRUE(isNet(7, 8, {hash(seed, 1u), hash(seed, 2u)})) << seed;
}

TEST(Sampling, FirstSobolPointsAreTheKnownOnes) {
    // The van der Corput sequence and the second Sobol dimension.
    const double x[] = {0, 0.5, 0.25, 0.75, 0.125}, y[] = {0, 0.5, 0.75, 0.25, 0.625};
    for (std::uint32_t i = 0; i < 5; ++i) {
        EXPECT_EQ(sobol(i).x * 0x1p-32, x[i]) << i;
        EXPECT_EQ(sobol(i).y * 0x1p-32, y[i]) << i;
    }
}

TEST(Sampling, ScramblesOfDifferentSeedsAreIndependent) {
    // The mean of x over a scramble's first 16 points, as a random variable of the seed: its
    // correlation between neighbouring seeds. 4096 pairs know it to 1/64; 4 sigma are allowed.
    constexpr int kSeeds = 4096;
    std::vector<double> mean(kSeeds + 1);
    for (int seed = 0; seed <= kSeeds; ++seed)
        for (std::uint32_t i = 0; i < 16; ++i)
            mean[seed] += (owenSobol(i, seed).x * 0x1p-32 - 0.5) / 16;
    double product = 0.0, square = 0.0;
    for (int seed = 0; seed < kSeeds; ++seed) {
        product += mean[seed] * mean[seed + 1];
        square += mean[seed] * mean[seed];
    }
    EXPECT_LT(std::abs(product / square), 4.0 / 64.0);
}

TEST(Sampling, EachPointIsUniformOverSeeds) {
    // Unbiasedness needs every single point uniform. 64 bins of 64 expected counts: chi-squared
    // with 63 degrees of freedom stays below 63 + 5 sqrt(126) but for one seed set in a million.
    for (const std::uint32_t index : {0u, 1u, 5u, 100u}) {
        std::vector<int> bins(64);
        for (std::uint32_t seed = 0; seed < 4096; ++seed) {
            const glm::vec2 p = owenSobol(index, hash(seed, 99u)).unit();
            ++bins[static_cast<int>(p.x * 8) * 8 + static_cast<int>(p.y * 8)];
        }
        double chi2 = 0.0;
        for (const int count : bins) chi2 += (count - 64.0) * (count - 64.0) / 64.0;
        EXPECT_LT(chi2, 63 + 5 * std::sqrt(126.0)) << index;
    }
}

TEST(Sampling, UnitFloatsNeverReachOne) {
    EXPECT_EQ(toUnitFloat(0), 0.0f);
    EXPECT_LT(toUnitFloat(0xffffffffu), 1.0f);
    EXPECT_EQ(toUnitFloat(0x80000000u), 0.5f);
}

TEST(Sampling, HashIsABijectionAndOrderMatters) {
    std::set<std::uint32_t> seen;
    for (std::uint32_t i = 0; i < 100000; ++i) seen.insert(hash(i));
    EXPECT_EQ(seen.size(), 100000u);
    EXPECT_NE(hash(1u, 2u), hash(2u, 1u));
    EXPECT_NE(hash(1u, 2u, 3u), hash(1u, 3u, 2u));
}

TEST(Sampling, VogelDiscIsEvenlyDense) {
    constexpr int kCount = 1000;
    int inner = 0;
    glm::vec2 centre(0.0f);
    for (int i = 0; i < kCount; ++i) {
        const glm::vec2 p = vogelDisc(i, kCount, 0.3f);
        EXPECT_LE(glm::length(p), 1.0f);
        inner += glm::length(p) < std::sqrt(0.5f);
        centre += p / static_cast<float>(kCount);
    }
    EXPECT_EQ(inner, kCount / 2) << "half the points lie within half the area";
    EXPECT_LT(glm::length(centre), 2e-3f) << "a few points of 1/1000 each may be unbalanced";
}

TEST(Sampling, PoissonDiscPointsKeepTheirDistanceInsideTheDisc) {
    for (const int count : {1, 2, 3, 4, 5, 7, 12, 25, 49, 121, 289, 1024}) {
        const std::vector<glm::vec2> points = poissonDisc(count);
        ASSERT_EQ(points.size(), static_cast<std::size_t>(count));
        EXPECT_EQ(points, poissonDisc(count));
        for (std::size_t i = 0; i < points.size(); ++i) {
            EXPECT_LE(glm::length(points[i]), 1.0f + 1e-6f);  // rounding
            for (std::size_t j = 0; j < i; ++j)
                ASSERT_GE(glm::distance(points[i], points[j]), poissonDiscDistance(count));
        }
    }
}

TEST(Sampling, PoissonDiscPointsFillTheDisc) {
    // As many in each half and in the inner disc of half the area. A binomial's deviation for 1024
    // points is 16; points that keep their distance stay well within three.
    const std::vector<glm::vec2> points = poissonDisc(1024);
    for (const glm::vec2& side : {glm::vec2(1, 0), glm::vec2(0, 1), glm::vec2(0.6f, -0.8f)})
        EXPECT_NEAR(std::ranges::count_if(
                        points, [&](const glm::vec2& p) { return glm::dot(p, side) > 0.0f; }),
                    512, 48);
    EXPECT_NEAR(
        std::ranges::count_if(points, [](const glm::vec2& p) { return glm::dot(p, p) < 0.5f; }),
        512, 48);
}

}  // namespace
}  // namespace penumbra
