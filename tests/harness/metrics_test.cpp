#include "harness/metrics/metrics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "harness/run/row.hpp"

namespace penumbra {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// One row of pixels, all scored and on a reference without noise until a test says otherwise.
struct Strip {
    GBuffer gbuffer;
    Reference reference;

    explicit Strip(std::vector<float> truth) {
        const auto n = static_cast<int>(truth.size());
        gbuffer.width = reference.width = n;
        gbuffer.height = reference.height = 1;
        gbuffer.position.assign(truth.size(), glm::vec3(0));
        gbuffer.geometricNormal.assign(truth.size(), glm::vec3(0, 1, 0));
        gbuffer.shadingNormal = gbuffer.geometricNormal;
        gbuffer.albedo.assign(truth.size(), glm::vec3(0.5F));
        gbuffer.mask.assign(truth.size(), PixelClass::scored);
        gbuffer.irradianceUnshadowed.assign(truth.size(), 1.0F);
        reference.standardError.assign(truth.size(), 0.0F);
        reference.rays.assign(truth.size(), 1.0F);
        reference.irradiance = truth;
        reference.irradianceUnshadowed.assign(truth.size(), 1.0F);
        reference.visibility = std::move(truth);
    }
    Metrics score(const std::vector<float>& visibility) const {
        return Scorer(reference, gbuffer).score(visibility);
    }
};

// Inputs are sums of powers of two, so that the hand-computed results are exact; the square roots
// and the divisions by three round once.

TEST(Score, PerfectImageHasNoError) {
    const Strip strip({0, 0.25F, 0.5F, 1});
    const Metrics m = strip.score(strip.reference.visibility);
    EXPECT_EQ(m.rmse, 0.0);
    EXPECT_EQ(m.mae, 0.0);
    EXPECT_EQ(m.bias, 0.0);
    EXPECT_EQ(m.p99, 0.0);
    EXPECT_EQ(m.maxError, 0.0);
    EXPECT_EQ(m.leakRate, 0.0);
    EXPECT_EQ(m.falseShadowRate, 0.0);
    EXPECT_EQ(m.scoredPixels, 4U);
    EXPECT_EQ(m.nonfinite, 0U);
    EXPECT_EQ(m.outOfRange, 0U);
}

TEST(Score, HeadlineNumbersByHand) {
    const Strip strip({0, 0.5F, 0.5F, 1});
    // Errors +1/2, +1/4, -1/4, 0.
    const Metrics m = strip.score({0.5F, 0.75F, 0.25F, 1});
    EXPECT_DOUBLE_EQ(m.rmse.value(), std::sqrt((0.25 + 0.0625 + 0.0625) / 4));
    EXPECT_DOUBLE_EQ(m.mae.value(), 0.25);
    EXPECT_DOUBLE_EQ(m.bias.value(), 0.125);
    EXPECT_DOUBLE_EQ(m.p99.value(), 0.5);
    EXPECT_DOUBLE_EQ(m.maxError.value(), 0.5);
}

TEST(Score, BiasIsPositiveForLeaksAndNegativeForOverShadowing) {
    const Strip strip({0.5F, 0.5F});
    EXPECT_DOUBLE_EQ(strip.score({0.75F, 0.75F}).bias.value(), 0.25);
    EXPECT_DOUBLE_EQ(strip.score({0.25F, 0.25F}).bias.value(), -0.25);
}

TEST(Score, ClassesComeFromTheReference) {
    const Strip strip({0, 0, 0.5F, 1, 1, 1});
    const Metrics m = strip.score({0.25F, 0, 0.375F, 0.5F, 1, 1});
    EXPECT_DOUBLE_EQ(m.rmseUmbra.value(), std::sqrt(0.0625 / 2));
    EXPECT_DOUBLE_EQ(m.rmsePenumbra.value(), 0.125);
    EXPECT_DOUBLE_EQ(m.rmseLit.value(), std::sqrt(0.25 / 3));
    EXPECT_DOUBLE_EQ(m.leakRate.value(), 0.5);
    EXPECT_DOUBLE_EQ(m.falseShadowRate.value(), 1.0 / 3);
}

TEST(Score, LeakAndFalseShadowThresholdsAreExclusive) {
    const Strip strip({0, 0, 1, 1});
    // float(0.05) lies above 1/20 and float(0.95) below 19/20, so that the nearest floats on the
    // quiet side are the ones that must not count.
    const float quietLeak = std::nextafter(0.05F, 0.0F);
    const float quietShadow = std::nextafter(0.95F, 1.0F);
    const Metrics quiet = strip.score({quietLeak, 0, quietShadow, 1});
    EXPECT_EQ(quiet.leakRate, 0.0);
    EXPECT_EQ(quiet.falseShadowRate, 0.0);
    const Metrics loud = strip.score({0.0501F, 0, 0.9499F, 1});
    EXPECT_EQ(loud.leakRate, 0.5);
    EXPECT_EQ(loud.falseShadowRate, 0.5);
}

TEST(Score, AbsentClassesHaveNoNumbers) {
    const Strip lit({1, 1});
    const Metrics m = lit.score({1, 1});
    EXPECT_TRUE(m.rmseLit.has_value());
    EXPECT_FALSE(m.rmsePenumbra.has_value());
    EXPECT_FALSE(m.rmseUmbra.has_value());
    EXPECT_FALSE(m.leakRate.has_value());
    EXPECT_FALSE(m.referenceSe.has_value());
    EXPECT_FALSE(Strip({0}).score({0}).falseShadowRate.has_value());
}

TEST(Score, P99IsTheNearestRank) {
    // 200 errors 1/256 ... 200/256: rank ceil(0.99 * 200) = 198.
    std::vector<float> drawn(200);
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        drawn[i] = static_cast<float>(i + 1) / 256.0F;
    }
    const Strip strip(std::vector<float>(200, 0.0F));
    const Metrics m = strip.score(drawn);
    EXPECT_DOUBLE_EQ(m.p99.value(), 198.0 / 256);
    EXPECT_DOUBLE_EQ(m.maxError.value(), 200.0 / 256);
}

