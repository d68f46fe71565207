#include "core/passes/pixel_classes.hpp"

#include <gtest/gtest.h>

#include "tests/methods/test_worlds.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/render.hpp"

namespace penumbra {
namespace {

using namespace test;

class PixelClassesTest : public GlTest {};

enum class Class { lit, dark, undecided };

/// Tiles of a frame, read back.
struct Classes {
    int tilePixels = 0, across = 0;
    std::vector<glm::vec4> tiles;

    Classes(const TestFrame& frame, PixelClasses::Dark dark,
            const PixelClasses::Kernel& kernel = {}, int mapSize = 1024) {
        DepthPass depth(Plan{});
        const glm::dvec2 guardM(2.0 * frame->light.halfU, 2.0 * frame->light.halfV);
        depth.render(*frame, LightView::fit(*frame, guardM, mapSize), mapSize);
        MinMaxPyramid pyramid = MinMaxPyramid::create();
        pyramid.build(depth);
        PixelClasses classes = PixelClasses::create(dark);
        classes.classify(*frame, depth, pyramid, 0.5f, kernel);
        across = classes.tiles().width();
        tilePixels = (frame->width() + across - 1) / across;
        tiles.resize(static_cast<std::size_t>(across) * classes.tiles().height());
        glGetTextureImage(classes.tiles().id(), 0, GL_RGBA, GL_FLOAT,
                          static_cast<GLsizei>(tiles.size() * sizeof(glm::vec4)), tiles.data());
    }

    Class of(const TestFrame& frame, std::size_t pixel) const {
        const int x = static_cast<int>(pixel) % frame->width() / tilePixels;
        const int y = static_cast<int>(pixel) / frame->width() / tilePixels;
        const glm::vec4& tile = tiles[static_cast<std::size_t>(y * across + x)];
        if (tile.x <= tile.z) return Class::undecided;
        return tile.z == 1.0f ? Class::lit : Class::dark;
    }
    /// Of the pixels that are asked about.
    double share(const TestFrame& frame, Class wanted) const {
        const std::vector<std::size_t> asked = frame.asked();
        const auto count =
            std::ranges::count_if(asked, [&](std::size_t i) { return of(frame, i) == wanted; });
        return static_cast<double>(count) / static_cast<double>(asked.size());
    }
};

TEST_F(PixelClassesTest, UnoccludedPlanesOfAnySlopeAreLit) {
    for (const double tiltDeg : {0.0, 30.0, 60.0, 85.0, 89.0}) {
        const TestFrame frame = TiltedPlane{tiltDeg}.frame(0.1);
        const Classes classes(frame, PixelClasses::Dark::yes);
        for (std::size_t i = 0; i < TiltedPlane::kPixels; ++i)
            ASSERT_NE(classes.of(frame, i), Class::dark) << tiltDeg;
        // At 89 degrees the slopes of the pyramid's planes, half floats, no longer tell.
        if (tiltDeg < 89.0) {
            EXPECT_GT(classes.share(frame, Class::lit), 0.5) << tiltDeg;
        }
    }
}

TEST_F(PixelClassesTest, UnderASheetOnlyPcssIsDark) {
    Shape shape;
    shape.rectangle({-0.5, -0.5}, {0.5, 0.5}, 0.0);
    shape.rectangle({-4.0, -4.0}, {4.0, 4.0}, 0.5);
    const World world{shape.geometry(), lightAbove(2.0, 0.5, 0.3)};
    const TestFrame frame(
        world, planeGBuffer(46, 46, {-0.5, -0.5, 0.0}, {1, 0, 0}, {0, 1, 0}, world.light));
    EXPECT_EQ(Classes(frame, PixelClasses::Dark::yes, {0.0f, 4.0f}).share(frame, Class::dark), 1.0);
    EXPECT_EQ(Classes(frame, PixelClasses::Dark::no).share(frame, Class::undecided), 1.0);
}

TEST_F(PixelClassesTest, LitTilesAreLitForRays) {
    Shape shape;
    shape.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    for (int i = 0; i < 12; ++i) {
        const glm::dvec2 at(std::sin(2.4 * i) * 0.08 * i, std::cos(2.4 * i) * 0.08 * i);
        shape.sphere({at, 0.1 + 0.09 * i}, 0.12, 12);
    }
    shape.quad({-1.0, 0.6, 0.0}, {1.0, 0.6, 0.0}, {1.0, 1.2, 0.8}, {-1.0, 1.2, 0.8});
    for (const double widthM : {0.02, 0.3, 0.9}) {
        World world{shape.geometry(), lightAbove(3.0, widthM, 0.5 * widthM)};
        world.camera = lookingAt({1.5, -2.5, 2.5}, {0.0, 0.1, 0.2});
        const TestFrame frame(world, 126);  // no multiple of a tile
        const Visibility traced = render(frame, "ray_traced", {{"rays", "64"}});
        const Classes classes(frame, PixelClasses::Dark::no);
        const int wrong = violations(frame, traced, [&](float v, std::size_t i) {
            return classes.of(frame, i) != Class::lit || v == 1.0f;
        });
        // Bias and texels: receivers within some millimetres of a sphere's facet that hides a rim
        // of the light. Of 10 000 pixels that are lit.
        EXPECT_LE(wrong, 10) << widthM;
        EXPECT_GT(classes.share(frame, Class::lit), 0.25) << widthM;
        EXPECT_GT(classes.share(frame, Class::undecided), 0.05) << widthM;
    }
}

}  // namespace
}  // namespace penumbra
