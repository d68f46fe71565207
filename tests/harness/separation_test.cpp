#include "harness/run/separation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "harness/reference/exact.hpp"
#include "harness/run/compare.hpp"
#include "harness/run/merge.hpp"
#include "tests/support/compare_fixture.hpp"
#include "tests/support/procedural.hpp"

namespace penumbra {
namespace {

TEST(SeparationImage, IsTheCoupledOverTheUnshadowedIrradiance) {
    GBuffer gbuffer;
    gbuffer.width = 6;
    gbuffer.height = 1;
    gbuffer.mask = {PixelClass::scored,  PixelClass::horizon,    PixelClass::scored,
                    PixelClass::horizon, PixelClass::background, PixelClass::facingAway};
    Reference reference;
    reference.visibility = {0.25f, 0.5f, 0.5f, 0.5f, 1.0f, 0.0f};
    reference.irradiance = {0.3f, 0.1f, 0.0f, 0.0f, 0.0f, 0.0f};
    reference.irradianceUnshadowed = {0.4f, 0.4f, 0.0f, 0.0f, 0.0f, 0.0f};
    const std::vector<float> image = separationImage(reference, gbuffer);
    EXPECT_FLOAT_EQ(image[0], 0.75f);
    EXPECT_FLOAT_EQ(image[1], 0.25f);
    EXPECT_TRUE(std::isnan(image[2])) << "no light to share";
    EXPECT_TRUE(std::isnan(image[3]));
    EXPECT_EQ(image[4], 1.0f) << "background";
    EXPECT_EQ(image[5], 0.0f) << "facing away";
}

/// Below the half plane x > edge at `height`, points at x from `from` to `to`.
struct HalfPlane {
    AreaLight light;
    GBuffer gbuffer;
    Tracer tracer;

    HalfPlane(const AreaLight& lamp, double edge, double height, double from, double to)
        : light(lamp),
          gbuffer(
              test::planeGBuffer(64, 1, {from, -0.5e-3, 0}, {to - from, 0, 0}, {0, 1e-3, 0}, lamp)),
          tracer(sheet(edge, height), test::kOpaque, test::kNoImages) {}

    static std::shared_ptr<const Geometry> sheet(double edge, double height) {
        test::Shape shape;
        shape.rectangle({edge, -5}, {edge + 5, 5}, height);
        return shape.geometry();
    }
    Reference exact() const { return exactReference(tracer, test::kOpaque, gbuffer, light); }
};

TEST(SeparationImage, IsVWhereTheLightIsSmallAndFar) {
    // A light of 1 cm, 100 m up; its image of the edge moves over the points. Over the light the
    // geometry factor H^2 / (H^2 + d^2)^2 varies by no more than 4 d w / H^2 = 1e-7 of itself, less
    // than float resolves.
    const HalfPlane scene(test::lightAbove(100, 0.01, 0.01), 0.0, 50.0, -0.02, 0.02);
    const Reference reference = scene.exact();
    const std::vector<float> image = separationImage(reference, scene.gbuffer);
    int partly = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        partly += reference.visibility[i] > 0.0f && reference.visibility[i] < 1.0f;
        EXPECT_NEAR(image[i], reference.visibility[i], 2e-7) << i;
    }
    EXPECT_GT(partly, 10);
}

constexpr double kHeightM = 1.0;

/// From the light 2 m wide, of its part at x from `from` to `to`, E = integral of H^2 / r^4 by the
/// midpoint rule. No lambda: GCC evaluates a constexpr one itself, for half a minute.
double irradianceByQuadrature(double from, double to) {
    constexpr int kSteps = 1000;
    constexpr double kH = kHeightM;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const double dx = from + (to - from) * (i + 0.5) / kSteps;
            const double dy = -1.0 + 2.0 * (j + 0.5) / kSteps;
            const double r2 = dx * dx + dy * dy + kH * kH;
            sum += kH * kH / (r2 * r2);
        }
    return sum * (to - from) * 2.0 / (kSteps * kSteps);
}

TEST(SeparationImage, OfAHalfHiddenLargeLightByQuadrature) {
    // From x = 1.5 the edge at 0.75, half-way up to a light 2 m wide and 1 m above, hides the
    // light's nearer half.
    constexpr double kX = 1.5, kH = kHeightM;
    const HalfPlane scene(test::lightAbove(kH, 2, 2), 0.5 * kX, 0.5 * kH, kX - 1e-6, kX + 1e-6);
    const double farther = irradianceByQuadrature(-1 - kX, -kX);
    const double nearer = irradianceByQuadrature(-kX, 1 - kX);
    const double expected = farther / (farther + nearer);
    EXPECT_LT(expected, 0.25) << "the visible half gives far less than half the light";
    const std::size_t middle = 32;

    const Reference exact = scene.exact();
    EXPECT_NEAR(exact.visibility[middle], 0.5, 1e-5);
    EXPECT_NEAR(separationImage(exact, scene.gbuffer)[middle], expected, 1e-5)
        << "the midpoint rule errs by (1/1000)^2 times second derivatives of order 1";

    ReferenceOptions options;
    const Reference traced = traceReference(scene.tracer, scene.gbuffer, scene.light, options);
    EXPECT_NEAR(separationImage(traced, scene.gbuffer)[middle], expected,
                4 * options.targetStandardError)
        << "the weights are at most twice their mean, and V errs by one target in most pixels";
}

