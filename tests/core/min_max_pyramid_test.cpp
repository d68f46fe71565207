#include "core/passes/min_max_pyramid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <glm/gtc/packing.hpp>

#include "tests/support/gl_fixture.hpp"
#include "tests/support/test_scene.hpp"

namespace penumbra {
namespace {

using namespace test;

class MinMaxPyramidTest : public GlTest {};

/// A pyramid and its map, read back.
class Bounded {
  public:
    struct Window {
        float maxS, minS, planeS;
        glm::dvec2 slope;  ///< per texel
    };

    Bounded(const Shape& shape, const LightView& view, int mapSize) : mapSize_(mapSize) {
        const AreaLight light = lightAbove(0.0, 0.0, 0.0);
        const TestFrame frame({shape.geometry(), light},
                              planeGBuffer(1, 1, {0, 0, -1}, {0.1, 0, 0}, {0, 0.1, 0}, light));
        DepthPass depth(Plan{});
        depth.render(*frame, view, mapSize);
        map_.resize(static_cast<std::size_t>(depth.texels()));
        glGetTextureImage(depth.map().id(), 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                          static_cast<GLsizei>(map_.size() * sizeof(float)), map_.data());
        MinMaxPyramid pyramid = MinMaxPyramid::create();
        pyramid.build(depth);
        levels = pyramid.levels();
        blocks = pyramid.texture().width();
        blockTexels = pyramid.blockTexels();
        texels_.resize(static_cast<std::size_t>(blocks) * blocks * pyramid.texture().layers());
        glGetTextureImage(pyramid.texture().id(), 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                          static_cast<GLsizei>(texels_.size() * sizeof(glm::uvec4)),
                          texels_.data());
    }

    int levels = 0, blocks = 0, blockTexels = 0;

    float s(int tile, int x, int y) const {
        return map_[static_cast<std::size_t>((tile * mapSize_ + y) * mapSize_ + x)];
    }
    Window window(int tile, int level, int x, int y) const {
        const glm::uvec4 t =
            texels_[static_cast<std::size_t>(((tile * levels + level) * blocks + y) * blocks + x)];
        constexpr double kGradientScale = 4096.0;  // shaders/common/min_max_pyramid.glsl
        return {std::bit_cast<float>(t.r), std::bit_cast<float>(t.g), std::bit_cast<float>(t.a),
                glm::dvec2(glm::unpackHalf2x16(t.b)) / kGradientScale};
    }

    /// Calls `check(window, texels, above)` for every window inside the map: `texels` are its
    /// least and greatest s, `above` the least and greatest distance of its plane above a texel.
    template <class Check>
    void forEach(int tile, const Check& check) const {
        for (int level = 0; level < levels; ++level)
            for (int y = 0; y + (1 << level) <= blocks; ++y)
                for (int x = 0; x + (1 << level) <= blocks; ++x) {
                    const Window w = window(tile, level, x, y);
                    const int size = blockTexels << level;
                    const glm::ivec2 first = blockTexels * glm::ivec2(x, y);
                    glm::dvec2 texels(1e9, -1e9), above(1e9, -1e9);
                    for (int j = first.y; j < std::min(first.y + size, mapSize_); ++j)
                        for (int i = first.x; i < std::min(first.x + size, mapSize_); ++i) {
                            const double value = s(tile, i, j);
                            const glm::dvec2 away =
                                glm::dvec2(i, j) + 0.5 - glm::dvec2(first) - 0.5 * size;
                            const double distance = w.planeS + glm::dot(w.slope, away) - value;
                            texels = {std::min(texels.x, value), std::max(texels.y, value)};
                            above = {std::min(above.x, distance), std::max(above.y, distance)};
                        }
                    check(w, texels, above);
                }
    }

