// The traced reference's standard error against the exact value, and the exact value against an
// independent renderer: rays through a random soup of triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/analytic/exact_support.hpp"

namespace penumbra {
namespace {

/// How far rays are from the truth, in standard errors, over the pixels that see 5 to 95 % of the
/// light: nearer to 0 and 1 few of the replicates differ and their spread is no estimate.
struct Standardised {
    int pixels = 0;
    double mean = 0.0, meanSquare = 0.0, covered = 0.0;
    double rmse = 0.0, worst = 0.0;
};

Standardised compare(const Reference& traced, const Reference& exact) {
    constexpr double kQuantile = 2.131;  // Student's t, 15 degrees of freedom, 95 % two-sided
    Standardised result;
    for (std::size_t i = 0; i < exact.visibility.size(); ++i) {
        const double truth = exact.visibility[i], error = traced.visibility[i] - truth;
        result.worst = std::max(result.worst, std::abs(error));
        if (truth < 0.05 || truth > 0.95) continue;
        const double t = error / traced.standardError[i];
        ++result.pixels;
        result.mean += t;
        result.meanSquare += t * t;
        result.covered += std::abs(t) <= kQuantile;
        result.rmse += error * error;
    }
    result.mean /= result.pixels;
    result.meanSquare /= result.pixels;
    result.covered /= result.pixels;
    result.rmse = std::sqrt(result.rmse / result.pixels);
    return result;
}

class ExactAgainstEmbree : public testing::Test {
  protected:
    const AreaLight light_ =
        test::turned(test::lightAbove(4.0, 1.6, 1.2), test::turn({1, -2, 0.5}, 0.3));
    const test::Shape shape_ = test::shapeOf(test::soup(120, 41));
    const Tracer tracer_{shape_.geometry(), test::kOpaque, test::kNoImages};
    const GBuffer points_ = test::floorPoints(40, light_);
    const Reference exact_ = exactReference(tracer_, test::kOpaque, points_, light_);
};

TEST_F(ExactAgainstEmbree, ErrorsOfSixteenReplicatesFollowStudentsT) {
    // 16 replicates of a fixed number of rays: t with 15 degrees of freedom, mean 0, mean square
    // 15/13. Four standard deviations of each over n independent pixels; a mean square has the
    // variance (3.545 - 1) (15/13)^2 / n, 3.545 being t's kurtosis.
    ReferenceOptions options;
    options.adaptive = false;
    options.maxRaysPerPixel = 2048;
    const Standardised t = compare(traceReference(tracer_, points_, light_, options), exact_);
    ASSERT_GT(t.pixels, 500);
    const double n = t.pixels;
    EXPECT_NEAR(t.mean, 0.0, 4 * std::sqrt(15.0 / 13.0 / n));
    EXPECT_NEAR(t.meanSquare, 15.0 / 13.0, 4 * 15.0 / 13.0 * std::sqrt(2.545 / n));
    EXPECT_NEAR(t.covered, 0.95, 4 * std::sqrt(0.95 * 0.05 / n));
}

TEST_F(ExactAgainstEmbree, AdaptiveRaysKeepTheirTarget) {
    const ReferenceOptions options;
    const Standardised t = compare(traceReference(tracer_, points_, light_, options), exact_);
    ASSERT_GT(t.pixels, 500);
    EXPECT_LE(t.rmse, 1.2 * options.targetStandardError);
    EXPECT_LE(t.worst, 8e-3);
    EXPECT_GE(t.covered, 0.93);
    EXPECT_LE(t.covered, 0.99);
}

TEST_F(ExactAgainstEmbree, CoupledIrradianceAgrees) {
    ReferenceOptions options;
    options.adaptive = false;
    options.maxRaysPerPixel = 4096;
    const Reference traced = traceReference(tracer_, points_, light_, options);
    // What coupling adds to the visibility is known better from rays than either is, since the same
    // rays give both.
    double error = 0.0, effect = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const auto added = [&](const Reference& reference) {
            return double{reference.irradiance[i]} / reference.irradianceUnshadowed[i] -
                   reference.visibility[i];
        };
        error += std::pow(added(traced) - added(exact_), 2);
        effect += std::pow(added(exact_), 2);
    }
    EXPECT_LT(std::sqrt(error), 0.05 * std::sqrt(effect));
}

}  // namespace
}  // namespace penumbra
