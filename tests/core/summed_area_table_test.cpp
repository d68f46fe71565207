#include "core/passes/summed_area_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "core/passes/layer_pass.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/shader_folder.hpp"

namespace penumbra {
namespace {

using namespace test;
using Kind = SummedAreaTable::Kind;

class SummedAreaTableTest : public GlTest {};

/// A source in [-1, 1]^2, row by row, layer by layer.
struct Map {
    int width, height, layers = 1;
    std::vector<glm::vec2> texels{};

    Map(int w, int h, int l, const std::function<glm::vec2(int x, int y, int layer)>& at)
        : width(w), height(h), layers(l) {
        for (int k = 0; k < l; ++k)
            for (int y = 0; y < h; ++y)
                for (int x = 0; x < w; ++x) texels.push_back(at(x, y, k));
    }
    gl::Texture texture() const {
        gl::Texture result = gl::Texture::createArray(GL_RG32F, width, height, layers);
        glTextureSubImage3D(result.id(), 0, 0, 0, 0, width, height, layers, GL_RG, GL_FLOAT,
                            texels.data());
        return result;
    }
};

Map noise(int width, int height, int layers, float lo = -1.0f, float hi = 1.0f) {
    std::mt19937 generator(7);
    std::uniform_real_distribution<float> uniform(lo, hi);
    return {width, height, layers,
            [&](int, int, int) { return glm::vec2(uniform(generator), uniform(generator)); }};
}

struct Box {
    glm::dvec2 lo, hi;
    int layer = 0;
};

/// What part of texel `i` lies between lo and hi.
double covered(double lo, double hi, int i) {
    return std::max(0.0, std::min(hi, i + 1.0) - std::max(lo, static_cast<double>(i)));
}

struct Statistics {
    glm::dvec2 mean{0.0}, middle{0.0};
    double area = 0.0;
};

Statistics bruteForce(const Map& map, const Box& box) {
    Statistics s;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const double w = covered(box.lo.x, box.hi.x, x) * covered(box.lo.y, box.hi.y, y);
            if (w == 0.0) continue;
            const auto i = static_cast<std::size_t>((box.layer * map.height + y) * map.width + x);
            s.mean += w * glm::dvec2(map.texels[i]);
            s.middle += w * (glm::dvec2(x, y) + 0.5);
            s.area += w;
        }
    s.mean /= s.area;
    s.middle /= s.area;
    return s;
}

/// Looks boxes up through shaders/common/summed_area_table.glsl: for each, its cells.
std::vector<std::vector<Statistics>> lookUp(const SummedAreaTable& table, Kind kind,
                                            const std::vector<Box>& boxes, int cells) {
    const ShaderFolder folder;
    folder.write("lookup.glsl", R"(
#include "common/fullscreen.glsl"
#include "common/summed_area_table.glsl"
#ifdef STAGE_FRAGMENT
uniform vec4 corners;
uniform int boxLayer;
layout(location = 0) out vec4 result;
void main() {
    BoxCells box = tableBox(corners.xy, corners.zw, boxLayer);
    int cell = int(gl_FragCoord.x), i = cell % kCells, j = cell / kCells;
    if (gl_FragCoord.y < 1.0)
        result = vec4(box.mean[cell], box.x.size[i], box.y.size[j]);
    else
        result = vec4(box.x.middle[i], box.y.middle[j], 0.0, 0.0);
}
#endif
)");
    std::vector<std::string> defines = {"TABLE_CELLS " + std::to_string(cells)};
    if (kind == Kind::uint32) defines.emplace_back("TABLE_UINT");
    const gl::Program program = gl::Program::graphics("lookup.glsl", defines);
    const LayerPass pass = LayerPass::create();
    const gl::Texture target = gl::Texture::createArray(GL_RGBA32F, cells * cells, 2, 1);
    table.bind(program, 1);
    std::vector<std::vector<Statistics>> results;
    for (const Box& box : boxes) {
        program.set("corners", glm::vec4(box.lo, box.hi));
        program.set("boxLayer", box.layer);
        pass.draw(program, target, 0);
        const auto count = static_cast<std::size_t>(cells * cells);
        std::vector<glm::vec4> texels(2 * count);
        glGetTextureImage(target.id(), 0, GL_RGBA, GL_FLOAT,
                          static_cast<GLsizei>(texels.size() * sizeof(glm::vec4)), texels.data());
        std::vector<Statistics> found;
        for (std::size_t c = 0; c < count; ++c)
            found.push_back({glm::dvec2(texels[c].x, texels[c].y),
                             glm::dvec2(texels[count + c].x, texels[count + c].y),
                             static_cast<double>(texels[c].z) * texels[c].w});
        results.push_back(found);
    }
    return results;
}

SummedAreaTable built(const Map& map, Kind kind, double maxBoxTexels) {
    SummedAreaTable table = SummedAreaTable::create(kind);
    table.build(map.texture(), maxBoxTexels);
    return table;
}

/// Corner texels, the whole map, boxes at every border, within one row of texels, fractional ones.
std::vector<Box> telling(const Map& map) {
    const double w = map.width, h = map.height;
    std::vector<Box> boxes;
    for (int layer = 0; layer < map.layers; ++layer)
        for (const auto& [lo, hi] :
             std::vector<std::pair<glm::dvec2, glm::dvec2>>{{{0, 0}, {1, 1}},
                                                            {{w - 1, h - 1}, {w, h}},
                                                            {{w - 1, 0}, {w, 1}},
                                                            {{5, 7}, {6, 8}},
                                                            {{0, 0}, {w, h}},
                                                            {{0, 3}, {w, 4}},
                                                            {{0, 0}, {4.25, 2.5}},
                                                            {{w - 3.75, h - 9.5}, {w, h}},
                                                            {{0, h - 1.5}, {w - 0.5, h}},
                                                            {{2.5, 3.25}, {3.5, 4.25}},
                                                            {{8.125, 1.75}, {20.5, 16.25}},
                                                            {{0.5, 0.5}, {w - 0.5, h - 0.5}}})
            boxes.push_back({lo, hi, layer});
    return boxes;
}

TEST_F(SummedAreaTableTest, BoxesEqualBruteForce) {
    // Sizes that are no multiple of a scan's pieces; 3 is fewer texels than there are pieces.
    for (const glm::ivec2 size : {glm::ivec2(37, 29), glm::ivec2(64, 32), glm::ivec2(130, 25)}) {
        const Map map = noise(size.x, size.y, 2);
        const double texels = size.x * size.y;
        for (const Kind kind : {Kind::uint32, Kind::float32, Kind::float32_with_mean}) {
            const SummedAreaTable table = built(map, kind, texels);
            const std::vector<Box> boxes = telling(map);
            const auto found = lookUp(table, kind, boxes, 1);
            for (std::size_t b = 0; b < boxes.size(); ++b) {
                const Statistics expected = bruteForce(map, boxes[b]);
                // Integers: half a step. Floats: the last place of sums below 100, about what
                // 4000 numbers of either sign come to, in up to 16 corners.
                const double tolerance = kind == Kind::uint32
                                             ? table.stepError() + 1e-6
                                             : 16 * 0x1p-24 * 100.0 / expected.area + 1e-6;
                EXPECT_NEAR(found[b][0].mean.x, expected.mean.x, tolerance) << "box " << b;
                EXPECT_NEAR(found[b][0].mean.y, expected.mean.y, tolerance) << "box " << b;
                EXPECT_NEAR(found[b][0].area, expected.area, 1e-5 * expected.area) << "box " << b;
                EXPECT_NEAR(found[b][0].middle.x, expected.middle.x, 1e-4) << "box " << b;
                EXPECT_NEAR(found[b][0].middle.y, expected.middle.y, 1e-4) << "box " << b;
            }
        }
    }
}

TEST_F(SummedAreaTableTest, CellsArePartsOfTheirBox) {
    const Map map = noise(37, 29, 2);
    const SummedAreaTable table = built(map, Kind::uint32, 37.0 * 29.0);
    const std::vector<Box> boxes = telling(map);
    for (const int cells : {2, 3, 4}) {
        const auto found = lookUp(table, Kind::uint32, boxes, cells);
        for (std::size_t b = 0; b < boxes.size(); ++b) {
            const Statistics expected = bruteForce(map, boxes[b]);
            Statistics sum;
            for (const Statistics& cell : found[b]) {
                sum.area += cell.area;
                sum.mean += cell.area * cell.mean;
                sum.middle += cell.area * cell.middle;
            }
            EXPECT_NEAR(sum.area, expected.area, 1e-5 * expected.area);
            EXPECT_NEAR(sum.mean.x / sum.area, expected.mean.x, table.stepError() + 1e-6);
            EXPECT_NEAR(sum.middle.y / sum.area, expected.middle.y, 1e-4);
            // Lines lie between texels, so that cells are equal but for a texel each way.
            const glm::dvec2 side = (boxes[b].hi - boxes[b].lo) / static_cast<double>(cells);
            for (const Statistics& cell : found[b])
                EXPECT_LE(cell.area, (side.x + 1.0) * (side.y + 1.0) * 1.00001);
        }
    }
}

TEST_F(SummedAreaTableTest, IntegersMayWrapAround) {
    // Sums of ones, the greatest there are: the whole map's is 1024 times what 32 bits hold.
    constexpr int kSize = 256;
    const Map map(kSize, kSize, 1, [](int x, int y, int) {
        return glm::vec2(1.0f, (x + y) % 3 == 0 ? -1.0f : 1.0f);
    });
    const SummedAreaTable table = built(map, Kind::uint32, 64.0);
    ASSERT_GT(kSize * kSize * 2.0 / SummedAreaTable::stepOf(64.0), 1000.0 * 0x1p32);
    const std::vector<Box> boxes = {{{248, 248}, {256, 256}},
                                    {{100, 30}, {108, 38}},
                                    {{200.5, 199.25}, {207.5, 206}},
                                    {{0, 0}, {8, 8}},
                                    {{255, 255}, {256, 256}}};
    const auto found = lookUp(table, Kind::uint32, boxes, 1);
    for (std::size_t b = 0; b < boxes.size(); ++b) {
        const Statistics expected = bruteForce(map, boxes[b]);
        EXPECT_NEAR(found[b][0].mean.x, expected.mean.x, 1e-6) << "box " << b;
        EXPECT_NEAR(found[b][0].mean.y, expected.mean.y, 1e-6) << "box " << b;
    }
}

TEST_F(SummedAreaTableTest, BoxesBeyondTheDeclaredLargestShrinkAroundTheirCentre) {
    const Map map = noise(64, 64, 1);
    constexpr double kMost = 100.0;
    const SummedAreaTable table = built(map, Kind::uint32, kMost);
    const auto found = lookUp(table, Kind::uint32, {{{2, 12}, {52, 42}}}, 1);
    EXPECT_LE(found[0][0].area, kMost);
    EXPECT_GT(found[0][0].area, 0.5 * kMost);
    EXPECT_NEAR(found[0][0].middle.x, 27.0, 0.5);
    EXPECT_NEAR(found[0][0].middle.y, 27.0, 0.5);
    for (const int axis : {0, 1}) EXPECT_LE(std::abs(found[0][0].mean[axis]), 1.0);
}

TEST_F(SummedAreaTableTest, IntegersClampWhatTheyCannotHold) {
    const Map map(8, 8, 1, [](int x, int, int) { return glm::vec2(x < 4 ? -5.0f : 5.0f, 0.0f); });
    const auto found = lookUp(built(map, Kind::uint32, 64.0), Kind::uint32,
                              {{{0, 0}, {4, 8}}, {{4, 0}, {8, 8}}, {{2, 0}, {6, 8}}}, 1);
    EXPECT_NEAR(found[0][0].mean.x, -1.0, 1e-6);
    EXPECT_NEAR(found[1][0].mean.x, 1.0, 1e-6);
    EXPECT_NEAR(found[2][0].mean.x, 0.0, 1e-6);
}

/// Root mean square error of means of 5 x 5 texels all over the map.
double smallBoxError(const Map& map, Kind kind) {
    std::vector<Box> boxes;
    for (int y = 2; y + 5 <= map.height; y += 61)
        for (int x = 3; x + 5 <= map.width; x += 61) boxes.push_back({{x, y}, {x + 5, y + 5}});
    const auto found = lookUp(built(map, kind, 25.0), kind, boxes, 1);
    double sum = 0.0;
    for (std::size_t b = 0; b < boxes.size(); ++b) {
        const double error = found[b][0].mean.x - bruteForce(map, boxes[b]).mean.x;
        sum += error * error;
    }
    return std::sqrt(sum / static_cast<double>(boxes.size()));
}

TEST_F(SummedAreaTableTest, SubtractingTheMeanSavesFloatsFromThemselves) {
    // METHODS.md 5: depths of 0.6 to 0.7. The whole sum is 1.7e5, whose last place of 2^-6 four
    // corners share among 25 texels; less the mean it is a walk of 0.03 per step, about 15.
    const Map map = noise(512, 512, 1, 0.6f, 0.7f);
    EXPECT_GT(smallBoxError(map, Kind::float32_with_mean), 1e-5);
    EXPECT_LT(smallBoxError(map, Kind::float32), 1e-6);
    EXPECT_LT(smallBoxError(map, Kind::uint32), 1e-7);
}

TEST_F(SummedAreaTableTest, LargeStructureStaysWithinTheStatedError) {
    // Two halves half a unit below and above their mean: what no subtraction helps.
    const Map map(512, 512, 1,
                  [](int x, int, int) { return glm::vec2(x < 256 ? -0.5003f : 0.4997f, 0.0f); });
    const SummedAreaTable table = built(map, Kind::float32, 25.0);
    const double error = smallBoxError(map, Kind::float32);
    EXPECT_LE(error, table.sumError() / 25.0);
    EXPECT_LT(smallBoxError(map, Kind::uint32), 1e-7);
}

TEST_F(SummedAreaTableTest, FollowsTheSourcesSizeAndContent) {
    SummedAreaTable table = SummedAreaTable::create(Kind::uint32);
    for (const int size : {16, 40, 16}) {
        const Map map(size, size, 1, [&](int x, int, int) {
            return glm::vec2(static_cast<float>(x) / static_cast<float>(size), 0.25f);
        });
        table.build(map.texture(), size * size);
        const Box all{{0, 0}, {size, size}};
        const auto found = lookUp(table, Kind::uint32, {all}, 1);
        EXPECT_NEAR(found[0][0].mean.x, bruteForce(map, all).mean.x, table.stepError() + 1e-6);
        EXPECT_NEAR(found[0][0].mean.y, 0.25, table.stepError() + 1e-6);
    }
}

}  // namespace
}  // namespace penumbra