  private:
    int mapSize_;
    std::vector<float> map_;
    std::vector<glm::uvec4> texels_;
};

/// From the origin along -z, right angles wide.
LightView downwards(double nearM) {
    LightView view;
    view.tiles = {{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {-1, -1}, {1, 1}, nearM}};
    return view;
}

Shape clutter() {
    Shape shape;
    shape.rectangle({-3.0, -3.0}, {3.0, 2.0}, -2.5);
    for (int i = 0; i < 9; ++i)
        shape.sphere({0.3 * i - 1.1, std::sin(2.0 * i), -1.2 - 0.12 * i}, 0.25, 8);
    shape.quad({-3, 1, -2.5}, {3, 1, -2.5}, {3, 2, -1.2}, {-3, 2, -1.2});
    return shape;
}

// Planes are summed up in floats over a few levels, values being at most 1.
constexpr double kRounding = 2e-6;

TEST_F(MinMaxPyramidTest, WindowsBoundTheirTexels) {
    // Sizes that are no multiple of a block, no power of two of blocks, and smaller than a block.
    for (const int mapSize : {64, 77, 100, 128, 16, 7}) {
        const Bounded bounded(clutter(), downwards(0.7), mapSize);
        int wrong = 0, windows = 0;
        bounded.forEach(0, [&](const Bounded::Window& w, glm::dvec2 texels, glm::dvec2 above) {
            wrong += w.minS != static_cast<float>(texels.x) ||
                     w.maxS != static_cast<float>(texels.y) || above.x < -kRounding;
            ++windows;
        });
        EXPECT_EQ(wrong, 0) << mapSize;
        EXPECT_GE(windows, bounded.blocks * bounded.blocks) << mapSize;
    }
}

TEST_F(MinMaxPyramidTest, OnePlaneIsBoundedByItself) {
    // s is affine over it, and the depth pass is off by the 1/256 of a texel to which rasterizers
    // round vertices; slopes are kept to 11 bits, so that over n texels a plane of slope g per
    // texel may stand n g / 2^11 too high. A box would stand up to n g above it.
    constexpr int kMapSize = 128;
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3, -0.5, 1.0));
    const glm::dvec3 u = 40.0 * glm::normalize(glm::cross(normal, glm::dvec3(0, 1, 0)));
    const glm::dvec3 v = glm::cross(normal, u), middle(0, 0, -2);
    Shape shape;
    shape.quad(middle - u - v, middle + u - v, middle + u + v, middle - u + v);
    const Bounded bounded(shape, downwards(0.7), kMapSize);
    const double rise = bounded.s(0, 1, 0) - bounded.s(0, 0, 0),
                 across = bounded.s(0, 0, 1) - bounded.s(0, 0, 0);
    const double slope = std::abs(rise) + std::abs(across);
    ASSERT_GT(slope, 1e-3);
    double highest = 0.0;
    bounded.forEach(0, [&](const Bounded::Window&, glm::dvec2, glm::dvec2 above) {
        highest = std::max(highest, above.y);
    });
    EXPECT_LE(highest, slope * (kMapSize / 2048.0 + 1.0 / 256) + 1e-4);
}

TEST_F(MinMaxPyramidTest, EveryTileHasItsLevels) {
    Shape shape;
    shape.rectangle({-9, -9}, {9, 9}, -2.0);
    shape.rectangle({-9, -9}, {9, 9}, 2.0);
    LightView both = downwards(0.5);
    both.tiles.push_back({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, -1}, {1, 1}, 1.0});
    const Bounded bounded(shape, both, 64);
    for (const int tile : {0, 1})
        bounded.forEach(tile, [&](const Bounded::Window& w, glm::dvec2, glm::dvec2) {
            EXPECT_FLOAT_EQ(w.maxS, tile == 0 ? 0.25f : 0.5f);
            EXPECT_FLOAT_EQ(w.minS, tile == 0 ? 0.25f : 0.5f);
        });
}

TEST_F(MinMaxPyramidTest, GreatMapsHaveGreaterBlocks) {
    Shape shape;
    shape.rectangle({-9, -9}, {9, 9}, -2.0);
    const Bounded bounded(shape, downwards(0.5), 4096);
    EXPECT_EQ(bounded.blockTexels, 16);
    EXPECT_EQ(bounded.blocks, 256);
    EXPECT_EQ(bounded.levels, 9);
}

}  // namespace
}  // namespace penumbra
