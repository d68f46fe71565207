#include "harness/run/statistics.hpp"

#include <gtest/gtest.h>

#include <random>

namespace penumbra {
namespace {

TEST(Median, OfOddEvenAndSingleCounts) {
    EXPECT_EQ(median({7.0}), 7.0);
    EXPECT_EQ(median({9.0, 1.0, 5.0}), 5.0);
    EXPECT_EQ(median({8.0, 1.0, 2.0, 4.0}), 3.0);
    EXPECT_EQ(median({3.0, 3.0, 1e9, -1e9}), 3.0);
}

TEST(Summarise, MedianAndDeviationByHand) {
    // Deviations from 4 are 3, 2, 0, 1, 96; their median is 2: the outlier does not count.
    const TimingSummary s = summarise({1.0, 2.0, 4.0, 5.0, 100.0}, 0);
    EXPECT_EQ(s.median, 4.0);
    EXPECT_EQ(s.mad, 2.0);
}

TEST(Summarise, WithoutSpreadTheIntervalIsThePoint) {
    for (const std::vector<double>& values :
         {std::vector<double>{2.5}, std::vector<double>(6, 2.5)}) {
        const TimingSummary s = summarise(values, 1);
        EXPECT_EQ(s.median, 2.5);
        EXPECT_EQ(s.mad, 0.0);
        EXPECT_EQ(s.low, 2.5);
        EXPECT_EQ(s.high, 2.5);
        EXPECT_FALSE(s.unstable);
    }
}

// The median of a resample of 1..7 is at most k when at least 4 of 7 draws are, each with chance
// k/7: 1.0 % for k = 1 and 10.8 % for k = 2. The 2.5 % point is therefore 2, and 6 from above;
// 2,000 resamples miss those shares by 0.2 % and 0.7 %, far less than what parts them from 2.5 %.
TEST(Summarise, TheBootstrapIntervalIsTheBinomialOne) {
    for (const std::uint32_t seed : {0u, 1u, 12345u}) {
        const TimingSummary s = summarise({1, 2, 3, 4, 5, 6, 7}, seed);
        EXPECT_EQ(s.low, 2.0);
        EXPECT_EQ(s.high, 6.0);
        EXPECT_TRUE(s.unstable) << "4 is more than a fifth of the median 4";
    }
    EXPECT_FALSE(summarise({101, 102, 103, 104, 105, 106, 107}, 0).unstable)
        << "4 is less than a fifth of 104";
}

// Two values: both draws are the smaller one with chance 1/4, so it is the 2.5 % point.
TEST(Summarise, TwoValuesSpanTheirInterval) {
    const TimingSummary s = summarise({10.0, 4.0}, 3);
    EXPECT_EQ(s.median, 7.0);
    EXPECT_EQ(s.mad, 3.0);
    EXPECT_EQ(s.low, 4.0);
    EXPECT_EQ(s.high, 10.0);
}

TEST(Summarise, TheSameValuesAndSeedGiveTheSameInterval) {
    std::vector<double> values;
    for (int i = 0; i < 12; ++i) values.push_back(1.0 + 0.37 * ((i * 7) % 12));
    const TimingSummary a = summarise(values, 9), b = summarise(values, 9);
    EXPECT_EQ(a.low, b.low);
    EXPECT_EQ(a.high, b.high);
    EXPECT_LE(a.low, a.median);
    EXPECT_GE(a.high, a.median);
    EXPECT_LT(a.low, a.high);
}

// What the percentile bootstrap promises and keeps. Of 5 values its interval is the whole span (the
// least value is the resample's median with a chance of 5.8 %), which misses the true median with a
// chance of 2/32: 93.75 % is all that 5 repeats can give. Of more it is near 95 %; three standard
// deviations of 1,000 trials are 2.3 and 2.1 %, and the percentiles are those of a discrete
// distribution, which costs up to 1.5 %.
TEST(Summarise, TheBootstrapIntervalHoldsTheMedianAsOftenAsItSays) {
    constexpr int kTrials = 1000;
    for (const int n : {5, 9, 25}) {
        int held = 0;
        for (std::uint32_t trial = 0; trial < kTrials; ++trial) {
            std::mt19937 random(trial);
            std::lognormal_distribution<double> noise(0.0, 0.5);  // median 1
            std::vector<double> values;
            for (int i = 0; i < n; ++i) values.push_back(noise(random));
            const TimingSummary s = summarise(values, trial);
            held += s.low <= 1.0 && 1.0 <= s.high;
        }
        EXPECT_GE(held, (n == 5 ? 0.9375 - 0.023 : 0.95 - 0.036) * kTrials) << n;
    }
}

}  // namespace
}  // namespace penumbra
