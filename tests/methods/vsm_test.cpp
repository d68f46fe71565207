#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/passes/depth_pass.hpp"
#include "core/passes/layer_pass.hpp"
#include "tests/methods/test_worlds.hpp"
#include "tests/support/closed_forms.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/shader_folder.hpp"

namespace penumbra {
namespace {

using namespace test;

class Vsm : public GlTest {};

/// The inequality alone: one kernel, one box, no bias, nothing cut off. The least variance stays at
/// its default, some 1e-5, unless `more` says otherwise.
Assignments bare(const Assignments& more = {}) {
    Assignments all = {{"kernel", "fixed"}, {"subdivisions", "1"}, {"bleed", "0"}, {"bias", "0"}};
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

struct Query {
    double mean, meanSquare, t, minVariance;
};

/// shaders/common/chebyshev.glsl on the GPU.
std::vector<float> chebyshev(const std::vector<Query>& queries) {
    const ShaderFolder folder;
    folder.write("chebyshev_test.glsl", R"(
#include "common/fullscreen.glsl"
#include "common/chebyshev.glsl"
#ifdef STAGE_FRAGMENT
layout(binding = 0) uniform sampler2DArray queries;
layout(location = 0) out float bound;
void main() {
    vec4 q = texelFetch(queries, ivec3(gl_FragCoord.xy, 0), 0);
    bound = chebyshev(q.xy, q.z, q.w);
}
#endif
)");
    const gl::Program program = gl::Program::graphics("chebyshev_test.glsl");
    std::vector<glm::vec4> texels;
    for (const Query& q : queries)
        texels.emplace_back(glm::dvec4(q.mean, q.meanSquare, q.t, q.minVariance));
    const auto count = static_cast<int>(queries.size());
    const gl::Texture from = gl::Texture::createArray(GL_RGBA32F, count, 1, 1);
    const gl::Texture to = gl::Texture::createArray(GL_R32F, count, 1, 1);
    glTextureSubImage3D(from.id(), 0, 0, 0, 0, count, 1, 1, GL_RGBA, GL_FLOAT, texels.data());
    from.bind(0);
    LayerPass::create().draw(program, to, 0);
    std::vector<float> bounds(queries.size());
    glGetTextureImage(to.id(), 0, GL_RED, GL_FLOAT,
                      static_cast<GLsizei>(bounds.size() * sizeof(float)), bounds.data());
    return bounds;
}

/// Moments of a share `near` of depths at a and the rest at b.
Query twoDepths(double near, double a, double b, double t, double minVariance = 0.0) {
    return {near * a + (1 - near) * b, near * a * a + (1 - near) * b * b, t, minVariance};
}

TEST_F(Vsm, ChebyshevIsExactForTwoDepths) {
    std::vector<Query> queries;
    for (int i = 1; i < 10; ++i) queries.push_back(twoDepths(0.1 * i, -0.6, 0.7, 0.7));
    const std::vector<float> bounds = chebyshev(queries);
    // Rounding of the moments, 6e-8, over their variance of at least 0.15 and squared distance.
    for (int i = 1; i < 10; ++i)
        EXPECT_NEAR(bounds[static_cast<std::size_t>(i - 1)], 1.0 - 0.1 * i, 2e-6);
}

TEST_F(Vsm, ChebyshevNeverRisesWithTheReceiversDepth) {
    std::vector<Query> queries;
    for (int i = 0; i <= 400; ++i) queries.push_back(twoDepths(0.3, -0.5, 0.2, -1 + 0.005 * i));
    const std::vector<float> bounds = chebyshev(queries);
    EXPECT_EQ(bounds.front(), 1.0f);
    EXPECT_LT(bounds.back(), 0.2f);
    for (std::size_t i = 1; i < bounds.size(); ++i) EXPECT_LE(bounds[i], bounds[i - 1]) << i;
}

TEST_F(Vsm, ChebyshevDoesNotCareForTheUnitOfDepth) {
    std::vector<Query> unit, mapped;
    for (const double scale : {0.25, 0.5})
        for (const double offset : {-0.4, 0.0, 0.3}) {
            unit.push_back(twoDepths(0.4, 0.1, 0.6, 0.9, 0.01));
            mapped.push_back(twoDepths(0.4, scale * 0.1 + offset, scale * 0.6 + offset,
                                       scale * 0.9 + offset, scale * scale * 0.01));
        }
    const std::vector<float> a = chebyshev(unit), b = chebyshev(mapped);
    // Rounding of the moments over a variance of at least 0.06 / 16.
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-4);
}

TEST_F(Vsm, ChebyshevOfImpossibleMomentsIsANumber) {
    // Mean squares below the squared mean; depths so close that floats cannot tell (hard case 9).
    const std::vector<float> bounds = chebyshev({{0.9, 0.8, 0.95, 0.0},
                                                 {0.9, 0.8, 0.9, 0.0},
                                                 {1, 1 - 1e-7, 1, 1e-7},
                                                 {1, 1 - 1e-7, 1, 0},
                                                 {0, 0, 0, 0},
                                                 twoDepths(0.5, 0.999, 0.9991, 0.9991, 1e-6)});
    for (const float v : bounds) EXPECT_TRUE(v >= 0.0f && v <= 1.0f) << v;
    EXPECT_EQ(bounds[1], 1.0f);
    EXPECT_EQ(bounds[2], 1.0f);
    EXPECT_EQ(bounds[4], 1.0f);
    // The least variance hides the noise: 1e-6 / (1e-6 + 0.00005^2), less float's 6e-8 / 1e-6.
    EXPECT_GT(bounds[5], 0.9f);
}

/// Depths in metres of the map that the method makes of a frame seen in one frustum.
struct DepthMap {
    LightTile tile;
    int size;
    std::vector<float> zM;

