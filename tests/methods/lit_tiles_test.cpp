#include "core/frame/lit_tiles.hpp"

#include <random>

#include "core/frame/shadow_casters.hpp"
#include "core/gl/work_counter.hpp"
#include "tests/methods/test_worlds.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra {
namespace {

using namespace test;

/// What a plan saves in methods that sample the light: triangles that no map shows, and tiles that
/// nothing can shadow. `all` saves nothing, and the images are the same.
class SampledPlans : public GlTest {};

const char* const kMethods[] = {"light_sampled", "adaptive_light_sampled", "ray_traced"};
const EffectChoice kAll = EffectChoice::parse("all");

/// A floor, spheres at many heights and a panel that leans on the floor, seen from the side.
TestFrame spheres(double lightM, int size) {
    Shape floor, balls, panel;
    floor.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    for (int i = 0; i < 12; ++i) {
        const glm::dvec2 at(std::sin(2.4 * i) * 0.08 * i, std::cos(2.4 * i) * 0.08 * i);
        balls.sphere({at, 0.1 + 0.09 * i}, 0.12, 12);
    }
    panel.quad({-1.0, 0.6, 0.0}, {1.0, 0.6, 0.0}, {1.0, 1.2, 0.8}, {-1.0, 1.2, 0.8});
    World world{joined({{floor, 0}, {balls, 0}, {panel, 0}}),
                lightAbove(3.0, lightM, 0.5 * lightM)};
    world.camera = lookingAt({1.5, -2.5, 2.5}, {0.0, 0.1, 0.2});
    return {world, size};
}

/// Wires of a tenth of a millimetre, far less than a texel, in all directions over a floor.
TestFrame wires(double lightM) {
    Shape floor, thin;
    floor.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-0.8, 0.8), height(0.01, 1.9);
    for (int i = 0; i < 12; ++i) {
        const glm::dvec3 a(place(random), place(random), height(random));
        const glm::dvec3 b(place(random), place(random), height(random));
        thin.triangle(a, b, a + glm::dvec3(1e-4, 1e-4, 0.0));
    }
    const World world{joined({{floor, 0}, {thin, 0}}), lightAbove(2.0, lightM, lightM)};
    return {world, planeGBuffer(96, 96, {-0.8, -0.8, 0}, {1.6, 0, 0}, {0, 1.6, 0}, world.light)};
}

int changedByPlan(const TestFrame& frame, const char* id, const Assignments& settings) {
    const Visibility all = render(frame, id, settings, kAll);
    return violations(frame, render(frame, id, settings),
                      [&](float v, std::size_t i) { return v == all[i]; });
}

/// Of a method's build or its shade.
struct Work {
    gl::Work build, shade;
};
Work workOf(const TestFrame& frame, const char* id, const EffectChoice& effects) {
    const auto method = findMethod(id).make();
    const Plan plan = planFor(effects, frame.calledFor(), method->traits().simulates);
    method->prepare(frame->scene, plan);
    const TextureTarget target(frame->width(), frame->height());
    Work work;
    {
        gl::WorkCounter counter;
        method->build(*frame, plan);
        work.build = counter.stop();
    }
    gl::WorkCounter counter;
    method->shade(*frame, plan, target);
    work.shade = counter.stop();
    return work;
}

TEST_F(SampledPlans, LitTilesAreWhatRaysSayAndMostOfIt) {
    for (const double lightM : {0.02, 0.3, 0.9}) {
        const TestFrame frame = spheres(lightM, 126);  // no multiple of a tile
        LitTiles tiles;
        tiles.build(*frame, shadowCasters(*frame, {}));
        tiles.find(*frame, {frame->light.halfU, frame->light.halfV}, glm::dvec2(0.0));
        EXPECT_TRUE(tiles.isFor(frame->camera));
        const Visibility traced = render(frame, "ray_traced", {{"rays", "64"}}, kAll);
        const auto isLit = [&](std::size_t i) {
            const int x = static_cast<int>(i) % frame->width(),
                      y = static_cast<int>(i) / frame->width();
            return tiles.isLit(x / LitTiles::kSide, y / LitTiles::kSide);
        };
        EXPECT_EQ(violations(frame, traced,
                             [&](float v, std::size_t i) { return !isLit(i) || v == 1.0f; }),
                  0)
            << lightM;
        const auto full = violations(frame, traced, [](float v, auto) { return v != 1.0f; });
        const auto found =
            violations(frame, traced, [&](float, std::size_t i) { return !isLit(i); });
        // The rest is in tiles that a shadow's rim crosses: where the lit region is 20 tiles
        // across and twice as long around as a square, a fifth.
        EXPECT_GT(found, 0.7 * full) << lightM;
    }
}

