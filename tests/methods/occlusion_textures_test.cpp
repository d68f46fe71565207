#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/methods/test_worlds.hpp"
#include "tests/support/closed_forms.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra {
namespace {

using namespace test;
using closed_form::Rect;

class OcclusionTextures : public GlTest {};

constexpr double kHeightM = 4.0;  // of the light over the receiver

/// The paper: whole kernels, even slices, no filling, no map; `more` on top.
Assignments bare(const Assignments& more = {}) {
    Assignments all = {
        {"cells", "1"}, {"thin_casters", "none"}, {"placement", "uniform"}, {"contact", "none"}};
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

double rmse(const TestFrame& frame, const Visibility& image, const auto& expected) {
    double sum = 0.0;
    const std::vector<std::size_t> pixels = frame.asked();
    for (const std::size_t i : pixels) {
        const double error =
            static_cast<double>(image[i]) - expected(glm::dvec2(frame->gbuffer.position[i]));
        sum += error * error;
    }
    return std::sqrt(sum / static_cast<double>(pixels.size()));
}

/// Rectangles, each covering part of the light as it is seen from the middle of the floor z = 0.
struct Piece {
    Rect onLight;  ///< metres from the light's centre; half the light's side is 1
    double depthM;
};

TestFrame pieces(const std::vector<Piece>& all) {
    Shape shape;
    for (const Piece& piece : all) {
        const double towards = 1.0 - piece.depthM / kHeightM;
        shape.rectangle(piece.onLight.lo * towards, piece.onLight.hi * towards,
                        kHeightM - piece.depthM);
    }
    const AreaLight light = lightAbove(kHeightM, 2.0, 2.0);
    return {{shape.geometry(), light},
            planeGBuffer(3, 3, {-1e-3, -1e-3, 0.0}, {2e-3, 0, 0}, {0, 2e-3, 0}, light)};
}

float middleOf(const TestFrame& frame, const Assignments& settings) {
    return render(frame, "occlusion_textures", settings)[4];
}

// A kernel is at least a hundred texels wide in these set-ups, each edge off by up to half of one.
constexpr double kTexels = 0.015;

TEST_F(OcclusionTextures, OnePlaneParallelToTheLightIsExact) {
    const AreaLight light = lightAbove(5.0, 2.0, 1.0);
    const Rect lightRect{{-1.0, -0.5}, {1.0, 0.5}}, caster{{-0.4, -0.2}, {0.35, 0.6}};
    Shape shape;
    shape.rectangle(caster.lo, caster.hi, 2.0);
    const auto error = [&](int size, const Assignments& settings) {
        const TestFrame frame({shape.geometry(), light},
                              planeGBuffer(size, size, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, light));
        return rmse(frame, render(frame, "occlusion_textures", settings), [&](glm::dvec2 p) {
            return closed_form::rectangle(p, caster, 2.0, lightRect, 5.0);
        });
    };
    EXPECT_LE(error(512, {}), 0.01);
    for (const char* placement : {"uniform", "quantile"})
        for (const char* cells : {"1", "4"})
            EXPECT_LE(error(64, {{"placement", placement}, {"cells", cells}}), 0.01)
                << placement << ", " << cells;
    // Interpolated levels are no boxes: their profile differs from the box's by up to 0.06.
    for (const char* prefilter : {"n_buffers", "mipmap"})
        EXPECT_LE(error(64, {{"prefilter", prefilter}}), 0.03) << prefilter;
}

TEST_F(OcclusionTextures, NearSlicePlaneIsTheDeepestCaster) {
    // Projected to its slice's boundary the caster's penumbra is too narrow; snapping cures that.
    const TestFrame frame = HalfPlane{.heightM = 1.0}.frame(0.8, 0.8);
    const auto error = [&](const char* snap) {
        const double edge = HalfPlane{}.edgeM * 0.5;
        return rmse(frame,
                    render(frame, "occlusion_textures", bare({{"snap", snap}, {"slices", "3"}})),
                    [&](glm::dvec2 p) {
                        return closed_form::halfPlane(p.x, edge, 1.0, 0.8, HalfPlane::kLightM);
                    });
    };
    EXPECT_LT(error("true"), 0.01);
    EXPECT_GT(error("false"), 0.03);
}

TEST_F(OcclusionTextures, RulesAreExactWhereTheTableSaysAndWrongByWhatItPredicts) {
    // METHODS.md R2.10.
    const Rect half{{-1, -1}, {0, 1}}, quarter{{-1, -1}, {-0.5, 1}}, other{{0, -1}, {0.6, 1}},
        across{{-1, -1}, {1, 0.1}}, all{{-1.2, -1.2}, {1.2, 1.2}};
    struct Case {
        Rect a, b;
        double hiddenA, hiddenB;
    };
    std::map<std::string, Renderer> renderers;
    for (const Case& c : {Case{half, quarter, 0.5, 0.25}, Case{half, other, 0.5, 0.3},
                          Case{half, across, 0.5, 0.55}, Case{half, all, 0.5, 1.0}}) {
        const double product = c.hiddenA + c.hiddenB - c.hiddenA * c.hiddenB,
                     most = std::max(c.hiddenA, c.hiddenB),
                     sum = std::min(c.hiddenA + c.hiddenB, 1.0);
        // The rules do not ask which one is nearer.
        for (const bool swapped : {false, true}) {
            const TestFrame frame =
                pieces({{swapped ? c.b : c.a, 1.0}, {swapped ? c.a : c.b, 2.5}});
            for (const auto& [rule, hidden] :
                 {std::pair{"product", product},
                  {"max", most},
                  {"sum", sum},
                  {"mean", 0.5 * (most + sum)},
                  // With empty slices between them they are two surfaces.
                  {"continued", product}}) {
                Renderer& renderer = renderers
                                         .try_emplace(rule, frame, "occlusion_textures",
                                                      bare({{"combination", rule}}))
                                         .first->second;
                EXPECT_NEAR(renderer(frame)[4], 1.0 - hidden, kTexels) << rule << ' ' << c.hiddenB;
            }
        }
    }
}

TEST_F(OcclusionTextures, CellsTellHowSlicesOverlap) {
    // Nested, disjoint and crossing halves: the truth whatever the rule, for the edges lie between
    // the cells.
    for (const char* rule : {"continued", "product", "max", "sum", "mean"}) {
        const Assignments settings = bare({{"combination", rule}, {"cells", "4"}});
        const Rect left{{-1, -1}, {0, 1}};
        for (const auto& [other, lit] : {std::pair{Rect{{-1, -1}, {-0.5, 1}}, 0.5},
                                         {Rect{{0, -1}, {0.5, 1}}, 0.25},
                                         {Rect{{-1, -1}, {1, 0}}, 0.25}})
            EXPECT_NEAR(middleOf(pieces({{left, 1.0}, {other, 2.5}}), settings), lit, kTexels)
                << rule;
    }
}

/// A solid oblique wall as slicing sees it: n pieces, the k-th in slice k, that cover the light
/// side by side.
TestFrame staircase(int n) {
    std::vector<Piece> all;
    const double nearM = 1.0, sliceM = (kHeightM - nearM) / (n + 1);
    for (int k = 0; k < n; ++k)
        all.push_back({{{-1.0 + 2.0 * k / n, -1.5}, {-1.0 + 2.0 * (k + 1) / n, 1.5}},
                       nearM + sliceM * (k + (k > 0 ? 0.5 : 0.0))});
    return pieces(all);
}

TEST_F(OcclusionTextures, ProductLightsTheUmbraOfAnObliqueWall) {
    for (const int n : {2, 4, 8, 16}) {
        const TestFrame frame = staircase(n);
        const auto lit = [&](const char* rule) {
            return middleOf(
                frame,
                bare({{"combination", rule}, {"slices", std::to_string(n)}, {"map_size", "1024"}}));
        };
        const double one = 1.0 / n;
        // Of the n edges between pieces each adds or loses up to half a texel of some hundred.
        EXPECT_NEAR(lit("product"), std::pow(1.0 - one, n), 0.02) << n;
        EXPECT_NEAR(lit("max"), 1.0 - one, 0.02) << n;
        EXPECT_LT(lit("sum"), 0.02) << n;
        EXPECT_LT(lit("continued"), 0.02) << n;
    }
}

/// A sheet that leans over a floor, and points in its full shadow: every way from them to the light
/// passes it well inside its outline.
TestFrame leaningSheet() {
    Shape shape;
    shape.rectangle({-4.0, -4.0}, {4.0, 4.0}, 0.0);
    shape.quad({-3.0, -3.0, 0.6}, {3.0, -3.0, 2.9}, {3.0, 3.0, 2.9}, {-3.0, 3.0, 0.6});
    const AreaLight light = lightAbove(kHeightM, 1.0, 1.0);
    return {{shape.geometry(), light},
            planeGBuffer(64, 64, {-1.2, -1.2, 0.0}, {2.4, 0, 0}, {0, 2.4, 0}, light)};
}

double meanOf(const TestFrame& frame, const Assignments& settings) {
    double sum = 0.0;
    const Visibility image = render(frame, "occlusion_textures", settings);
    for (const float v : image) sum += static_cast<double>(v);
    return sum / static_cast<double>(image.size());
}

TEST_F(OcclusionTextures, FillingRemovesTheLeakOfThinCasters) {
    const TestFrame frame = leaningSheet();
    // The sum leaves nothing lit but the gaps between the pieces.
    const auto leak = [&](const char* thin) {
        return meanOf(frame, bare({{"combination", "sum"}, {"thin_casters", thin}}));
    };
    const double open = leak("none");
    EXPECT_GT(open, 1e-3);
    for (const char* thin : {"thin", "crossing", "all"}) EXPECT_LE(leak(thin), 0.1 * open) << thin;
    // The default leaves less than a tenth of what the paper's rule leaves without filling.
    EXPECT_LE(meanOf(frame, {}), 0.1 * meanOf(frame, bare({{"combination", "product"}})));
}

TEST_F(OcclusionTextures, PerspectiveLeaksLessThanOrthographic) {
    const TestFrame frame = leaningSheet();
    const auto leak = [&](const char* projection) {
        return meanOf(frame, bare({{"combination", "sum"}, {"projection", projection}}));
    };
    EXPECT_GT(leak("orthographic"), 1e-3);
    EXPECT_LT(leak("perspective"), 0.9 * leak("orthographic"));
}

TEST_F(OcclusionTextures, ReceiversCrossSlicesWithoutAJump) {
    // Points from the floor up to below the first caster, under the edges of three casters.
    Shape shape;
    shape.rectangle({0.1, -3.0}, {3.0, 3.0}, 2.6);
    shape.rectangle({0.0, -3.0}, {3.0, 3.0}, 1.5);
    shape.rectangle({-0.1, -3.0}, {3.0, 3.0}, 0.8);
    const AreaLight light = lightAbove(kHeightM, 1.0, 1.0);
    constexpr int kPoints = 4096;
    const TestFrame frame(
        {shape.geometry(), light},
        planeGBuffer(kPoints, 1, {0.0, -0.1, 0.0}, {0.25, 0.0, 2.5}, {0.0, 0.2, 0.0}, light));
    for (const char* rule : {"continued", "product", "mean"}) {
        const Visibility image =
            render(frame, "occlusion_textures", bare({{"combination", rule}, {"bias", "0"}}));
        // A slice fades over (4 - 1.4) / 17 metres, 250 points; three at most change at once, and
        // the kernels near a plane are a few texels wide, which pass within tens of points.
        float most = 0.0f;
        for (std::size_t i = 1; i < kPoints; ++i)
            most = std::max(most, std::abs(image[i] - image[i - 1]));
        EXPECT_LT(most, 0.05f) << rule;
        EXPECT_GT(std::abs(image[0] - image[kPoints - 1]), 0.2f) << "something must change";
    }
}

TEST_F(OcclusionTextures, CastersCrossSlicesWithoutAJump) {
    // One caster goes down through a slice's boundary below a higher one that holds the slices in
    // place. Snapped planes go with it.
    std::vector<float> lit;
    for (int step = 0; step <= 40; ++step) {
        const double depthM = 1.9 + 0.01 * step;
        lit.push_back(middleOf(
            pieces({{{{-1.0, -1.0}, {-0.9, 1.0}}, 0.6}, {{{0.1, -1.0}, {2.0, 1.0}}, depthM}}),
            bare({{"combination", "product"}})));
    }
    // The same part of the light is hidden at every depth.
    for (const float v : lit) EXPECT_NEAR(v, 0.95 * 0.55, kTexels);
}

TEST_F(OcclusionTextures, NothingAboveLeavesPointsLit) {
    // The receiver is nearer to the light than every caster, in the first slice or before it.
    const AreaLight light = lightAbove(kHeightM, 1.0, 1.0);
    Shape shape;
    shape.rectangle({-3.0, -3.0}, {3.0, 3.0}, 1.0);
    shape.rectangle({-4.0, -4.0}, {4.0, 4.0}, 0.0);
    const TestFrame frame(
        {shape.geometry(), light},
        stacked({planeGBuffer(32, 32, {-1, -1, 2.0}, {2, 0, 0}, {0, 2, 0}, light),
                 planeGBuffer(32, 32, {-1, -1, 1.0}, {2, 0, 0}, {0, 2, 0}, light),
                 planeGBuffer(32, 32, {-1, -1, 0.0}, {2, 0, 0}, {0, 2, 0}, light)}));
    for (const char* slices : {"1", "5", "16", "17", "64"}) {
        const Visibility image = render(frame, "occlusion_textures", {{"slices", slices}});
        const auto above = image.begin() + 2 * 32 * 32;
        EXPECT_TRUE(std::all_of(image.begin(), above, [](float v) { return v == 1.0f; })) << slices;
        // The last slice's fade ends at the farthest receiver, but for rounding.
        EXPECT_TRUE(std::all_of(above, image.end(), [](float v) { return v < 1e-6f; })) << slices;
    }
}

TEST_F(OcclusionTextures, SlopesOfAnySteepnessStayLit) {
    for (const double tiltDeg : {0.0, 30.0, 60.0, 75.0, 85.0})
        for (const char* projection : {"perspective", "orthographic"}) {
            const TestFrame frame = TiltedPlane{tiltDeg}.frame(0.3);
            EXPECT_EQ(
                violations(
                    frame, render(frame, "occlusion_textures", {{"projection", projection}}),
                    [](float v, std::size_t i) { return i >= TiltedPlane::kPixels || v == 1.0f; }),
                0)
                << tiltDeg << " degrees, " << projection;
        }
}

TEST_F(OcclusionTextures, LightWithoutExtentIsTheHardMap) {
    const Visibility hard = render(HalfPlane{}.frame(0.0, 0.0), "hard", {{"map_size", "512"}});
    EXPECT_EQ(render(HalfPlane{}.frame(0.0, 0.0), "occlusion_textures"), hard);
    EXPECT_EQ(
        render(HalfPlane{}.frame(0.8, 0.8), "occlusion_textures", {}, EffectChoice::parse("none")),
        hard);
    // Kernels of no more than a texel.
    const TestFrame narrow = HalfPlane{}.frame(1e-3, 1e-3);
    EXPECT_EQ(render(narrow, "occlusion_textures"), hard);
    // And a few texels wide: within the penumbra and half a texel of each map of the same edge.
    const TestFrame small = HalfPlane{}.frame(0.02, 0.02);
    const double reach = 0.01 / 3.0 + 2.0 * texelM(small, 0.0, 512, HalfPlane::kLightM);
    const Visibility image = render(small, "occlusion_textures");
    EXPECT_EQ(violations(small, image,
                         [&](float v, std::size_t i) {
                             return std::abs(HalfPlane{}.across(small, i) - HalfPlane{}.edgeM) <
                                        reach ||
                                    std::abs(v - hard[i]) < 1e-3f;
                         }),
              0);
}

}  // namespace
}  // namespace penumbra