TEST(Score, P99OfOneHundredAndOfOneHundredAndOne) {
    for (const std::size_t n : {100U, 101U}) {
        std::vector<float> drawn(n, 0.0F);
        drawn.back() = 0.5F;
        drawn[0] = 0.25F;
        // ceil(99) = 99 and ceil(99.99) = 100: both leave exactly the largest one out.
        EXPECT_DOUBLE_EQ(Strip(std::vector<float>(n, 0.0F)).score(drawn).p99.value(), 0.25) << n;
    }
}

TEST(Score, HorizonPixelsAreCountedButNotAveraged) {
    Strip strip({0, 0.5F, 1});
    strip.gbuffer.mask[1] = PixelClass::horizon;
    const Metrics m = strip.score({0, 1, 1});
    EXPECT_EQ(m.scoredPixels, 2U);
    EXPECT_EQ(m.horizonPixels, 1U);
    EXPECT_EQ(m.rmse, 0.0);
    EXPECT_EQ(m.maxError, 0.0);
}

TEST(Score, BackgroundAndFacingAwayPixelsDoNotExist) {
    Strip strip({0, 1, 0});
    strip.gbuffer.mask[1] = PixelClass::background;
    strip.gbuffer.mask[2] = PixelClass::facingAway;
    const Metrics m = strip.score({0.25F, kNan, 7});
    EXPECT_EQ(m.scoredPixels, 1U);
    EXPECT_EQ(m.horizonPixels, 0U);
    EXPECT_EQ(m.nonfinite, 0U);
    EXPECT_EQ(m.outOfRange, 0U);
    EXPECT_DOUBLE_EQ(m.rmse.value(), 0.25);
}

TEST(Score, NonfinitePixelsAreCountedAndLeftOutOfEveryMean) {
    Strip strip({0, 0, 0.5F, 1, 1, 0});
    strip.gbuffer.mask[5] = PixelClass::horizon;
    const Metrics m = strip.score({kNan, 0.5F, -kInf, kInf, 0.5F, kNan});
    EXPECT_EQ(m.nonfinite, 4U);
    EXPECT_EQ(m.outOfRange, 0U);
    EXPECT_EQ(m.scoredPixels, 5U);
    EXPECT_DOUBLE_EQ(m.rmse.value(), 0.5);
    EXPECT_DOUBLE_EQ(m.bias.value(), 0.0);
    EXPECT_DOUBLE_EQ(m.maxError.value(), 0.5);
    EXPECT_EQ(m.leakRate, 1.0);
    EXPECT_EQ(m.falseShadowRate, 1.0);
    EXPECT_FALSE(m.rmsePenumbra.has_value());
}

TEST(Score, AnImageOfNothingButNansHasNoMeans) {
    const Metrics m = Strip({0, 1}).score({kNan, kNan});
    EXPECT_EQ(m.nonfinite, 2U);
    EXPECT_FALSE(m.rmse || m.mae || m.bias || m.p99 || m.maxError || m.leakRate);
}

TEST(Score, OutOfRangePixelsAreCountedAndAveragedAsTheyAre) {
    const Metrics m = Strip({0, 0, 1, 1}).score({-0.5F, 0, 1.5F, 1});
    EXPECT_EQ(m.outOfRange, 2U);
    EXPECT_DOUBLE_EQ(m.bias.value(), 0.0);
    EXPECT_DOUBLE_EQ(m.mae.value(), 0.25);
    EXPECT_DOUBLE_EQ(m.maxError.value(), 0.5);
}

TEST(Score, ReferenceErrorIsRmsOverScoredPenumbraPixels) {
    Strip strip({0, 0.5F, 0.5F, 0.5F});
    strip.gbuffer.mask[3] = PixelClass::horizon;
    strip.reference.standardError = {0.125F, 0.03125F, 0.0F, 0.5F};
    // A pixel that the method spoilt says nothing about the reference.
    const Metrics m = strip.score({0, kNan, 0.5F, 0.5F});
    EXPECT_DOUBLE_EQ(m.referenceSe.value(), 0.03125 / std::sqrt(2.0));
}