TEST_F(SampledPlans, NothingChangesButTheWork) {
    const TestFrame frame = spheres(0.4, 126);
    for (const char* id : kMethods) EXPECT_EQ(changedByPlan(frame, id, {}), 0) << id;
    EXPECT_EQ(changedByPlan(frame, "light_sampled", {{"pcf", "true"}, {"map_size", "128"}}), 0);
    EXPECT_EQ(changedByPlan(frame, "light_sampled", {{"accumulation", "buffer"}}), 0);
    for (const char* pcf : {"2x2", "3x3", "5x5"})
        EXPECT_EQ(
            changedByPlan(frame, "adaptive_light_sampled", {{"pcf", pcf}, {"map_size", "128"}}), 0)
            << pcf;
}

TEST_F(SampledPlans, WiresThinnerThanATexelAreNotLost) {
    for (const double lightM : {0.05, 0.15}) {
        const TestFrame frame = wires(lightM);
        for (const char* id : kMethods) {
            EXPECT_EQ(changedByPlan(frame, id, {}), 0) << id << ' ' << lightM;
            EXPECT_GT(violations(frame, render(frame, id), [](float v, auto) { return v == 1.0f; }),
                      0)
                << id;
        }
        // One pass over all pixels; or one over those of undecided tiles, and that for the answers.
        for (const char* id : {"light_sampled", "adaptive_light_sampled"}) {
            const gl::Work all = workOf(frame, id, kAll).shade, some = workOf(frame, id, {}).shade;
            EXPECT_EQ(all.drawCalls, 1u) << id;
            EXPECT_EQ(some.drawCalls, 2u) << id;
            EXPECT_LT(some.fragments, all.fragments + frame->gbuffer.size()) << id;
        }
    }
}

TEST_F(SampledPlans, FacesTurnedAwayFromTheLightAreNotDrawn) {
    // Of the triangles of a ball under a light less than half face some of it; its floor and the
    // sheet beside it, which are open, are drawn from both sides.
    Shape floor, ball, sheet;
    floor.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    // Away from 0, so that rounding closes its seam and its poles.
    ball.sphere({0.1, 0.1, 0.8}, 0.3, 24);
    sheet.quad({0.5, -0.5, 0.5}, {0.5, 0.5, 0.5}, {0.8, 0.5, 0.5}, {0.8, -0.5, 0.5});
    const AreaLight light = lightAbove(3.0, 0.4, 0.4);
    const GBuffer points = planeGBuffer(64, 64, {-0.9, -0.9, 0}, {1.8, 0, 0}, {0, 1.8, 0}, light);
    const TestFrame frame({joined({{floor, 0}, {ball, 0}, {sheet, 0}}), light}, points);
    const Geometry casters = shadowCasters(*frame, {});
    ASSERT_EQ(casters.parts.size(), 3u);
    EXPECT_EQ(casters.parts[0].indexCount, 6u);
    EXPECT_EQ(casters.parts[2].indexCount, 6u);
    const double kept =
        static_cast<double>(casters.parts[1].indexCount) / frame->geometry->parts[1].indexCount;
    EXPECT_LT(kept, 0.55);
    EXPECT_GT(kept, 0.35);
    for (const char* id : {"light_sampled", "adaptive_light_sampled"}) {
        EXPECT_EQ(changedByPlan(frame, id, {}), 0) << id;
        EXPECT_LT(static_cast<double>(workOf(frame, id, {}).build.triangles),
                  0.6 * static_cast<double>(workOf(frame, id, kAll).build.triangles))
            << id;
    }
    // Turned inside out it is the same ball.
    Geometry turned = *frame->geometry;
    for (std::size_t i = turned.parts[1].firstIndex; i < turned.parts[2].firstIndex; i += 3)
        std::swap(turned.indices[i], turned.indices[i + 1]);
    const TestFrame inverted({std::make_shared<const Geometry>(turned), light}, points);
    EXPECT_EQ(shadowCasters(*inverted, {}).parts[1].indexCount, casters.parts[1].indexCount);
    EXPECT_EQ(changedByPlan(inverted, "light_sampled", {}), 0);
}

