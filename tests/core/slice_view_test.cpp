#include "core/frame/slice_view.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/frame/casters.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/test_scene.hpp"

namespace penumbra {
namespace {

using namespace test;

class SliceViewTest : public GlTest {};

/// A floor off to one side below the light and a slope beside it, so that no axis is symmetric.
TestFrame unevenFrame(double widthM, double lengthM) {
    const AreaLight light = lightAbove(3.0, widthM, lengthM);
    Shape shape;
    shape.rectangle({-1.0, -2.0}, {3.0, 1.0}, 0.0);
    shape.box({0.2, 0.1, 1.0}, {0.6, 0.4, 1.7});
    return {{shape.geometry(), light},
            stacked({planeGBuffer(24, 24, {-1, -2, 0}, {4, 0, 0}, {0, 3, 0}, light),
                     planeGBuffer(24, 24, {0.5, -1, 0.2}, {1, 0, 0.9}, {0, 2, 0}, light)})};
}

TEST_F(SliceViewTest, KernelsNeverLeaveTheTexture) {
    for (const bool orthographic : {false, true})
        for (const double cop : {0.0, 0.1, 1.0, 10.0})
            for (const glm::dvec2 size :
                 {glm::dvec2(0.5, 0.5), {2.0, 0.1}, {0.0, 0.4}, {6.0, 6.0}}) {
                const TestFrame frame = unevenFrame(size.x, size.y);
                const SliceView view =
                    SliceView::fit(*frame, {.orthographic = orthographic, .copFactor = cop});
                int asked = 0;
                for (const std::size_t i : frame.asked()) {
                    const glm::dvec3 p(frame->gbuffer.position[i]);
                    const glm::dvec3 l(p.x, -p.y, 3.0 - p.z);  // lightAbove's axes
                    for (const double planeM : view.planesM) {
                        if (planeM > l.z) break;
                        ++asked;
                        const glm::dvec2 middle =
                            glm::dvec2(l) * (planeM / l.z) * view.shrink(planeM) * view.scale +
                            view.offset;
                        const glm::dvec2 half = 0.5 * view.kernelUv(frame->light, l.z, planeM);
                        // G-buffer points are floats: 1e-7 of the coordinates.
                        EXPECT_GE(std::min((middle - half).x, (middle - half).y), -1e-6);
                        EXPECT_LE(std::max((middle + half).x, (middle + half).y), 1.0 + 1e-6);
                    }
                }
                EXPECT_GT(asked, 1000);
            }
}

TEST_F(SliceViewTest, SquareLightsFrustumGoesThroughItsRim) {
    // Eq. 4 in texture coordinates, METHODS.md 13: (z - zk) / z * d / (d + zk) on the wider axis.
    const AreaLight light = lightAbove(3.0, 0.5, 0.5);
    Shape shape;
    shape.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(65, 65, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, light));
    const SliceView view = SliceView::fit(*frame, {.mapSize = 1 << 20});
    const double outermost = 2.0 - 2.0 / 65.0;
    EXPECT_NEAR(view.copM, 0.25 * 3.0 / (outermost - 0.25), 1e-6);
    for (const double planeM : {0.5, 1.0, 2.0}) {
        const double expected = (3.0 - planeM) / 3.0 * view.copM / (view.copM + planeM);
        const glm::dvec2 uv = view.kernelUv(light, 3.0, planeM);
        // The margin of a texel each side.
        EXPECT_NEAR(uv.x, expected, 1e-5);
        EXPECT_NEAR(uv.y, expected, 1e-5);
    }
}

TEST_F(SliceViewTest, SlicesAscendFromTheNearestCasterToTheFarthestReceiver) {
    const TestFrame frame = unevenFrame(0.5, 0.5);
    for (const bool quantiles : {false, true})
        for (const bool snap : {false, true})
            for (const int slices : {1, 4, 16, 64}) {
                const SliceView view = SliceView::fit(
                    *frame, {.slices = slices, .quantiles = quantiles, .snap = snap});
                const auto count = static_cast<std::size_t>(slices);
                ASSERT_EQ(view.boundariesM.size(), count + 1);
                ASSERT_EQ(view.planesM.size(), count);
                EXPECT_NEAR(view.boundariesM[0], 1.3, 1e-6) << "the top of the box";
                EXPECT_NEAR(view.farM, 3.0, 1e-6);
                for (std::size_t k = 0; k < count; ++k) {
                    EXPECT_LT(view.boundariesM[k], view.boundariesM[k + 1]);
                    EXPECT_LE(view.planesM[k], view.boundariesM[k + 1]);
                    EXPECT_GE(view.planesM[k], view.boundariesM[k]);
                }
                EXPECT_LT(view.boundariesM[count], view.farM);
            }
}

TEST_F(SliceViewTest, QuantilesGoWhereCastersHaveReceiversBehindThem) {
    // The box's 0.7 metres of 1.7 get more than their share; the floor, far larger, gets none.
    const TestFrame frame = unevenFrame(0.5, 0.5);
    const auto inBox = [&](bool quantiles) {
        const SliceView view = SliceView::fit(*frame, {.quantiles = quantiles});
        return std::ranges::count_if(view.boundariesM, [](double z) { return z <= 2.0; });
    };
    EXPECT_GT(inBox(true), inBox(false) + 3);
}

TEST_F(SliceViewTest, CuttingTrianglesMovesNothing) {
    // The floor ends below the plate, so that a part of it only has a receiver far below.
    for (const bool orthographic : {false, true}) {
        std::vector<SliceView> views;
        for (const int cells : {1, 2, 7, 40}) {
            const AreaLight light = lightAbove(3.0, 0.5, 0.3);
            Shape shape;
            shape.rectangle({-1.0, -2.0}, {3.0, 1.0}, 0.0);
            shape.grid({-0.7, -0.8, 0.5}, {2.2, 0.1, 0.9}, {0.1, 1.3, 0.2}, cells);
            shape.grid({0.2, -1.0, 0.1}, {0.0, 1.6, 0.0}, {0.3, 0.0, 0.9}, cells);
            const TestFrame frame({shape.geometry(), light},
                                  planeGBuffer(24, 24, {-1, -2, 0}, {1.8, 0, 0}, {0, 3, 0}, light));
            views.push_back(
                SliceView::fit(*frame, {.orthographic = orthographic, .quantiles = true}));
        }
        // Corners of the parts are floats.
        for (const SliceView& view : views)
            for (std::size_t k = 0; k < view.planesM.size(); ++k) {
                EXPECT_NEAR(view.boundariesM[k], views[0].boundariesM[k], 2e-6) << k;
                EXPECT_NEAR(view.planesM[k], views[0].planesM[k], 2e-6) << k;
            }
    }
}

TEST_F(SliceViewTest, PlanesLieAtTheDeepestCaster) {
    const AreaLight light = lightAbove(3.0, 0.5, 0.5);
    Shape shape;
    shape.rectangle({-0.5, -0.5}, {0.5, 0.5}, 1.37);
    shape.rectangle({-0.5, -0.5}, {0.5, 0.5}, 0.71);
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(16, 16, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, light));
    const SliceView view = SliceView::fit(*frame, {});
    for (const double depthM : {3.0 - 1.37, 3.0 - 0.71})
        EXPECT_EQ(std::ranges::count_if(view.planesM,
                                        [&](double z) { return std::abs(z - depthM) < 1e-6; }),
                  1);
}