    DepthMap(const TestFrame& frame, double widest, int mapSize) : size(mapSize) {
        const AreaLight& light = frame->light;
        DepthPass pass(Plan{});
        pass.render(*frame,
                    LightView::fit(*frame, widest * glm::dvec2(light.halfU, light.halfV), mapSize),
                    mapSize);
        tile = pass.view().tiles.at(0);
        zM.resize(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
        glGetTextureImage(pass.map().id(), 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                          static_cast<GLsizei>(zM.size() * sizeof(float)), zM.data());
        for (float& z : zM)
            z = z > 0.0f ? static_cast<float>(tile.nearM / static_cast<double>(z)) : HUGE_VALF;
    }

    /// Share of a kernel at pixel `i`, each texel counting by its covered part, that lies no nearer
    /// than the pixel.
    double litShare(const TestFrame& frame, std::size_t i, double kernel) const {
        const AreaLight& light = frame->light;
        const glm::dvec3 p = glm::dvec3(frame->gbuffer.position[i]) - light.centre;
        const double z = glm::dot(tile.axisZ, p);
        const glm::dvec2 toTexels = static_cast<double>(size) / tile.tangentSize();
        const glm::dvec2 t(glm::dot(tile.axisX, p) / z, glm::dot(tile.axisY, p) / z);
        const glm::dvec2 centre = (t - tile.tangentLo) * toTexels;
        const glm::dvec2 half = kernel * glm::dvec2(light.halfU, light.halfV) / z * toTexels;
        const auto covered = [&](int axis, int texel) {
            return std::max(0.0, std::min(centre[axis] + half[axis], texel + 1.0) -
                                     std::max(centre[axis] - half[axis], double(texel)));
        };
        double lit = 0.0, all = 0.0;
        const auto first = [&](int axis) {
            return std::max(0, static_cast<int>(std::floor(centre[axis] - half[axis])));
        };
        const auto last = [&](int axis) {
            return std::min(size - 1, static_cast<int>(std::floor(centre[axis] + half[axis])));
        };
        for (int y = first(1); y <= last(1); ++y)
            for (int x = first(0); x <= last(0); ++x) {
                const double w = covered(0, x) * covered(1, y);
                const double depth = zM[static_cast<std::size_t>(y * size + x)];
                all += w;
                lit += depth > z * (1.0 - 1e-5) ? w : 0.0;
            }
        return lit / all;
    }
};

/// Pieces of different heights above a floor, all parallel to the light.
TestFrame piecesOverFloor(double lightM) {
    Shape shape;
    shape.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    shape.rectangle({-0.5, -0.4}, {0.1, 0.2}, 0.9);
    shape.rectangle({-0.2, -0.1}, {0.4, 0.5}, 0.5);
    shape.rectangle({0.1, -0.6}, {0.3, 0.0}, 0.3);
    const AreaLight light = lightAbove(2.0, lightM, lightM);
    return {{shape.geometry(), light},
            planeGBuffer(48, 48, {-0.9, -0.9, 0.0}, {1.8, 0, 0}, {0, 1.8, 0}, light)};
}

TEST_F(Vsm, BoundsPercentageCloserFilteringFromAbove) {
    const TestFrame frame = piecesOverFloor(0.6);
    const DepthMap map(frame, 1.0, 128);
    const Visibility image = render(
        frame, "vsm", bare({{"map_size", "128"}, {"kernel_size", "1"}, {"min_variance", "0"}}));
    int looser = 0;
    // Without a least variance the table's rounding, 4e-6 for boxes of 26 x 26 texels, shifts V by
    // at most itself over the squared distance from casters to floor: (0.3 of 1)^2.
    constexpr double kRounding = 1e-4;
    EXPECT_EQ(violations(frame, image,
                         [&](float v, std::size_t i) {
                             const double share = map.litShare(frame, i, 1.0);
                             looser += v > share + 0.02;
                             return v >= share - kRounding;
                         }),
              0);
    EXPECT_GT(looser, 50) << "layers under layers must show the bound's slack";
}

TEST_F(Vsm, EqualsPercentageCloserFilteringOfOneCaster) {
    for (const char* prefilter : {"sat_uint", "sat_float"})
        for (const char* subdivisions : {"1", "3", "4"}) {
            const TestFrame frame = HalfPlane{}.frame(0.6, 0.4, 48);
            const DepthMap map(frame, 1.0, 128);
            const Visibility image = render(frame, "vsm",
                                            bare({{"map_size", "128"},
                                                  {"kernel_size", "1"},
                                                  {"subdivisions", subdivisions},
                                                  {"prefilter", prefilter}}));
            // Both depths differ by a quarter of the range, whose square is 1000 times the least
            // variance of 2 * (4e-6 + 1e-7).
            EXPECT_EQ(violations(frame, image,
                                 [&](float v, std::size_t i) {
                                     return std::abs(v - map.litShare(frame, i, 1.0)) < 2e-3;
                                 }),
                      0)
                << prefilter << ", " << subdivisions;
        }
}

TEST_F(Vsm, BleedsAsTheInequalitySays) {
    // Hard case 10: half of the kernel at A, half at B, all of it in front of the receiver C, so
    // that the truth is 0. METHODS.md 4's table, in units of B - A.
    for (const auto& [c, leak] : {std::pair{1.5, 0.2}, {2.0, 0.1}, {4.0, 0.02}, {10.0, 0.00276}}) {
        constexpr double kLightM = 4.0, kUnitM = 0.25, kDepthA = 1.0;
        const double receiver = kLightM - kDepthA - c * kUnitM;
        Shape shape;
        shape.rectangle({-9.0, -9.0}, {0.0, 9.0}, kLightM - kDepthA);
        shape.rectangle({-9.0, -9.0}, {9.0, 9.0}, kLightM - kDepthA - kUnitM);
        shape.rectangle({-9.0, -9.0}, {9.0, 9.0}, receiver);
        const AreaLight light = lightAbove(kLightM, 0.5, 0.5);
        // The middle column of an odd number looks straight up along the edge of A.
        constexpr int kColumns = 33;
        const TestFrame frame(
            {shape.geometry(), light},
            planeGBuffer(kColumns, 3, {-1, -1, receiver}, {2, 0, 0}, {0, 2, 0}, light));
        const Visibility image = render(frame, "vsm", bare({{"kernel_size", "1"}}));
        EXPECT_NEAR(image[kColumns + kColumns / 2], leak, 1e-3) << c;
        // Light-bleeding reduction takes away what is below it, and stretches the rest.
        const Visibility reduced =
            render(frame, "vsm", bare({{"kernel_size", "1"}, {"bleed", "0.15"}}));
        EXPECT_NEAR(reduced[kColumns + kColumns / 2], std::max(0.0, (leak - 0.15) / 0.85), 1.2e-3)
            << c;
    }
}

TEST_F(Vsm, RangeOfDepthsDoesNotMatter) {
    // Receivers farther away and within the same view stretch the range that [-1, 1] stands for.
    const AreaLight light = lightAbove(2.0, 0.6, 0.6);
    Shape shape;
    shape.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    shape.rectangle({0.1, -5.0}, {5.0, 5.0}, 0.5);
    const auto floor = planeGBuffer(48, 48, {-0.8, -0.8, 0.0}, {1.6, 0, 0}, {0, 1.6, 0}, light);
    const auto below = planeGBuffer(48, 4, {-0.1, -0.1, -3.0}, {0.2, 0, 0}, {0, 0.2, 0}, light);
    const Visibility image = render({{shape.geometry(), light}, floor}, "vsm", bare());
    const TestFrame deeper({shape.geometry(), light}, stacked({floor, below}));
    const Visibility other = render(deeper, "vsm", bare());
    int compared = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        // The least variance, 1e-5 of either range, over the smaller squared distance of 0.2^2.
        EXPECT_NEAR(image[i], other[i], 1e-3);
        compared += image[i] > 0.01f && image[i] < 0.99f;
    }
    EXPECT_GT(compared, 100);
}

TEST_F(Vsm, FlatReceiversAreLitInEveryFormatAndPrefilter) {
    // t equals the mean and the variance is 0: rounding alone decides. No bias helps.
    Shape shape;
    shape.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    const AreaLight light = lightAbove(2.0, 0.6, 0.6);
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(48, 48, {-0.8, -0.8, 0}, {1.6, 0, 0}, {0, 1.6, 0}, light));
    for (const char* prefilter : {"sat_uint", "sat_float", "mipmap", "box", "gaussian"})
        for (const char* format : {"rg32f", "rg16f", "rg16"}) {
            const Visibility image =
                render(frame, "vsm",
                       bare({{"prefilter", prefilter}, {"format", format}, {"map_size", "128"}}));
            // A depth is off by half a step q, the least variance is 2 q': q^2 / 4 / 2 q'.
            EXPECT_EQ(violations(frame, image, [](float v, auto) { return v > 0.999f; }), 0)
                << prefilter << ", " << format;
        }
}

TEST_F(Vsm, SlopesOfAnySteepnessStayLit) {
    for (const double tiltDeg : {0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0})
        for (const char* kernel : {"fixed", "pcss"})
            for (const char* subdivisions : {"1", "4"}) {
                const TestFrame frame = TiltedPlane{tiltDeg}.frame(0.3);
                const Visibility image = render(frame, "vsm",
                                                {{"kernel", kernel},
                                                 {"kernel_size", "1"},
                                                 {"subdivisions", subdivisions},
                                                 {"map_size", "128"}});
                EXPECT_EQ(violations(frame, image,
                                     [](float v, std::size_t i) {
                                         return i >= TiltedPlane::kPixels || v == 1.0f;
                                     }),
                          0)
                    << tiltDeg << " degrees, " << kernel << ", " << subdivisions;
            }
}

TEST_F(Vsm, SlopesThatLeaveTheDepthRangeStayLit) {
    // The plane alone: its farthest points end the map's depths, the plane itself goes on beyond.
    for (const double tiltDeg : {30.0, 60.0, 80.0}) {
        const double tilt = glm::radians(tiltDeg);
        const glm::dvec3 up(std::cos(tilt), 0.0, std::sin(tilt)), along(0.0, 1.0, 0.0);
        Shape shape;
        shape.quad(-2.0 * (up + along), 2.0 * (up - along), 2.0 * (up + along), 2.0 * (along - up));
        const AreaLight light = lightAbove(3.0, 0.4, 0.4);
        const TestFrame frame({shape.geometry(), light},
                              planeGBuffer(48, 48, -up - along, 2.0 * up, 2.0 * along, light));
        for (const char* subdivisions : {"1", "4"})
            EXPECT_EQ(unequal(frame,
                              render(frame, "vsm",
                                     {{"kernel", "fixed"},
                                      {"kernel_size", "1"},
                                      {"subdivisions", subdivisions},
                                      {"map_size", "128"}}),
                              1.0f),
                      0)
                << tiltDeg << " degrees, " << subdivisions;
    }
}

TEST_F(Vsm, KernelsBeyondTheWidestMapAreLitThere) {
    // Eight metres to each side in two metres depth: past the 70 degrees a view is widened to.
    const AreaLight light = lightAbove(2.0, 4.0, 4.0);
    Shape shape;
    shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(32, 32, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, light));
    for (const char* prefilter : {"sat_uint", "sat_float", "mipmap", "gaussian"})
        EXPECT_EQ(violations(frame,
                             render(frame, "vsm",
                                    {{"kernel", "fixed"},
                                     {"kernel_size", "4"},
                                     {"map_size", "128"},
                                     {"prefilter", prefilter}}),
                             [](float v, auto) { return v == 1.0f; }),
                  0)
            << prefilter;
}

