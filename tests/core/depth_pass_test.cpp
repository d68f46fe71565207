#include "core/passes/depth_pass.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/gl/work_counter.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/test_scene.hpp"

namespace penumbra {
namespace {

using namespace test;

class DepthPassTest : public GlTest {};

constexpr int kMapSize = 64;

std::vector<float> read(const DepthPass& pass) {
    std::vector<float> texels(static_cast<std::size_t>(pass.texels()));
    glGetTextureImage(pass.map().id(), 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                      static_cast<GLsizei>(texels.size() * sizeof(float)), texels.data());
    return texels;
}

/// Geometry alone: the view is the test's own, no receiver is asked for.
TestFrame casters(const Shape& shape) {
    const AreaLight light = lightAbove(0.0, 0.0, 0.0);
    return {{shape.geometry(), light},
            planeGBuffer(1, 1, {0, 0, -1}, {0.1, 0, 0}, {0, 0.1, 0}, light)};
}

/// From the origin along -z, right angles wide.
LightView downwards(double nearM) {
    LightView view;
    view.tiles = {{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {-1, -1}, {1, 1}, nearM}};
    return view;
}

std::vector<float> rendered(const Shape& shape, const LightView& view) {
    const TestFrame frame = casters(shape);
    DepthPass pass(Plan{});
    pass.render(*frame, view, kMapSize);
    return read(pass);
}

TEST_F(DepthPassTest, TexelsHoldNearOverDepthAtTheirCentres) {
    // A plane through (0, 0, -2), tilted; s is affine over it, so interpolation is exact but for
    // rounding and the 1/256 of a texel to which rasterizers round vertices.
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3, -0.5, 1.0));
    const glm::dvec3 u = 40.0 * glm::normalize(glm::cross(normal, glm::dvec3(0, 1, 0)));
    const glm::dvec3 v = glm::cross(normal, u), middle(0, 0, -2);
    Shape shape;
    shape.quad(middle - u - v, middle + u - v, middle + u + v, middle - u + v);
    constexpr double kNearM = 0.7;
    const LightView view = downwards(kNearM);
    const std::vector<float> map = rendered(shape, view);
    for (int j = 0; j < kMapSize; ++j)
        for (int i = 0; i < kMapSize; ++i) {
            const LightTile& tile = view.tiles[0];
            const glm::dvec2 t = tile.tangentLo + (glm::dvec2(i, j) + 0.5) / double(kMapSize) * 2.0;
            const glm::dvec3 direction = t.x * tile.axisX + t.y * tile.axisY + tile.axisZ;
            const double zM = glm::dot(normal, middle) / glm::dot(normal, direction);
            ASSERT_NEAR(map[static_cast<std::size_t>(j * kMapSize + i)], kNearM / zM, 1e-4)
                << i << ", " << j;
        }
}

TEST_F(DepthPassTest, NearestWinsWhicheverWayItFaces) {
    for (const bool flipped : {false, true}) {
        Shape shape;
        const double z[] = {-4.0, -1.0, -2.0};
        for (const double depth : z) {
            if (flipped)
                shape.quad({-9, -9, depth}, {-9, 9, depth}, {9, 9, depth}, {9, -9, depth});
            else
                shape.rectangle({-9, -9}, {9, 9}, depth);
        }
        for (const float s : rendered(shape, downwards(0.5))) ASSERT_NEAR(s, 0.5, 1e-6);
    }
}

TEST_F(DepthPassTest, CastersNearerThanTheNearPlaneAreKept) {
    Shape shape;
    shape.rectangle({-9, -9}, {9, 9}, -0.01);
    for (const float s : rendered(shape, downwards(1.5))) ASSERT_EQ(s, 1.0f);
}

TEST_F(DepthPassTest, NothingBehindTheLightIsDrawn) {
    Shape shape;
    shape.rectangle({-9, -9}, {9, 9}, 1.0);
    for (const float s : rendered(shape, downwards(0.5))) ASSERT_EQ(s, 0.0f);
}

TEST_F(DepthPassTest, TrianglesThroughTheLightsPlaneAreCutThere) {
    // A wall at x = 1 from far below to far above the light: t.x = 1 / z, the half t.x > 0 of the
    // view sees it in depth 1 / t.x, even near the light's plane.
    Shape shape;
    shape.quad({1, -50, -50}, {1, 50, -50}, {1, 50, 50}, {1, -50, 50});
    LightView view = downwards(0.05);
    view.tiles[0].tangentLo.x = -10.0;
    view.tiles[0].tangentHi.x = 10.0;
    const std::vector<float> map = rendered(shape, view);
    for (int j = 0; j < kMapSize; ++j)
        for (int i = 0; i < kMapSize; ++i) {
            const double tx = (2.0 * (i + 0.5) / kMapSize - 1.0) * 10.0;
            ASSERT_NEAR(map[static_cast<std::size_t>(j * kMapSize + i)], tx > 0.0 ? 0.05 * tx : 0.0,
                        1e-4)
                << i << ", " << j;
        }
}