TEST_F(SampledPlans, ABodyAroundTheLightKeepsBothSides) {
    // A closed room around light and floor: its walls face away from the light, and none hides
    // anything; a lamp's shade around the light does.
    Shape floor, shade;
    floor.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    shade.box({-0.5, -0.5, 1.5}, {0.5, 0.5, 2.5});
    const AreaLight light = lightAbove(2.0, 0.4, 0.4);
    const TestFrame frame({joined({{floor, 0}, {shade, 0}}), light},
                          planeGBuffer(32, 32, {-0.5, -0.5, 0}, {1.0, 0, 0}, {0, 1.0, 0}, light));
    for (const char* id : kMethods) EXPECT_EQ(unequal(frame, render(frame, id), 0.0f), 0) << id;
}

TEST_F(SampledPlans, WhatIsBesideAllLightRaysIsNotDrawn) {
    Shape floor, beside, above;
    floor.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    beside.sphere({3.0, 0.0, 1.0}, 0.3, 12);
    above.sphere({0.0, 0.0, 2.6}, 0.3, 12);
    const AreaLight light = lightAbove(2.0, 0.4, 0.4);
    const TestFrame frame({joined({{floor, 0}, {beside, 0}, {above, 0}}), light},
                          planeGBuffer(32, 32, {-0.5, -0.5, 0}, {1.0, 0, 0}, {0, 1.0, 0}, light));
    const Geometry casters = shadowCasters(*frame, {});
    EXPECT_EQ(casters.parts[0].indexCount, 6u);
    EXPECT_EQ(casters.parts[1].indexCount, 0u);
    EXPECT_EQ(casters.parts[2].indexCount, 0u);
}

TEST_F(SampledPlans, PartsThatCastNothingAreLeftOutWhereAsked) {
    Shape floor, ball;
    floor.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    ball.sphere({0.0, 0.0, 0.8}, 0.3, 12);
    const AreaLight light = lightAbove(2.0, 0.4, 0.4);
    const TestFrame made({joined({{floor, 0}, {ball, 0}}), light},
                         planeGBuffer(32, 32, {-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0}, light));
    Frame frame = *made;
    frame.casterFacts.parts[0].casts = false;
    EXPECT_EQ(shadowCasters(frame, {.onlyCasting = true}).parts[0].indexCount, 0u);
    EXPECT_GT(shadowCasters(frame, {.onlyCasting = true}).parts[1].indexCount, 0u);
    EXPECT_EQ(shadowCasters(frame, {.onlyCasting = false}).parts[0].indexCount, 6u);
}

TEST_F(SampledPlans, WithoutPenumbraThereIsOneMapAndNothingBesides) {
    const TestFrame frame = HalfPlane{}.frame(0.8, 0.8);
    for (const char* id : {"light_sampled", "adaptive_light_sampled"}) {
        const auto method = findMethod(id).make();
        const Plan plan =
            planFor(EffectChoice::parse("none"), frame.calledFor(), method->traits().simulates);
        method->prepare(frame->scene, plan);
        const TextureTarget target(frame->width(), frame->height());
        gl::WorkCounter counter;
        method->build(*frame, plan);
        method->shade(*frame, plan, target);
        EXPECT_EQ(counter.stop().drawCalls, 2u) << id;
        const WorkCounters counters = method->counters();
        EXPECT_EQ(counters.maps, 1) << id;
        EXPECT_EQ(counters.lightTexels, 512.0 * 512.0) << id;
        EXPECT_EQ(counters.textureMib, 1.0) << id;
    }
}

TEST_F(SampledPlans, TilesFollowACameraThatMovesAlone) {
    // build is for what light space depends on, which a camera alone may leave as it is.
    const TestFrame before = spheres(0.4, 64);
    World world{before->geometry, before->light};
    world.camera = lookingAt({-1.5, -2.0, 2.0}, {0.2, 0.0, 0.2});
    const TestFrame after(world, 64);
    const Frame moved{after->scene,           1,
                      after->light,           before->lightBounds,
                      after->camera,          after->geometry,
                      after->tracer,          after->gbuffer,
                      after->gbufferTextures, after->gpuGeometry,
                      after->casterFacts,     after->seed};
    const TextureTarget target(moved.width(), moved.height());
    for (const char* id : kMethods) {
        const auto image = [&](const Frame& builtFor) {
            const auto method = findMethod(id).make();
            const Plan plan = planFor({}, after.calledFor(), method->traits().simulates);
            method->prepare(builtFor.scene, plan);
            method->build(builtFor, plan);
            method->shade(moved, plan, target);
            return target.read();
        };
        EXPECT_EQ(image(*before), image(moved)) << id;
    }
}

}  // namespace
}  // namespace penumbra