// ---- runs ------------------------------------------------------------------------------------

class SeparationRun : public test::CompareTest {
  protected:
    std::vector<std::string> settingsOf(const std::string& run) const {
        std::vector<std::string> list;
        for (const Row& r : rows(run)) list.push_back(r.setting);
        return list;
    }
};
using Texts = std::vector<std::string>;

TEST_F(SeparationRun, IsARowOfItsOwn) {
    ASSERT_EQ(compare(options("run", {"half_plane"}, {"separation", "hard"})), 0);
    EXPECT_EQ(settingsOf("run"), (Texts{"hard", "separation"})) << "last, wherever it was named";
    const Row r = row("run", "separation");
    EXPECT_TRUE(isSeparation(r));
    EXPECT_FALSE(isSeparation(row("run", "hard")));
    EXPECT_EQ(r.status, "ok");
    EXPECT_EQ(r.params, "");
    EXPECT_EQ(r.width, 64);
    EXPECT_EQ(r.repeats, 0);
    for (const auto& none : {r.frameMs, r.frameMsLow, r.frameMsHigh, r.frameMsMad, r.buildMs,
                             r.shadeMs, r.prepareMs, r.drawCalls, r.triangles, r.fragments, r.maps,
                             r.lightTexels, r.textureMib, r.metrics.rmseCorrected})
        EXPECT_FALSE(none);
    EXPECT_EQ(r.effectsSimulated + r.effectsSkipped + r.effectsMissing, "");
    EXPECT_EQ(r.renderer, row("run", "hard").renderer);
    EXPECT_EQ(r.metrics.scoredPixels, 64u * 64u);
    EXPECT_EQ(r.metrics.nonfinite, 0u);
    EXPECT_GT(r.metrics.rmse.value(), 0.0);
    EXPECT_TRUE(r.metrics.penumbraWidthError);

    const RunFolder folder_(path("run"));
    const std::vector<float> image = folder_.readVisibility("half_plane", 0, "separation");
    const Reference reference = folder_.readReference("half_plane", 0);
    EXPECT_EQ(image, separationImage(reference, folder_.readGBuffer("half_plane", 0)));
    EXPECT_EQ(record("run").settings.size(), 2u);
}

TEST_F(SeparationRun, NeedsNoMethodAndIsNotThereUnasked) {
    ASSERT_EQ(compare(options("alone", {script("still")}, {"separation"})), 0);
    EXPECT_EQ(settingsOf("alone"), (Texts{"separation", "separation"}));
    EXPECT_TRUE(row("alone", "separation", 1).metrics.flicker) << "as of any image";
    ASSERT_EQ(compare(options("other", {"half_plane"}, {"hard"})), 0);
    EXPECT_EQ(settingsOf("other"), Texts{"hard"});
}

TEST_F(SeparationRun, IsACellToResumeShardsAndMerge) {
    const Texts scenes = {script("still")}, both = {"hard", "separation"};
    ASSERT_EQ(compare(options("whole", scenes, both)), 0);

    ASSERT_EQ(compare(options("resumed", scenes, {"hard"})), 0);
    CompareOptions again = options("resumed", scenes, both);
    again.resume = true;
    ASSERT_EQ(compare(again), 0);

    for (const int shard : {1, 2}) {
        CompareOptions o = options("shard" + std::to_string(shard), scenes, both);
        o.shard = shard;
        o.shards = 2;
        ASSERT_EQ(compare(o), 0);
    }
    EXPECT_EQ(settingsOf("shard1"), (Texts{"hard", "hard"}));
    EXPECT_EQ(settingsOf("shard2"), (Texts{"separation", "separation"}));
    ASSERT_EQ(mergeRuns(path("merged"), {path("shard2"), path("shard1")}), 0);

    for (const char* run : {"resumed", "merged"}) {
        EXPECT_EQ(test::untimedRows(path(run)), test::untimedRows(path("whole"))) << run;
        test::expectSameFiles(path(run) / "images", path("whole") / "images");
        EXPECT_TRUE(std::filesystem::exists(RunFolder(path(run)).grid("still"))) << run;
    }
}

}  // namespace
}  // namespace penumbra
