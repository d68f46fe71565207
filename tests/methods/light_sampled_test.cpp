#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/passes/light_maps.hpp"
#include "harness/reference/exact.hpp"
#include "tests/methods/test_worlds.hpp"
#include "tests/support/closed_forms.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra {
namespace {

using namespace test;

class LightSampled : public GlTest {};

/// Comparisons of single texels, whose visibilities are counts.
Assignments counting(Assignments others) {
    others.emplace_back("pcf", "false");
    return others;
}

/// The worst error of an image of `caster` under a light of `lightM`.
double worstError(const HalfPlane& caster, const TestFrame& frame, const Visibility& image,
                  double lightM) {
    const double casterEdgeM =
        caster.edgeM * (HalfPlane::kLightM - caster.heightM) / HalfPlane::kLightM;
    double worst = 0.0;
    for (const std::size_t i : frame.asked())
        worst = std::max(
            worst, std::abs(static_cast<double>(image[i]) -
                            closed_form::halfPlane(caster.across(frame, i), casterEdgeM,
                                                   caster.heightM, lightM, HalfPlane::kLightM)));
    return worst;
}

TEST_F(LightSampled, ValuesAreMultiplesOfOneMap) {
    const TestFrame frame = HalfPlane{}.frame(0.8, 0.8);
    for (const char* pattern : {"grid", "lattice", "jittered", "owen"})
        EXPECT_EQ(
            violations(
                frame,
                render(frame, "light_sampled", counting({{"samples", "25"}, {"pattern", pattern}})),
                [](float v, auto) { return std::abs(25.0f * v - std::round(25.0f * v)) < 1e-5f; }),
            0)
            << pattern;
}

TEST_F(LightSampled, DoublingTheSideHalvesTheWorstError) {
    // METHODS.md 11 and its midpoint counterpart: k columns of equal weight make steps of 1/k. From
    // corner to corner the truth at the first step is 0 and 1, so all of it is error; at cell
    // centres, and with the rim's weight halved in k - 1 intervals, half of it is.
    struct Rule {
        const char *pattern, *weights;
        double (*worst)(int columns);
    };
    const Rule rules[] = {{"lattice", "equal", [](int k) { return 1.0 / k; }},
                          {"lattice", "trapezoid", [](int k) { return 0.5 / (k - 1); }},
                          {"grid", "equal", [](int k) { return 0.5 / k; }}};
    constexpr double kLightM = 0.8;
    constexpr int kMapSize = 512, kAcross = 1024;
    const HalfPlane caster;
    // A third of the light wide; the penumbra spans a third of 1.6 metres.
    const double penumbraM = kLightM * caster.heightM / (HalfPlane::kLightM - caster.heightM);
    const World world = caster.world(kLightM, kLightM);
    const TestFrame frame(
        world, planeGBuffer(kAcross, 4, {-0.3, -0.3, 0.0}, {0.8, 0, 0}, {0, 0.6, 0}, world.light));
    for (const Rule& rule : rules)
        for (const int columns : {3, 5, 9, 17}) {
            const Visibility image =
                render(frame, "light_sampled",
                       counting({{"samples", std::to_string(columns * columns)},
                                 {"pattern", rule.pattern},
                                 {"weights", rule.weights},
                                 {"map_size", std::to_string(kMapSize)}}));
            // Each map's edge is off by half a texel at most, in a ramp of slope 1 / penumbraM; a
            // pixel lies within half a pixel of where the error is worst. The windows of all views
            // are as wide as the whole light's widest, 1.1 times that of the centre's.
            const double texel = 1.1 * texelM(frame, 0.0, kMapSize, HalfPlane::kLightM);
            const double tolerance = (0.51 * texel + 0.5 * 0.8 / kAcross) / penumbraM;
            EXPECT_NEAR(worstError(caster, frame, image, kLightM), rule.worst(columns), tolerance)
                << rule.pattern << ' ' << rule.weights << ' ' << columns;
        }
}

TEST_F(LightSampled, EdgesOfTheLatticeAreCountedOnce) {
    // Trapezoid weights sum to one full weight per cell: 16 of 25 maps' worth. The half plane's
    // profile then has steps of 1/8, 1/4, 1/4, 1/4, 1/8.
    const TestFrame frame = HalfPlane{}.frame(0.8, 0.8);
    const Visibility image =
        render(frame, "light_sampled",
               counting({{"samples", "25"}, {"pattern", "lattice"}, {"weights", "trapezoid"}}));
    EXPECT_EQ(violations(frame, image,
                         [](float v, auto) {
                             const float steps[] = {0.0f, 0.125f, 0.375f, 0.625f, 0.875f, 1.0f};
                             return std::ranges::any_of(
                                 steps, [&](float step) { return std::abs(v - step) < 1e-6f; });
                         }),
              0);
}

TEST_F(LightSampled, WeightsAreForLatticesOnly) {
    const TestFrame frame = HalfPlane{}.frame(0.8, 0.8);
    for (const char* pattern : {"grid", "jittered", "owen"})
        EXPECT_EQ(render(frame, "light_sampled", {{"pattern", pattern}, {"weights", "trapezoid"}}),
                  render(frame, "light_sampled", {{"pattern", pattern}}))
            << pattern;
}

TEST_F(LightSampled, RowsFollowTheLightsProportions) {
    // A linear light has one row: eight samples along x are eight steps of an edge across it and
    // none of an edge along it.
    for (const int axis : {0, 1}) {
        HalfPlane caster;
        caster.axis = axis;
        const TestFrame frame = caster.frame(0.8, 0.0);
        const Visibility image = render(frame, "light_sampled", counting({{"samples", "8"}}));
        std::vector<float> values;
        for (const std::size_t i : frame.asked()) values.push_back(image[i]);
        std::ranges::sort(values);
        values.erase(std::unique(values.begin(), values.end()), values.end());
        EXPECT_EQ(values.size(), axis == 0 ? 9u : 2u);
    }
}

TEST_F(LightSampled, ArrayAndBufferAgreeBitForBit) {
    const TestFrame frame = HalfPlane{}.frame(0.8, 0.6);
    for (const char* pattern : {"lattice", "owen"})
        for (const char* pcf : {"false", "true"}) {
            const Assignments settings = {
                {"samples", "20"}, {"pattern", pattern}, {"weights", "trapezoid"}, {"pcf", pcf}};
            Assignments buffered = settings;
            buffered.emplace_back("accumulation", "buffer");
            EXPECT_EQ(render(frame, "light_sampled", buffered),
                      render(frame, "light_sampled", settings))
                << pattern << ", pcf " << pcf;
        }
}

TEST_F(LightSampled, MoreMapsThanAnArrayHoldsAddUpToTheSame) {
    // 300 samples exceed the 256 of one array: two passes against one map at a time.
    const TestFrame frame = HalfPlane{}.frame(0.8, 0.8, 48);
    ASSERT_LT(LightMaps::kMaxSamples, 300u);
    const Assignments settings = {{"samples", "300"}, {"map_size", "64"}, {"pattern", "owen"}};
    Assignments buffered = settings;
    buffered.emplace_back("accumulation", "buffer");
    EXPECT_EQ(render(frame, "light_sampled", settings), render(frame, "light_sampled", buffered));
}

TEST_F(LightSampled, OrderOfTheSamplesDoesNotMatter) {
    const TestFrame frame = HalfPlane{}.frame(0.8, 0.8);
    std::vector<LightSample> samples;
    for (int i = 0; i < 25; ++i)
        samples.push_back({{0.16 * (i % 5 - 2), 0.16 * (i / 5 - 2)}, i % 3 == 0 ? 4.0f : 1.0f});
    const gl::Program program =
        gl::Program::graphics("light_sampled.glsl", {"PASS_ALL", "LIGHT_MAPS_PCF"});
    LightMaps maps(Plan{}, MapParts::all, 2);
    maps.fit(*frame, 256);
    const auto image = [&] {
        maps.render(*frame, samples);
        program.use();
        maps.bind(program);
        program.set("biasTexels", 0.5f);
        const TextureTarget target(frame->width(), frame->height());
        target.draw(program, frame->gbufferTextures);
        return target.read();
    };
    const Visibility inOrder = image();
    std::ranges::reverse(samples);
    EXPECT_EQ(image(), inOrder);
    std::ranges::rotate(samples, samples.begin() + 7);
    EXPECT_EQ(image(), inOrder);
}

TEST_F(LightSampled, WithoutExtentItIsTheHardMap) {
    const TestFrame point = HalfPlane{}.frame(0.0, 0.0);
    EXPECT_EQ(render(point, "light_sampled", {{"map_size", "256"}}),
              render(point, "hard", {{"map_size", "256"}}));
    const TestFrame wide = HalfPlane{}.frame(0.8, 0.8);
    EXPECT_EQ(render(wide, "light_sampled", {{"map_size", "256"}}, EffectChoice::parse("none")),
              render(wide, "hard", {{"map_size", "256"}}, EffectChoice::parse("none")));
}

TEST_F(LightSampled, UnoccludedPlanesOfAnySlopeDoNotShadowThemselves) {
    for (const double tiltDeg : {0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0})
        for (const char* pcf : {"false", "true"})
            for (const char* mapSize : {"64", "512"}) {
                const TestFrame frame = TiltedPlane{tiltDeg}.frame(0.1);
                EXPECT_EQ(violations(
                              frame,
                              render(frame, "light_sampled",
                                     {{"pcf", pcf}, {"map_size", mapSize}, {"pattern", "lattice"}}),
                              [&](float v, std::size_t i) {
                                  return i >= TiltedPlane::kPixels || v == 1.0f ||
                                         frame->gbuffer.mask[i] != PixelClass::scored;
                              }),
                          0)
                    << tiltDeg << " degrees, pcf " << pcf << ", map of " << mapSize;
            }
}

TEST_F(LightSampled, LightPointsBelowTheHorizonGiveNothing) {
    // A wall through x = 0 facing +x under a light from x = -0.4 to 0.4: half of the columns are
    // behind it, and it hides them itself.
    Shape shape;
    shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, -1.0);
    shape.quad({0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1});
    const AreaLight light = lightAbove(2.0, 0.8, 0.8);
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(32, 32, {0, -0.5, 0}, {0, 1, 0}, {0, 0, 0.9}, light));
    ASSERT_EQ(frame->gbuffer.count(PixelClass::horizon), frame->gbuffer.size());
    EXPECT_EQ(unequal(frame, render(frame, "light_sampled"), 0.5f), 0);
}