TEST_F(Vsm, PenumbraOfOneParallelCasterIsExact) {
    // The blockers' mean depth is exact where kernels hold two depths, and so is the penumbra's
    // width: the closed form but for texels, on both axes of an uneven light.
    for (const int axis : {0, 1})
        for (const double heightM : {0.25, 0.5, 0.9}) {
            HalfPlane caster;
            caster.axis = axis;
            caster.heightM = heightM;
            const glm::dvec2 light(0.8, 0.2);
            const TestFrame frame = caster.frame(light.x, light.y, 128);
            const Visibility image =
                render(frame, "vsm",
                       {{"search", "1"}, {"bleed", "0"}, {"bias", "0"}, {"map_size", "1024"}});
            const double casterEdgeM =
                caster.edgeM * (HalfPlane::kLightM - heightM) / HalfPlane::kLightM;
            const double penumbraM = light[axis] * heightM / (HalfPlane::kLightM - heightM);
            // The caster's edge is off by up to half a texel, the mean depth by the least variance.
            const double tolerance =
                0.5 * texelM(frame, 0.5 * std::max(light.x, light.y), 1024, HalfPlane::kLightM) /
                    penumbraM +
                0.01;
            EXPECT_EQ(violations(frame, image,
                                 [&](float v, std::size_t i) {
                                     return std::abs(v - closed_form::halfPlane(
                                                             caster.across(frame, i), casterEdgeM,
                                                             heightM, light[axis],
                                                             HalfPlane::kLightM)) < tolerance;
                                 }),
                      0)
                << "axis " << axis << ", " << heightM << " m high";
        }
}

