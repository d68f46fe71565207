#include "core/passes/count_table.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/gl_fixture.hpp"
#include "tests/support/test_scene.hpp"

namespace penumbra {
namespace {

using namespace test;

class CountTableTest : public GlTest {};

constexpr int kSize = 37;  // neither a power of two nor a multiple of a work group

/// Steps and holes at many depths under a light at z = 3.
TestFrame manyDepths() {
    const AreaLight light = lightAbove(3.0, 0.5, 0.5);
    Shape shape;
    for (int i = 0; i < 40; ++i) {
        const double x = -0.9 + 0.31 * (i % 6), y = -0.9 + 0.23 * (i % 7), z = 0.1 + 0.06 * i;
        shape.rectangle({x, y}, {x + 0.17 + 0.01 * i, y + 0.12}, z);
    }
    return {{shape.geometry(), light},
            planeGBuffer(16, 16, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, light)};
}

std::vector<std::uint32_t> plane(const CountTable& table, int index) {
    const int width = table.planes().width(), height = table.planes().height();
    std::vector<std::uint32_t> texels(static_cast<std::size_t>(width) * height);
    glGetTextureSubImage(
        table.planes().id(), 0, 0, 0, index, width, height, 1, GL_RED_INTEGER, GL_UNSIGNED_INT,
        static_cast<GLsizei>(texels.size() * sizeof(std::uint32_t)), texels.data());
    return texels;
}

std::vector<std::uint8_t> covered(const SlicePass& pass, int slice) {
    std::vector<glm::u8vec4> texels(kSize * kSize);
    glGetTextureSubImage(pass.channels().id(), 0, 0, 0, slice / 4, kSize, kSize, 1, GL_RGBA,
                         GL_UNSIGNED_BYTE,
                         static_cast<GLsizei>(texels.size() * sizeof(glm::u8vec4)), texels.data());
    std::vector<std::uint8_t> one;
    for (const glm::u8vec4& texel : texels) one.push_back(texel[slice % 4] > 127);
    return one;
}

TEST_F(CountTableTest, BoxesHaveWhatTheirTexelsHave) {
    const TestFrame frame = manyDepths();
    for (const SliceTargets targets : {SliceTargets::bits, SliceTargets::channels})
        // One, some and all channels of a layer; numbers shared and not; two words of bits.
        for (const int slices : {1, 3, 16, 37, 64})
            for (const double most : {1e9, 1000.0}) {
                SlicePass pass(slices, targets, false);
                pass.render(*frame, SliceView::fit(*frame, {.slices = slices, .mapSize = kSize}),
                            {}, kSize);
                pass.unpack();
                CountTable table = CountTable::create();
                table.build(pass, most);
                const int lanes = most < 65536.0 ? 2 : 1;
                ASSERT_EQ(table.lanes(), lanes);
                std::uint32_t seen = 0;
                for (int k = 0; k < slices; ++k) {
                    const std::vector<std::uint8_t> texels = covered(pass, k);
                    const std::vector<std::uint32_t> sums = plane(table, k / lanes);
                    const auto at = [&](int x, int y) {
                        return sums[static_cast<std::size_t>(y * (kSize + 1) + x)];
                    };
                    for (int y0 = 0; y0 < kSize; y0 += 5)
                        for (int x0 = 0; x0 < kSize; x0 += 6) {
                            const int x1 = std::min(x0 + 11, kSize), y1 = std::min(y0 + 9, kSize);
                            std::uint32_t expected = 0;
                            for (int y = y0; y < y1; ++y)
                                for (int x = x0; x < x1; ++x)
                                    expected += texels[static_cast<std::size_t>(y * kSize + x)];
                            std::uint32_t box = at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0);
                            if (lanes == 2) box = k % 2 == 0 ? box & 0xffffu : box >> 16;
                            ASSERT_EQ(box, expected) << slices << " slices, " << k;
                            seen += expected;
                        }
                }
                EXPECT_GT(seen, 100u) << "the slices are empty: the test could not fail";
            }
}

TEST_F(CountTableTest, ARegionHasTheSumsOfItsTexels) {
    const TestFrame frame = manyDepths();
    SlicePass pass(4, SliceTargets::bits, false);
    constexpr int kWide = 96;
    pass.render(*frame, SliceView::fit(*frame, {.slices = 4, .mapSize = kWide}), {}, kWide);
    CountTable all = CountTable::create(), some = CountTable::create();
    all.build(pass, 1e9);
    some.build(pass, 1e9, {{40, 33}, {60, 90}});
    // In whole blocks of 32 texels.
    ASSERT_EQ(some.planes().width(), 33);
    ASSERT_EQ(some.planes().height(), 65);
    const std::vector<std::uint32_t> whole = plane(all, 1), part = plane(some, 1);
    const auto at = [&](int x, int y) { return whole[static_cast<std::size_t>(y * 97 + x)]; };
    for (int y = 0; y <= 64; ++y)
        for (int x = 0; x <= 32; ++x)
            ASSERT_EQ(part[static_cast<std::size_t>(y * 33 + x)],
                      at(32 + x, 32 + y) - at(32, 32 + y) - at(32 + x, 32) + at(32, 32));
    EXPECT_GT(part.back(), 0u) << "the region is empty: the test could not fail";
}

TEST_F(CountTableTest, BitsAndChannelsAreTheSameSlices) {
    const TestFrame frame = manyDepths();
    const SliceView view = SliceView::fit(*frame, {.mapSize = kSize});
    for (const bool filled : {false, true}) {
        SlicePass bits(16, SliceTargets::bits, false), channels(16, SliceTargets::channels, false);
        for (SlicePass* pass : {&bits, &channels})
            pass->render(*frame, view, {.always = filled}, kSize);
        bits.unpack();
        for (int k = 0; k < 16; ++k) EXPECT_EQ(covered(bits, k), covered(channels, k)) << k;
    }
}

}  // namespace
}  // namespace penumbra