TEST_F(LightSampled, ConvergesToTheExactVisibility) {
    // Boxes over a plate and over each other. Banding falls with the columns, sqrt n: a factor of 4
    // from 4 to 64 maps, but for the share of the maps' texels.
    Shape shape;
    shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    shape.box({-0.4, -0.3, 0.3}, {0.1, 0.2, 0.5});
    shape.box({-0.1, -0.1, 0.8}, {0.3, 0.4, 0.9});
    const AreaLight light = lightAbove(2.0, 0.5, 0.4);
    const World world{shape.geometry(), light};
    const TestFrame frame(world,
                          planeGBuffer(64, 64, {-0.9, -0.9, 0.0}, {1.8, 0, 0}, {0, 1.8, 0}, light));
    const Reference exact = exactReference(frame->tracer, world.materials, frame->gbuffer, light);
    const auto rmse = [&](const char* samples) {
        const Visibility image =
            render(frame, "light_sampled", {{"samples", samples}, {"map_size", "1024"}});
        double sum = 0.0;
        for (const std::size_t i : frame.asked())
            sum += std::pow(image[i] - exact.visibility[i], 2.0);
        return std::sqrt(sum / static_cast<double>(frame.asked().size()));
    };
    const double four = rmse("4"), sixteen = rmse("16"), sixtyFour = rmse("64");
    EXPECT_LT(sixteen, 0.6 * four);
    EXPECT_LT(sixtyFour, 0.6 * sixteen);
    // Half plane of 8 columns: errors even in +-1/16 across penumbrae, rms 1/16/sqrt 3, over about
    // a half of the pixels.
    EXPECT_LT(sixtyFour, 1.0 / 16 / std::sqrt(3.0));
}