TEST_F(Vsm, PenumbraOnASlopeRunsOneWay) {
    // A slope that falls or rises towards the shadow. Where the first few blockers come into the
    // search their depth must not be anything but the caster's, or a dark rim shows there.
    for (const double tiltDeg : {-50.0, -30.0, 30.0, 50.0}) {
        const double tilt = glm::radians(tiltDeg);
        const glm::dvec3 up(std::cos(tilt), 0.0, std::sin(tilt)), along(0.0, 1.0, 0.0);
        Shape shape;
        shape.quad(-2.0 * (up + along), 2.0 * (up - along), 2.0 * (up + along), 2.0 * (along - up));
        shape.rectangle({0.0, -5.0}, {5.0, 5.0}, 1.2);
        const AreaLight light = lightAbove(5.0, 0.8, 0.8);
        constexpr int kColumns = 256;
        const TestFrame frame(
            {shape.geometry(), light},
            planeGBuffer(kColumns, 3, -0.6 * (up + along), 1.2 * up, 1.2 * along, light));
        const Visibility image = render(frame, "vsm");
        EXPECT_EQ(image[0], 1.0f);
        EXPECT_LT(image[kColumns - 1], 0.01f);
        // A step of a texel may pass between pixels, 1/40 of the penumbra.
        for (std::size_t i = 1; i < kColumns; ++i)
            EXPECT_LE(image[i], image[i - 1] + 0.025f) << tiltDeg << " degrees, column " << i;
    }
}

