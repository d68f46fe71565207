#include "core/frame/translated_views.hpp"

#include <gtest/gtest.h>

#include "tests/support/gl_fixture.hpp"
#include "tests/support/test_scene.hpp"

namespace penumbra {
namespace {

using namespace test;

class TranslatedViewsTest : public GlTest {};

constexpr int kMapSize = 256;

/// Receivers near and far, to one side and to the other.
TestFrame steps(const AreaLight& light) {
    Shape shape;
    shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    return {{shape.geometry(), light},
            stacked({planeGBuffer(8, 8, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, light),
                     planeGBuffer(8, 8, {0.6, -0.3, 1.4}, {0.3, 0, 0}, {0, 0.2, 0}, light)})};
}

template <class Visit>
void forEveryOffset(const AreaLight& light, const Visit& visit) {
    for (const double s : {-1.0, -0.7, -0.2, 0.0, 0.3, 1.0})
        for (const double t : {-1.0, -0.4, 0.0, 0.9, 1.0})
            visit(glm::dvec2(s * light.halfU, t * light.halfV));
}

glm::dvec3 inTile(const LightTile& tile, const glm::dvec3& p) {
    return {glm::dot(tile.axisX, p), glm::dot(tile.axisY, p), glm::dot(tile.axisZ, p)};
}

TEST_F(TranslatedViewsTest, HoldEveryReceiverWithATexelToSpare) {
    const AreaLight light = lightAbove(2.0, 0.8, 0.4);
    const TestFrame frame = steps(light);
    const TranslatedViews views(*frame, kMapSize);
    forEveryOffset(light, [&](glm::dvec2 offset) {
        const LightView view = views.from(offset);
        ASSERT_EQ(view.tiles.size(), 1u);
        const LightTile& tile = view.tiles[0];
        for (const std::size_t i : frame.asked()) {
            const glm::dvec3 l = inTile(tile, glm::dvec3(frame->gbuffer.position[i]) - view.centre);
            const glm::dvec2 texel = (glm::dvec2(l) / l.z - tile.tangentLo) / tile.tangentSize() *
                                     static_cast<double>(kMapSize);
            // Rounding apart, the outermost receivers lie one texel inside.
            constexpr double kLeast = 1.0 - 1e-9;
            ASSERT_GE(std::min(texel.x, texel.y), kLeast) << offset.x << ", " << offset.y;
            ASSERT_LE(std::max(texel.x, texel.y), kMapSize - kLeast);
        }
    });
}

TEST_F(TranslatedViewsTest, ShareShapeAndDepth) {
    const AreaLight light = lightAbove(2.0, 0.8, 0.4);
    const TestFrame frame = steps(light);
    const TranslatedViews views(*frame, kMapSize);
    const LightTile centre = views.from(glm::dvec2(0.0)).tiles[0];
    const glm::dvec3 point(0.2, -0.3, 0.7);
    forEveryOffset(light, [&](glm::dvec2 offset) {
        const LightView view = views.from(offset);
        const LightTile& tile = view.tiles[0];
        EXPECT_EQ(tile.nearM, centre.nearM);
        EXPECT_NEAR(tile.tangentSize().x, centre.tangentSize().x, 1e-12);
        EXPECT_NEAR(tile.tangentSize().y, centre.tangentSize().y, 1e-12);
        EXPECT_DOUBLE_EQ(inTile(tile, point - view.centre).z, 1.3);
        EXPECT_NEAR(glm::distance(view.centre, light.centre), glm::length(offset), 1e-12);
    });
}

TEST_F(TranslatedViewsTest, ShiftedFrustaAreNarrowerThanOneForAll) {
    // One frustum for all points of the light would need the light's whole width at the nearest
    // receiver on top; shifted ones need half of it at most, less what they need at the farthest.
    const AreaLight light = lightAbove(2.0, 0.8, 0.8);
    const TestFrame frame = steps(light);
    const SideBounds& whole = frame->lightBounds.whole;
    const double width =
        TranslatedViews(*frame, 1 << 20).from(glm::dvec2(0.0)).tiles[0].tangentSize().x;
    const double margin = light.halfU * (1.0 / whole.receiverNearM - 1.0 / whole.receiverFarM);
    const double centres = whole.tangentHi.x - whole.tangentLo.x;
    EXPECT_LE(width, (centres + margin) * 1.001);
    EXPECT_LT(width, centres + light.halfU / whole.receiverNearM);
}

TEST_F(TranslatedViewsTest, CentreAloneIsTheFittedLightView) {
    const TestFrame frame = steps(lightAbove(2.0, 0.8, 0.4));
    const LightTile fitted = LightView::fit(*frame, glm::dvec2(0.0), kMapSize).tiles[0];
    const LightTile tile = TranslatedViews(*frame, kMapSize, false).from(glm::dvec2(0.0)).tiles[0];
    EXPECT_EQ(tile.tangentLo, fitted.tangentLo);
    EXPECT_EQ(tile.tangentHi, fitted.tangentHi);
    EXPECT_EQ(tile.nearM, fitted.nearM);
}

TEST_F(TranslatedViewsTest, WideViewsAreHalfCubes) {
    // Floor far to the sides: 76 degrees off the normal. Each tile is all that its own direction
    // dominates in front of the light's plane.
    const AreaLight light = lightAbove(1.0, 0.4, 0.4);
    Shape shape;
    shape.rectangle({-4.0, -4.0}, {4.0, 4.0}, 0.0);
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(16, 16, {-4, -4, 0}, {8, 0, 0}, {0, 8, 0}, light));
    const LightView view = TranslatedViews(*frame, kMapSize).from({0.2, -0.1});
    ASSERT_EQ(view.tiles.size(), 5u);
    constexpr double kTexel = 2.5 / kMapSize;  // the margin
    for (const LightTile& tile : view.tiles)
        for (int axis = 0; axis < 2; ++axis) {
            const glm::dvec3 direction = axis == 0 ? tile.axisX : tile.axisY;
            const bool down = glm::dot(direction, light.normal()) > 0.5;
            EXPECT_NEAR(tile.tangentLo[axis], down ? 0.0 : -1.0, kTexel);
            EXPECT_NEAR(tile.tangentHi[axis], 1.0, kTexel);
        }
}

}  // namespace
}  // namespace penumbra