TEST_F(LightSampled, EveryMapsBiasMovesItsContact) {
    // The known failure. A panel stands on the floor at x = 0, the light's points all to its left:
    // every map's shadow begins as far from the foot as its bias lifts the receiver, and the sum of
    // n starts is a soft one: lit at the foot, dark beyond the farthest start.
    AreaLight light = lightAbove(2.0, 0.8, 0.8);
    light.centre.x = -2.0;
    Shape shape;
    shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    shape.quad({0, -2, 0}, {0, 2, 0}, {0, 2, 1}, {0, -2, 1});
    const World world{shape.geometry(), light};
    const TestFrame frame(world,
                          planeGBuffer(256, 8, {0.0, -0.1, 0.0}, {0.4, 0, 0}, {0, 0.2, 0}, light));
    constexpr double kBias = 16.0;
    constexpr int kMapSize = 512;
    const LightTile tile = TranslatedViews(*frame, kMapSize).from(glm::dvec2(0.0)).tiles[0];
    const double footprint = std::max(tile.tangentSize().x, tile.tangentSize().y) / kMapSize;
    const Visibility image = render(
        frame, "light_sampled", counting({{"bias", std::to_string(kBias)}, {"map_size", "512"}}));
    // Compared at a depth less by the factor 1 + b, the receiver at x seems to stand 2 b / (1 + b)
    // high; the ray from light point q to it passes the panel, x / (x - q) of its way to q, at the
    // height 2 x / (x - q). It is shadowed where that is more: x > b (x - q) / (1 + b), x > -b q.
    const double b = kBias * footprint;
    const double nearest = b * 1.7, farthest = b * 2.3;  // grid columns from -2.3 to -1.7
    const double reach = 0.51 * footprint * 2.0;
    double first = 1e9, last = -1e9;  // shadow of any, of all maps
    for (const std::size_t i : frame.asked()) {
        const double x = frame->gbuffer.position[i].x;
        if (image[i] < 1.0f) first = std::min(first, x);
        if (image[i] > 0.0f) last = std::max(last, x);
    }
    constexpr double kPixelM = 0.4 / 256;
    EXPECT_NEAR(first, nearest, reach + kPixelM);
    EXPECT_NEAR(last, farthest, reach + kPixelM);
}

}  // namespace
}  // namespace penumbra
