#include "core/frame/light_view.hpp"

#include <gtest/gtest.h>

#include "tests/support/gl_fixture.hpp"
#include "tests/support/test_scene.hpp"

namespace penumbra {
namespace {

using namespace test;

class LightViewTest : public GlTest {};

/// Receivers on the floor of a room and, where `walls`, on its wall up to just below the light,
/// which stands askew in the room.
TestFrame room(bool walls) {
    AreaLight light = lightAbove(2.5, 0.4, 0.2);
    light.centre.x = 0.3;
    light.axisU = glm::normalize(glm::dvec3(3, 1, 0));
    light.axisV = glm::normalize(glm::dvec3(1, -3, 0));
    Shape shape;
    shape.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    shape.quad({2, -2, 0}, {2, 2, 0}, {2, 2, 3}, {2, -2, 3});
    std::vector<GBuffer> seen = {planeGBuffer(32, 32, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, light)};
    if (walls) seen.push_back(planeGBuffer(32, 32, {2, -2, 0}, {0, 0, 2.45}, {0, 4, 0}, light));
    return {{shape.geometry(), light}, stacked(seen)};
}

/// The tile that answers for a point, and the point in its frame: shaders/common/light_view.glsl.
struct InTile {
    std::size_t tile = 0;
    glm::dvec3 local{0.0};
    glm::dvec2 tangent() const { return glm::dvec2(local) / local.z; }
};

InTile inTile(const LightView& view, const glm::dvec3& point) {
    const auto in = [&](std::size_t tile) {
        const LightTile& t = view.tiles[tile];
        const glm::dvec3 p = point - view.centre;
        return InTile{tile, {glm::dot(t.axisX, p), glm::dot(t.axisY, p), glm::dot(t.axisZ, p)}};
    };
    const InTile front = in(0);
    const double x = front.local.x, y = front.local.y;
    if (view.tiles.size() == 1 || std::max(std::abs(x), std::abs(y)) <= front.local.z) return front;
    if (std::abs(x) >= std::abs(y)) return in(x > 0 ? 1 : 2);
    return in(y > 0 ? 3 : 4);
}

TEST_F(LightViewTest, SidesAreRightHandedAndLookWhereTheySay) {
    const AreaLight light = room(false)->light;
    const glm::dvec3 towards[] = {light.normal(), light.axisU, -light.axisU, light.axisV,
                                  -light.axisV};
    for (std::size_t side = 0; side < 5; ++side) {
        const auto [x, y, z] = lightSideAxes(light, side);
        EXPECT_LT(glm::length(glm::cross(x, y) - z), 1e-12) << side;
        EXPECT_LT(glm::length(z - towards[side]), 1e-12) << side;
    }
    EXPECT_EQ(lightSideAxes(light, 0)[0], light.axisU);
}

TEST_F(LightViewTest, OnlyReceiversBesideTheLightNeedFiveTiles) {
    EXPECT_EQ(LightView::fit(*room(false), glm::dvec2(0.0), 1024).tiles.size(), 1u);
    EXPECT_EQ(LightView::fit(*room(true), glm::dvec2(0.0), 1024).tiles.size(), 5u);
}

TEST_F(LightViewTest, EveryReceiverIsInsideItsTileAndGuard) {
    for (const bool walls : {false, true})
        for (const glm::dvec2 guardM : {glm::dvec2(0.0), glm::dvec2(0.3, 0.05)})
            for (const int mapSize : {16, 1024}) {
                const TestFrame frame = room(walls);
                const LightView view = LightView::fit(*frame, guardM, mapSize);
                // Side tiles see both of the light's axes edge-on: the wider guard serves for both.
                const glm::dvec2 reachM =
                    view.tiles.size() == 1 ? guardM : glm::dvec2(std::max(guardM.x, guardM.y));
                int outside = 0;
                for (const std::size_t i : frame.asked()) {
                    const InTile p = inTile(view, glm::dvec3(frame->gbuffer.position[i]));
                    const LightTile& tile = view.tiles[p.tile];
                    // One texel more, but for rounding.
                    const glm::dvec2 margin =
                        reachM / p.local.z + (1.0 - 1e-9) * tile.tangentSize() / double(mapSize);
                    const glm::dvec2 t = p.tangent();
                    outside += !(glm::all(glm::lessThanEqual(tile.tangentLo, t - margin)) &&
                                 glm::all(glm::lessThanEqual(t + margin, tile.tangentHi)));
                }
                EXPECT_EQ(outside, 0) << view.tiles.size() << " tiles, map of " << mapSize;
            }
}

TEST_F(LightViewTest, ClipSpaceIsTheShadersTextureSpace) {
    const LightView view = LightView::fit(*room(true), glm::dvec2(0.1), 1024);
    for (std::size_t i = 0; i < view.tiles.size(); ++i) {
        const LightTile& tile = view.tiles[i];
        const glm::dmat4 clipFromWorld(view.clipFromWorld(i));
        for (const double zM : {0.5 * tile.nearM, tile.nearM, 1.7, 20.0})
            for (const glm::dvec2 uv : {glm::dvec2(0.0), glm::dvec2(0.2, 0.9), glm::dvec2(1.0)}) {
                const glm::dvec2 t = tile.tangentLo + uv * tile.tangentSize();
                const glm::dvec3 point =
                    view.centre + zM * (t.x * tile.axisX + t.y * tile.axisY + tile.axisZ);
                const glm::dvec4 clip = clipFromWorld * glm::dvec4(point, 1.0);
                // The matrix is rounded to floats of a few metres.
                EXPECT_NEAR(clip.w, zM, 1e-6 * std::max(1.0, zM));
                EXPECT_NEAR(clip.z / clip.w * zM / tile.nearM, 1.0, 1e-5);
                EXPECT_NEAR(0.5 * clip.x / clip.w + 0.5, uv.x, 2e-6) << "tile " << i;
                EXPECT_NEAR(0.5 * clip.y / clip.w + 0.5, uv.y, 2e-6) << "tile " << i;
            }
    }
}

TEST_F(LightViewTest, NoReceiverIsNearerThanTheNearPlane) {
    // The wall crosses the light's plane: its vertices in front are farther than its upper
    // receivers.
    for (const bool walls : {false, true}) {
        const TestFrame frame = room(walls);
        const LightView view = LightView::fit(*frame, glm::dvec2(0.0), 1024);
        for (const std::size_t i : frame.asked()) {
            const InTile p = inTile(view, glm::dvec3(frame->gbuffer.position[i]));
            ASSERT_LT(view.tiles[p.tile].nearM, p.local.z);
        }
    }
}

TEST_F(LightViewTest, OneReceiverOrNoneStillGivesAFrustum) {
    const AreaLight light = lightAbove(2.0, 0.4, 0.4);
    Shape shape;
    shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    for (const double heightM : {0.0, 3.0}) {  // below the light, and behind it
        const TestFrame frame({shape.geometry(), light},
                              planeGBuffer(1, 1, {0, 0, heightM}, {0.1, 0, 0}, {0, 0.1, 0}, light));
        const LightView view = LightView::fit(*frame, glm::dvec2(0.0), 256);
        ASSERT_EQ(view.tiles.size(), 1u);
        EXPECT_GT(std::min(view.tiles[0].tangentSize().x, view.tiles[0].tangentSize().y), 0.0);
        const glm::vec4 clip = view.clipFromWorld(0) * glm::vec4(0.05f, 0.05f, 0.0f, 1.0f);
        EXPECT_LT(std::abs(clip.x), clip.w);
        EXPECT_LT(std::abs(clip.y), clip.w);
    }
}

}  // namespace
}  // namespace penumbra