TEST(Score, CorrectedRmseLeavesOutTheReferencesNoise) {
    Strip strip({0, 0.5F, 0.5F, 1});
    strip.reference.standardError = {0.5F, 0.25F, 0.25F, 0.5F};
    // Errors 1/2 and 1/2 in the penumbra. Of the reference only measured errors count: the bound of
    // 1/2 at pixels whose rays all agree is no error.
    const Metrics m = strip.score({0, 1, 0, 1});
    EXPECT_DOUBLE_EQ(m.rmse.value(), std::sqrt(0.5 / 4));
    EXPECT_DOUBLE_EQ(m.rmseCorrected.value(), std::sqrt((0.5 - 0.125) / 4));
    EXPECT_EQ(strip.score({0, 0.625F, 0.5F, 1}).rmseCorrected, 0.0) << "noise explains it all";
    EXPECT_FALSE(strip.score({kNan, kNan, kNan, kNan}).rmseCorrected);
}

/// A square of scored pixels, large enough for SSIM's window.
Strip square(const std::vector<float>& truth) {
    Strip out(truth);
    out.gbuffer.width = out.gbuffer.height = out.reference.width = out.reference.height =
        static_cast<int>(std::lround(std::sqrt(static_cast<double>(truth.size()))));
    return out;
}

TEST(Score, PerfectImageIsSimilarAndUnflipped) {
    const Strip strip = square(std::vector<float>(256, 0.5F));
    const Metrics m = strip.score(strip.reference.visibility);
    EXPECT_NEAR(m.ssim.value(), 1.0, 1e-12);  // rounding of variances, over C2
    EXPECT_EQ(m.flip, 0.0);
    EXPECT_EQ(m.noise, 0.0);
    EXPECT_FALSE(m.flicker) << "one frame has none";
    EXPECT_FALSE(Strip({0, 1}).score({0, 1}).ssim) << "no window fits";
}

TEST(Score, FlipIsOfTheShadedPictures) {
    // All albedos and irradiances alike: V is drawn as 0.8 (V + 0.04), 4 % being ambient. FLIP of
    // constant greys depends on lightness alone: L = 116 cbrt(Y) - 16, d = |L1 - L0|^0.7.
    const Strip strip = square(std::vector<float>(256, 1.0F));
    const double lit = 116 * std::cbrt(0.8 * 1.04) - 16, dark = 116 * std::cbrt(0.8 * 0.54) - 16;
    const double cmax = 41.2761, distance = std::pow(lit - dark, 0.7);
    ASSERT_LT(distance, 0.4 * cmax);
    // cmax has six digits, the picture float.
    EXPECT_NEAR(strip.score(std::vector<float>(256, 0.5F)).flip.value(),
                distance * 0.95 / (0.4 * cmax), 1e-5);
}

TEST(Score, WhatNobodyAnswersForDoesNotShowInNeighbours) {
    Strip strip = square(std::vector<float>(400, 0.5F));
    std::vector<float> drawn(400, 0.5F);
    for (std::size_t i = 0; i < 400; i += 7) {
        strip.gbuffer.mask[i] = static_cast<PixelClass>(i % 4 == 1 ? 0 : i % 4);
        if (strip.gbuffer.mask[i] != PixelClass::background) drawn[i] = i % 2 ? kNan : 0.9F;
    }
    drawn[18] = kNan;
    const Metrics m = strip.score(drawn);
    EXPECT_EQ(m.flip, 0.0);
    EXPECT_NEAR(m.ssim.value(), 1.0, 1e-12);
    EXPECT_EQ(m.noise, 0.0);
}

TEST(Score, SmallErrorsSurviveBesideLargeOnes) {
    // A million errors of 2^-12 after one of 1: in float their squares would vanish in the sum.
    std::vector<float> drawn(1'000'001, 1.0F / 4096);
    drawn[0] = 1.0F;
    const Metrics m = Strip(std::vector<float>(drawn.size(), 0.0F)).score(drawn);
    const double sumSquares = 1.0 + 1e6 / (4096.0 * 4096.0);
    EXPECT_DOUBLE_EQ(m.rmse.value(), std::sqrt(sumSquares / 1'000'001));
}

TEST(Score, SizesMustAgree) {
    EXPECT_THROW(Strip({0, 1}).score({0}), std::invalid_argument);
}

TEST(AllMetrics, AreDocumentedCsvColumnsInTheirOrder) {
    const std::string header = "," + csvHeader() + ",";
    std::size_t last = 0;
    for (const MetricInfo& metric : allMetrics()) {
        const std::size_t at = header.find("," + std::string(metric.id) + ",");
        ASSERT_NE(at, std::string::npos) << metric.id;
        EXPECT_GT(at, last) << metric.id << " is out of order";
        last = at;
        EXPECT_FALSE(metric.unit.empty()) << metric.id;
        EXPECT_GT(metric.doc.size(), 20U) << metric.id;
    }
    EXPECT_EQ(allMetrics().size(), 22U);
}

}  // namespace
}  // namespace penumbra
