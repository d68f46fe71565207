// The traced reference's error bars on the suite's own scenes, against exact visibility. Every
// scene prints the line of docs/TRUTH.md that it is.
#include "harness/reference/certificate.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "core/scene/scene.hpp"
#include "harness/reference/exact.hpp"
#include "tests/support/procedural.hpp"

namespace penumbra {
namespace {

constexpr double kTarget = ReferenceOptions{}.targetStandardError;

TEST(Certificate, CountsByHand) {
    Certificate c;
    c.add(0.5, 0.502, 0.001);    // inside 2.131 standard errors
    c.add(0.5, 0.497, 0.001);    // outside
    c.add(0.0, 0.004, 0.001);    // umbra: no error bar is asked for, but it can be the worst
    c.add(0.003, 0.003, 0.001);  // within 1/255 of 0
    EXPECT_EQ(c.pixels, 2);
    EXPECT_DOUBLE_EQ(c.coverage(), 0.5);
    EXPECT_NEAR(c.rmse(), std::sqrt((4e-6 + 9e-6) / 2), 1e-12);
    EXPECT_NEAR(c.meanSquare(), (4.0 + 9.0) / 2, 1e-9);
    EXPECT_NEAR(c.worst, 0.004, 1e-12);
    Certificate both = c;
    both.add(c);
    EXPECT_EQ(both.pixels, 4);
    EXPECT_DOUBLE_EQ(both.coverage(), 0.5);
    EXPECT_DOUBLE_EQ(both.rmse(), c.rmse());
    EXPECT_DOUBLE_EQ(both.worst, c.worst);
}

struct Subject {
    const char* scene;
    int frame;
};

void PrintTo(const Subject& subject, std::ostream* out) {
    *out << subject.scene << ' ' << subject.frame;
}

class ReferenceOnScenes : public testing::TestWithParam<Subject> {};

TEST_P(ReferenceOnScenes, CoversTheExactValue) {
    const auto [id, frameIndex] = GetParam();
    std::shared_ptr<const Scene> scene;
    try {
        scene = loadScene(id, SceneLibrary::standard());
    } catch (const AssetAbsent& e) {
        GTEST_SKIP() << e.what();
    }
    constexpr int kSize = 96;
    const SceneFrame frame = scene->frame(frameIndex);
    const Tracer tracer(frame.geometry, scene->materials, scene->images);
    const GBuffer gbuffer = renderGBuffer(tracer, frame, *scene, kSize, kSize);
    const Reference traced = traceReference(tracer, gbuffer, frame.light, {});
    const Reference exact = exactReference(tracer, scene->materials, gbuffer, frame.light);
    Certificate certificate;
    int constants = 0, beyondBound = 0;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (gbuffer.mask[i] != PixelClass::scored || exact.rays[i] > 0.0f) continue;
        certificate.add(exact.visibility[i], traced.visibility[i], traced.standardError[i]);
        // All rays agree: the zero-count bound 3/n holds for 95 % of such pixels at the least.
        if (traced.visibility[i] == 0.0f || traced.visibility[i] == 1.0f) {
            ++constants;
            beyondBound +=
                std::abs(exact.visibility[i] - traced.visibility[i]) > traced.standardError[i];
        }
    }
    fmt::print("| {} {} | {} | {:.2f} | {:.1f} % | {:.2f} | {:.4f} | {} of {} |\n", id, frameIndex,
               certificate.pixels, certificate.rmse() / kTarget, 100 * certificate.coverage(),
               std::sqrt(certificate.meanSquare()), certificate.worst, beyondBound, constants);
    ASSERT_GT(certificate.pixels, 500);
    EXPECT_GE(certificate.coverage(), Certificate::kLeastCoverage);
    EXPECT_LE(certificate.coverage(), Certificate::kMostCoverage);
    EXPECT_LE(certificate.rmse(), Certificate::kMostRmse * kTarget);
    EXPECT_LE(certificate.worst, Certificate::kMostError);
    EXPECT_LE(beyondBound, 0.05 * constants);

    // The sample that every run takes is part of the same truth.
    const Certificate sample = certify(traced, tracer, scene->materials, gbuffer, frame.light, 200);
    EXPECT_GT(sample.pixels, 180);
    EXPECT_LE(sample.pixels, 200);
    EXPECT_LE(sample.worst, certificate.worst + 1e-6) << "grouped pixels differ by rounding";
    EXPECT_NEAR(sample.coverage(), certificate.coverage(),
                4 * std::sqrt(0.95 * 0.05 / sample.pixels));
}

INSTANTIATE_TEST_SUITE_P(Scenes, ReferenceOnScenes,
                         testing::Values(Subject{"fence", 2}, Subject{"foliage", 0},
                                         Subject{"antennas", 0}, Subject{"contact", 0},
                                         Subject{"two_layers", 1}, Subject{"sphere_plate", 0},
                                         Subject{"arcade", 0}, Subject{"engine", 0},
                                         Subject{"spinner", 1}),
                         [](const auto& subject) { return subject.param.scene; });

TEST(ReferenceOnThinWires, FindsThemOrSaysThatTheyMightHaveBeenMissed) {
    // Seen from the floor a wire in z = 2 hides a strip of the light in z = 4: 0.4 % of it, which
    // 256 rays miss one time in three. A bar beside it makes the pixels there mixed ones.
    const AreaLight light = test::lightAbove(4.0, 1.0, 1.0);
    for (const bool besideABar : {false, true}) {
        const double wire = 0.002;
        test::Shape casters;
        casters.rectangle({-wire / 2, -3}, {wire / 2, 3}, 2.0);
        if (besideABar) casters.rectangle({0.15, -3}, {0.25, 3}, 2.0);
        const GBuffer floor =
            test::planeGBuffer(64, 64, {-0.3, -0.3, 0}, {0.6, 0, 0}, {0, 0.6, 0}, light);
        const Tracer tracer(casters.geometry(), test::kOpaque, test::kNoImages);
        const Reference traced = traceReference(tracer, floor, light, {});
        const Reference exact = exactReference(tracer, test::kOpaque, floor, light);
        int crossed = 0, missed = 0, unsaid = 0;
        for (std::size_t i = 0; i < floor.size(); ++i) {
            if (exact.visibility[i] > 0.9965f) continue;
            ++crossed;
            const double error = std::abs(traced.visibility[i] - exact.visibility[i]);
            if (error < 3e-3) continue;
            ++missed;
            unsaid += error > 3 * traced.standardError[i];
        }
        ASSERT_GT(crossed, 3000);
        // Neighbours that found it make the others look again, with 1280 rays together, of which
        // all miss with a probability of exp(-0.004 * 1280) = 0.6 %.
        EXPECT_LT(missed, 0.01 * crossed) << besideABar;
        // Constant pixels carry the zero-count bound; what is left are pixels that found a piece of
        // the wire, or the bar, and no more in some 1800 rays: exp(-0.004 * 1800) = 0.07 %.
        if (!besideABar) {
            EXPECT_LE(unsaid, 0.002 * crossed);
        }
    }
}

}  // namespace
}  // namespace penumbra