/// A light tilted by `tiltDeg` over a floor and two plates above it.
TestFrame tiltedFrame(double tiltDeg) {
    const double tilt = glm::radians(tiltDeg);
    AreaLight light = lightAbove(4.0, 0.6, 0.6);
    const glm::dvec3 towards(std::sin(tilt), 0.0, -std::cos(tilt));
    light.centre = -4.0 * towards;
    light.axisV = glm::dvec3(0.0, -1.0, 0.0);
    light.axisU = glm::cross(light.axisV, towards);
    Shape shape;
    shape.rectangle({-4.0, -4.0}, {4.0, 4.0}, 0.0);
    shape.rectangle({-0.6, -0.6}, {0.6, 0.6}, 1.0);
    shape.rectangle({-0.5, -0.5}, {0.5, 0.5}, 2.0);
    return {{shape.geometry(), light},
            planeGBuffer(64, 64, {-1.5, -1.5, 0}, {4, 0, 0}, {0, 3, 0}, light)};
}

TEST_F(SliceViewTest, NoSliceHoldsCastersOnBothSidesOfAGap) {
    for (const double tiltDeg : {0.0, 10.0, 20.0}) {
        const SliceView view = SliceView::fit(*tiltedFrame(tiltDeg), {.quantiles = true});
        // Depths of the plates' corners.
        const double tilt = glm::radians(tiltDeg);
        const auto depthM = [&](double x, double z) {
            return 4.0 + std::sin(tilt) * x - std::cos(tilt) * z;
        };
        const double upper = depthM(0.5, 2.0), lower = depthM(-0.6, 1.0);
        ASSERT_LT(upper, lower);
        // Some slice's content ends with the upper plate.
        EXPECT_EQ(std::ranges::count_if(view.planesM,
                                        [&](double z) { return std::abs(z - upper) < 1e-5; }),
                  1)
            << tiltDeg;
    }
}

TEST_F(SliceViewTest, FloorsThatSlantTakeNoMoreThanTheDepthsShareOfSlices) {
    const SliceView view = SliceView::fit(*tiltedFrame(20.0), {.quantiles = true});
    // The plates end at 3.3 metres, the floor's visible points reach from 3.5 to 4.9: a quarter of
    // what counts is depth, of which that is three fifths.
    EXPECT_LE(std::ranges::count_if(view.planesM, [](double z) { return z > 3.4; }), 4);
}

TEST_F(SliceViewTest, ReceiversBesideTheLightAreRefused) {
    const AreaLight light = lightAbove(3.0, 0.5, 0.5);
    Shape shape;
    shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    // Seventy degrees from the rim at x = 0.25: 0.1 tan 70 = 0.2747 metres beyond it.
    const auto reaching = [&](double x) {
        return TestFrame({shape.geometry(), light},
                         planeGBuffer(1, 1, {x - 0.5, -0.5, 2.9}, {1, 0, 0}, {0, 1, 0}, light));
    };
    EXPECT_NO_THROW(SliceView::fit(*reaching(0.52), {}));
    EXPECT_THROW(SliceView::fit(*reaching(0.53), {}), Unsupported);
}

TEST(CastersTest, BoxesHaveAThicknessAndSheetsHaveNone) {
    Shape shape;
    shape.rectangle({0.0, 0.0}, {1.0, 1.0}, 5.0);
    shape.box({10.0, 0.0, 0.0}, {12.0, 2.0, 0.1});
    const auto geometry = shape.geometry();
    const Casters casters = Casters::find(*geometry);
    ASSERT_EQ(casters.thicknessM.size(), 2u);
    EXPECT_EQ(casters.thicknessM[casters.ofVertex.front()], 0.0);
    // 2 V / A of a plate of 2 x 2 x 0.1; its corners are floats.
    EXPECT_NEAR(casters.thicknessM[casters.ofVertex.back()], 0.8 / 8.8, 1e-6);
}

}  // namespace
}  // namespace penumbra