TEST_F(DepthPassTest, ClosedBodiesAreDrawnWithoutTheSidesTurnedAway) {
    const AreaLight light = lightAbove(0.0, 0.0, 0.0);
    LightView view;
    for (std::size_t side = 0; side < 5; ++side) {
        const auto [x, y, z] = lightSideAxes(light, side);
        view.tiles.push_back({x, y, z});
    }
    const auto draw = [&](const TestFrame& frame, bool everyPixel) {
        Plan plan;
        plan.everyPixel = everyPixel;
        DepthPass pass(plan);
        gl::WorkCounter counter;
        pass.render(*frame, view, kMapSize);
        const std::uint64_t fragments = counter.stop().fragments;
        return std::pair(read(pass), fragments);
    };
    for (const bool insideOut : {false, true}) {
        std::uint64_t fewer = 0, all = 0;
        for (const LightTile& tile : view.tiles) {
            Shape box;
            box.box(2.0 * tile.axisZ - 0.5, 2.0 * tile.axisZ + 0.5);
            Geometry geometry = *box.geometry();
            if (insideOut) std::ranges::reverse(geometry.indices);
            const TestFrame frame({std::make_shared<const Geometry>(geometry), light},
                                  planeGBuffer(1, 1, {0, 0, -3}, {0.1, 0, 0}, {0, 0.1, 0}, light));
            ASSERT_EQ(frame->casterFacts.parts[0].outward, insideOut ? -1 : 1);
            const auto [some, someFragments] = draw(frame, false);
            const auto [whole, wholeFragments] = draw(frame, true);
            EXPECT_EQ(some, whole);
            fewer += someFragments;
            all += wholeFragments;
        }
        // Sides that are drawn later than those before them are hidden already.
        EXPECT_LT(fewer, all);
    }
    Shape around;
    around.box({-1, -1, -1}, {1, 1, 1});
    const TestFrame frame = casters(around);
    EXPECT_EQ(draw(frame, false), draw(frame, true)) << "the light is inside";
}

// Faces of less than a texel that are seen edge-on: rasterisation moves their corners by as much as
// they are wide.
TEST_F(DepthPassTest, AvertedSidesOfFineBodiesAreNowhereTheNearest) {
    Shape bodies;
    for (int i = 1; i < 40; ++i) {
        const glm::dvec2 at(0.9 * std::sin(2.4 * i) * i / 40.0, 0.9 * std::cos(2.4 * i) * i / 40.0);
        bodies.sphere({at, -1.2 - 0.01 * i}, 0.04 + 0.002 * i, 24);
    }
    const TestFrame frame = casters(bodies);
    ASSERT_NE(frame->casterFacts.parts[0].outward, 0);
    const auto map = [&](bool everyPixel, int size) {
        Plan plan;
        plan.everyPixel = everyPixel;
        DepthPass pass(plan);
        pass.render(*frame, downwards(0.5), size);
        return read(pass);
    };
    for (const int size : {100, 256, 1000}) EXPECT_EQ(map(false, size), map(true, size)) << size;
}

TEST_F(DepthPassTest, EveryTileHasItsLayerAndMapsFollowTheirSize) {
    Shape shape;
    shape.rectangle({-9, -9}, {9, 9}, -2.0);
    shape.rectangle({-9, -9}, {9, 9}, 2.0);
    const TestFrame frame = casters(shape);
    LightView both = downwards(0.5);
    both.tiles.push_back({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, -1}, {1, 1}, 1.0});
    DepthPass pass(Plan{});
    pass.render(*frame, both, kMapSize);
    EXPECT_EQ(pass.texels(), 2.0 * kMapSize * kMapSize);
    const std::vector<float> map = read(pass);
    EXPECT_FLOAT_EQ(map.front(), 0.25f);
    EXPECT_FLOAT_EQ(map.back(), 0.5f);
    pass.render(*frame, downwards(1.0), 32);
    EXPECT_EQ(pass.texels(), 32.0 * 32.0);
    EXPECT_FLOAT_EQ(read(pass).front(), 0.5f);
}

}  // namespace
}  // namespace penumbra