TEST_F(Vsm, PrefiltersAgreeOnOneCaster) {
    const TestFrame frame = HalfPlane{}.frame(0.8, 0.8);
    for (const char* kernel : {"fixed", "pcss"}) {
        const Assignments base = {{"kernel", kernel}, {"kernel_size", "0.4"}, {"bleed", "0"}};
        const Visibility image = render(frame, "vsm", base);
        // Another profile of the same variance: a Gaussian's differs from the box's by up to 0.06,
        // the tents and steps of mip levels by more; pcss scales kernels by what it finds.
        for (const auto& [prefilter, most] :
             {std::pair{"sat_float", 0.01}, {"box", 0.12}, {"gaussian", 0.12}, {"mipmap", 0.12}}) {
            Assignments other = base;
            other.emplace_back("prefilter", prefilter);
            const Visibility filtered = render(frame, "vsm", other);
            EXPECT_EQ(violations(frame, filtered,
                                 [&, limit = most](float v, std::size_t i) {
                                     return std::abs(v - image[i]) < limit;
                                 }),
                      0)
                << kernel << ", " << prefilter;
        }
    }
}

TEST_F(Vsm, LightWithoutExtentIsTheHardMap) {
    const Visibility hard = render(HalfPlane{}.frame(0.0, 0.0), "hard", {{"map_size", "512"}});
    EXPECT_EQ(render(HalfPlane{}.frame(0.0, 0.0), "vsm"), hard);
    EXPECT_EQ(
        render(HalfPlane{}.frame(0.8, 0.8), "vsm", {{"kernel", "fixed"}, {"kernel_size", "0"}}),
        hard);
    EXPECT_EQ(render(HalfPlane{}.frame(0.8, 0.8), "vsm", {{"search", "0"}}), hard);
    // Kernels below a texel of the map have nothing to average.
    EXPECT_EQ(render(HalfPlane{}.frame(1e-4, 1e-4), "vsm"),
              render(HalfPlane{}.frame(1e-4, 1e-4), "vsm", {{"kernel", "fixed"}}));
}

TEST_F(Vsm, ScaleDoesNotMatterToAnyPrefilter) {
    for (const char* prefilter : {"sat_float", "mipmap", "gaussian"})
        for (const char* kernel : {"fixed", "pcss"}) {
            const World world = HalfPlane{}.world(0.8, 0.8);
            const World large = scaled(world, 256.0);
            const auto points = [](const World& w, double f) {
                return planeGBuffer(48, 48, f * glm::dvec3(-0.8, -0.8, 0.0), {1.6 * f, 0, 0},
                                    {0, 1.6 * f, 0}, w.light);
            };
            const Assignments settings = {{"prefilter", prefilter}, {"kernel", kernel}};
            EXPECT_EQ(render({world, points(world, 1.0)}, "vsm", settings),
                      render({large, points(large, 256.0)}, "vsm", settings))
                << prefilter << ", " << kernel;
        }
}

}  // namespace
}  // namespace penumbra
