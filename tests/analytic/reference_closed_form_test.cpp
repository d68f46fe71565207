#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "harness/reference/reference.hpp"
#include "tests/support/closed_forms.hpp"
#include "tests/support/procedural.hpp"

namespace penumbra {
namespace {

using closed_form::Rect;

constexpr int kSize = 128;
constexpr double kTarget = 1.0 / 1024;

/// The reference against a closed form at kSize^2 points: rmse over penumbra pixels at most 1.2
/// targets, no pixel off by more than 8e-3, and 95 % intervals (Student's t, 16 replicates) that
/// cover the truth for 93 to 99 % of penumbra pixels.
void certify(const test::Shape& casters, const GBuffer& gbuffer, const AreaLight& light,
             const std::function<double(const glm::dvec3&)>& truth) {
    const Tracer tracer(casters.geometry(), test::kOpaque, test::kNoImages);
    const Reference reference = traceReference(tracer, gbuffer, light, {});
    int penumbra = 0, covered = 0;
    double squares = 0.0, worst = 0.0;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        ASSERT_EQ(gbuffer.mask[i], PixelClass::scored);
        const double expected = truth(glm::dvec3(gbuffer.position[i]));
        const double error = reference.visibility[i] - expected;
        worst = std::max(worst, std::abs(error));
        if (expected < 1.0 / 255 || expected > 1.0 - 1.0 / 255) continue;
        ++penumbra;
        squares += error * error;
        covered += std::abs(error) <= 2.131 * reference.standardError[i];
    }
    ASSERT_GT(penumbra, kSize * kSize / 20);
    EXPECT_LE(std::sqrt(squares / penumbra), 1.2 * kTarget);
    EXPECT_LE(worst, 8e-3);
    const double coverage = static_cast<double>(covered) / penumbra;
    EXPECT_GE(coverage, 0.93);
    EXPECT_LE(coverage, 0.99);
}

/// The plane z = 0 around the origin.
GBuffer floor(double halfWidth, const AreaLight& light) {
    return test::planeGBuffer(kSize, kSize, {-halfWidth, -halfWidth, 0}, {2 * halfWidth, 0, 0},
                              {0, 2 * halfWidth, 0}, light);
}

Rect rectOf(const AreaLight& light) {
    return {{-light.halfU, -light.halfV}, {light.halfU, light.halfV}};
}

TEST(ClosedForm, KnownValues) {
    // METHODS.md R2.1's own examples, and agreement between the forms.
    const Rect occluder{{-0.4, -0.2}, {0.35, 0.6}}, light{{-1, -0.5}, {1, 0.5}};
    EXPECT_NEAR(closed_form::rectangle({0, 0}, occluder, 2, light, 5), 0.0625, 1e-12);
    EXPECT_NEAR(closed_form::rectangle({1.1, 0.2}, occluder, 2, light, 5), 0.8875, 1e-12);
    for (double x = -2.0; x < 2.0; x += 0.1) {
        const double half = closed_form::halfPlane(x, 0.2, 2, 2, 5);
        EXPECT_NEAR(half, closed_form::rectangle({x, 0}, {{0.2, -50}, {50, 50}}, 2, light, 5),
                    1e-12);
        EXPECT_NEAR(half,
                    closed_form::straightEdge({x, 0, 0}, {0.2, 0, 2}, {0.2, 1, 2}, {-9, 0, 2},
                                              test::lightAbove(5, 2, 1)),
                    1e-12);
    }
}

TEST(ClosedForm, RectangleOverRectangle) {  // R2.1
    const AreaLight light = test::lightAbove(5, 2, 1);
    const Rect occluder{{-0.4, -0.2}, {0.35, 0.6}};
    test::Shape casters;
    casters.rectangle(occluder.lo, occluder.hi, 2.0);
    certify(casters, floor(2.5, light), light, [&](const glm::dvec3& p) {
        return closed_form::rectangle(glm::dvec2(p), occluder, 2.0, rectOf(light), 5.0);
    });
}

TEST(ClosedForm, HalfPlane) {  // R2.2
    const AreaLight light = test::lightAbove(4, 1.5, 1.5);
    test::Shape casters;
    casters.rectangle({0.1, -60}, {60, 60}, 1.5);
    certify(casters, floor(1.0, light), light,
            [&](const glm::dvec3& p) { return closed_form::halfPlane(p.x, 0.1f, 1.5, 1.5, 4.0); });
}

TEST(ClosedForm, ObliqueEdgeOverATiltedReceiver) {  // R2.4
    const AreaLight light = test::lightAbove(4, 1.2, 0.8);
    const glm::dvec3 a(-40, -22, 1.1), b(40, 22, 2.9), far(30, -60, 2.0);
    test::Shape casters;
    casters.triangle(a, b, far);
    const GBuffer receiver = test::planeGBuffer(kSize, kSize, {-1.2, -1.0, -0.2}, {2.4, 0, 0.5},
                                                {0.1, 2.0, -0.3}, light);
    certify(casters, receiver, light, [&](const glm::dvec3& p) {
        return closed_form::straightEdge(p, glm::dvec3(glm::vec3(a)), glm::dvec3(glm::vec3(b)),
                                         {-30, 60, 2}, light);
    });
}

TEST(ClosedForm, CoplanarOccludersAddOrUnite) {  // R2.9
    const AreaLight light = test::lightAbove(5, 2, 2);
    const Rect a{{-0.7, -0.5}, {-0.1, 0.4}};
    for (const Rect& b : {Rect{{0.1, -0.3}, {0.6, 0.7}}, Rect{{-0.4, -0.2}, {0.6, 0.7}}}) {
        test::Shape casters;
        casters.rectangle(a.lo, a.hi, 2.0);
        casters.rectangle(b.lo, b.hi, 2.0);
        certify(casters, floor(2.5, light), light, [&](const glm::dvec3& p) {
            return closed_form::twoRectangles(glm::dvec2(p), a, b, 2.0, rectOf(light), 5.0);
        });
    }
}

TEST(ClosedForm, HoldsAtAnyScale) {  // R2.12
    for (const double scale : {1e-3, 1e3}) {
        AreaLight light = test::lightAbove(5 * scale, 2 * scale, 1 * scale);
        const Rect occluder{{-0.4 * scale, -0.2 * scale}, {0.35 * scale, 0.6 * scale}};
        test::Shape casters;
        casters.rectangle(occluder.lo, occluder.hi, 2.0 * scale);
        certify(casters, floor(2.5 * scale, light), light, [&](const glm::dvec3& p) {
            return closed_form::rectangle(glm::dvec2(p), occluder, 2.0 * scale, rectOf(light),
                                          5.0 * scale);
        });
    }
}

}  // namespace
}  // namespace penumbra
