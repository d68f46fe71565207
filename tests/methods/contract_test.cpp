// What every registered method promises, whatever it computes (methods/shadow_method.hpp).

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "core/frame/light_centre.hpp"
#include "harness/run/settings.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/render.hpp"

namespace penumbra {
namespace {

using namespace test;

// Filters of statistics approach 0 without reaching it; less than half a step of an eight-bit image
// is black to anyone who looks.
constexpr float kBlack = 1.0f / 512.0f;

AreaLight lightAt(const glm::dvec3& centre, double halfU, double halfV) {
    AreaLight light = lightAbove(0.0, 2.0 * halfU, 2.0 * halfV);
    light.centre = centre;
    return light;
}

/// A box over a plate, seen from above and beside: all classes of pixels.
World boxOverPlate(const glm::dvec3& lightCentre = {0.1, 0.2, 2.0}, double halfU = 0.25,
                   double halfV = 0.15) {
    Shape shape;
    shape.box({-1.0, -1.0, -0.1}, {1.0, 1.0, 0.0});
    shape.box({-0.3, -0.2, 0.4}, {0.2, 0.3, 0.7});
    World world{shape.geometry(), lightAt(lightCentre, halfU, halfV)};
    world.camera = lookingAt({1.2, -2.2, 2.6}, {0.0, 0.0, 0.1});
    return world;
}

World plateOnly() {
    Shape shape;
    shape.box({-1.0, -1.0, -0.1}, {1.0, 1.0, 0.0});
    World world{shape.geometry(), lightAt({0.0, 0.0, 2.0}, 0.25, 0.15)};
    world.camera = boxOverPlate().camera;
    return world;
}

/// A room of 4 x 4 x 3 metres around the origin of the floor, a light of 0.4 metres in it.
Shape roomShape() {
    Shape shape;
    shape.box({-2.1, -2.1, -0.1}, {2.1, 2.1, 0.0});
    shape.box({-2.1, -2.1, 3.0}, {2.1, 2.1, 3.1});
    shape.box({2.0, -2.0, 0.0}, {2.1, 2.0, 3.0});
    shape.box({-2.1, -2.0, 0.0}, {-2.0, 2.0, 3.0});
    shape.box({-2.1, 2.0, 0.0}, {2.1, 2.1, 3.0});
    shape.box({-2.1, -2.1, 0.0}, {2.1, -2.0, 3.0});
    return shape;
}

AreaLight roomLight() {
    return lightAt({0.0, 0.0, 2.7}, 0.2, 0.2);
}

class Contract : public GlTest, public ::testing::WithParamInterface<std::string> {
  protected:
    const std::string& id() const { return GetParam(); }
};

INSTANTIATE_TEST_SUITE_P(Methods, Contract, ::testing::ValuesIn([] {
                             std::vector<std::string> ids;
                             for (const MethodInfo& method : methodRegistry())
                                 ids.push_back(method.id);
                             return ids;
                         }()),
                         [](const auto& method) { return method.param; });

TEST_P(Contract, AnswersForEveryPixelWithinRange) {
    const TestFrame frame(boxOverPlate(), 96);
    ASSERT_GT(frame->gbuffer.count(PixelClass::horizon), 0u);
    EXPECT_EQ(outOfRange(frame, render(frame, id())), 0);
}

TEST_P(Contract, EveryPlanIsWithinRange) {
    const TestFrame frame(boxOverPlate(), 48);
    for (const char* effects : {"none", "all", "penumbra", "alpha_mask"})
        EXPECT_EQ(outOfRange(frame, render(frame, id(), {}, EffectChoice::parse(effects))), 0)
            << effects;
}

TEST_P(Contract, NoCasterLeavesAllLit) {
    const TestFrame frame(plateOnly(), 96);
    EXPECT_EQ(unequal(frame, render(frame, id()), 1.0f), 0);
}

TEST_P(Contract, FullUmbraIsBlack) {
    // Every way from these points to the light is barred by a slab much wider than either.
    Shape shape;
    shape.rectangle({-0.5, -0.5}, {0.5, 0.5}, 0.0);
    shape.box({-3.0, -3.0, 0.5}, {3.0, 3.0, 0.6});
    const World world{shape.geometry(), lightAt({0.0, 0.0, 2.0}, 0.25, 0.15)};
    const TestFrame frame(
        world, planeGBuffer(64, 64, {-0.5, -0.5, 0.0}, {1, 0, 0}, {0, 1, 0}, world.light));
    EXPECT_EQ(violations(frame, render(frame, id()),
                         [](float v, std::size_t) { return v >= 0.0f && v <= kBlack; }),
              0);
}

TEST_P(Contract, SameSeedGivesTheSameImage) {
    const TestFrame frame(boxOverPlate(), 64);
    Renderer renderer(frame, id());
    const Visibility first = renderer(frame);
    EXPECT_EQ(renderer(frame), first) << "the same instance again";
    EXPECT_EQ(render(frame, id()), first) << "another instance";
}

TEST_P(Contract, EveryExtremeOfEveryParameterIsWithinRange) {
    // 16 x 16 pixels keep the extremes of sample counts short. Sizes in texels stop at 4096: the
    // greatest, 16384 squared, is a GiB per map, whose size says nothing that 4096 squared does
    // not.
    constexpr double kMostTexels = 4096.0;
    const TestFrame frame(boxOverPlate(), 16);
    const auto method = findMethod(id()).make();
    for (const Parameter* parameter : method->parameters())
        for (std::string value : parameter->extremes()) {
            if (parameter->unit() == "texels" && std::stod(value) > kMostTexels)
                value = fmt::format("{}", kMostTexels);
            EXPECT_EQ(outOfRange(frame, render(frame, id(), {{parameter->id(), value}})), 0)
                << parameter->id() << '=' << value;
        }
}

TEST_P(Contract, LadderHasDistinctSettingsThatRun) {
    const TestFrame frame(boxOverPlate(), 32);
    const std::size_t rungs = findMethod(id()).make()->ladder().size();
    ASSERT_GT(rungs, 0u);
    const std::vector<Setting> settings = expandSettings({{id()}, {}, {}, true});
    EXPECT_EQ(settings.size(), rungs) << "two rungs are one setting";
    for (const Setting& setting : settings)
        EXPECT_EQ(outOfRange(frame, render(frame, id(), setting.assignments)), 0) << setting.params;
}

TEST_P(Contract, PointLightIsTheHardLimitInEveryQuadrant) {
    // Two centimetres: a texel of a map of 128 texels. One instance follows the light around.
    constexpr double kEdgeM = 0.02;
    std::unique_ptr<Renderer> renderer;
    for (const glm::dvec2 place :
         {glm::dvec2(0.0, 0.0), glm::dvec2(0.6, 0.5), glm::dvec2(-0.6, 0.5), glm::dvec2(-0.6, -0.5),
          glm::dvec2(0.6, -0.5)}) {
        const TestFrame frame(boxOverPlate({place, 2.0}, 0.0, 0.0), 96);
        if (!renderer) renderer = std::make_unique<Renderer>(frame, id());
        const Visibility image = (*renderer)(frame);
        EXPECT_EQ(violations(frame, image, [](float v, auto) { return v == 0.0f || v == 1.0f; }),
                  0);
        int certain = 0, shadowed = 0;
        const int wrong = violations(frame, image, [&](float v, std::size_t i) {
            const std::optional<bool> seen = centreSeen(*frame, i, kEdgeM);
            certain += seen.has_value();
            shadowed += seen.has_value() && !*seen;
            return !seen || v == (*seen ? 1.0f : 0.0f);
        });
        EXPECT_EQ(wrong, 0) << "light at " << place.x << ", " << place.y;
        EXPECT_GT(certain, 0.8 * static_cast<double>(frame.asked().size()));
        EXPECT_GT(shadowed, 50);
    }
}

TEST_P(Contract, TinyLightIsAPointLight) {
    const Visibility point = render(TestFrame(boxOverPlate({0.1, 0.2, 2.0}, 0.0, 0.0), 96), id());
    const TestFrame frame(boxOverPlate({0.1, 0.2, 2.0}, 1e-7, 1e-7), 96);
    const Visibility tiny = render(frame, id());
    // Pixels whose ray grazes an edge may fall on either side of it: none to be expected among
    // 9000 that lie millimetres apart, five are let pass.
    EXPECT_LE(
        violations(frame, tiny,
                   [&](float v, std::size_t i) { return std::abs(v - point[i]) <= 1 / 255.0; }),
        5);
}

TEST_P(Contract, StateLeftByOthersDoesNotMatter) {
    const TestFrame frame(boxOverPlate(), 64);
    const Visibility image = render(frame, id());
    const auto all = [](const auto& set) {
        for (const GLenum capability : {GL_BLEND, GL_CULL_FACE, GL_DEPTH_CLAMP, GL_DEPTH_TEST,
                                        GL_POLYGON_OFFSET_FILL, GL_SCISSOR_TEST})
            set(capability);
    };
    all(glEnable);
    glBlendFunc(GL_ZERO, GL_ZERO);
    glCullFace(GL_FRONT_AND_BACK);
    glDepthFunc(GL_NEVER);
    glDepthMask(GL_FALSE);
    glPolygonOffset(100.0f, 100.0f);
    glScissor(3, 3, 1, 1);
    glViewport(0, 0, 7, 7);
    EXPECT_EQ(render(frame, id()), image);
    all(glDisable);
    glDepthMask(GL_TRUE);
    glPolygonOffset(0.0f, 0.0f);
}

TEST_P(Contract, MovingLightLeavesNothingBehind) {
    const TestFrame before(boxOverPlate({0.6, 0.5, 2.0}), 64), after(boxOverPlate(), 64);
    Renderer renderer(before, id());
    renderer(before);
    EXPECT_EQ(renderer(after), render(after, id()));
}

// Where a camera moves alone, maps are kept: they are of receivers and casters, not of who looks.
TEST_P(Contract, ACameraThatMovesAloneMayKeepWhatWasBuilt) {
    Shape shape;
    shape.box({-1.0, -1.0, -0.1}, {1.0, 1.0, 0.0});
    for (int i = 0; i < 5; ++i) {
        const glm::dvec3 corner(0.35 * i - 0.9, 0.3 * i - 0.8, 0.3 * i + 0.02);
        shape.box(corner, corner + glm::dvec3(0.3, 0.25, 0.1));
    }
    World world{shape.geometry(), lightAt({0.1, 0.2, 2.5}, 0.25, 0.15)};
    world.camera = lookingAt({1.2, -2.2, 2.6}, {0.0, 0.0, 0.1});
    const TestFrame before(world, 64);
    world.camera = lookingAt({0.2, 0.8, 1.9}, {0.4, 0.4, 0.9});
    const TestFrame after(world, 64);
    const Frame moved{after->scene,           1,
                      after->light,           before->lightBounds,
                      after->camera,          after->geometry,
                      after->tracer,          after->gbuffer,
                      after->gbufferTextures, after->gpuGeometry,
                      after->casterFacts,     after->seed};
    const TextureTarget target(moved.width(), moved.height());
    const auto method = findMethod(id()).make();
    const Plan plan = planFor({}, after.calledFor(), method->traits().simulates);
    const auto shaded = [&] {
        method->shade(moved, plan, target);
        return target.read();
    };
    method->prepare(before->scene, plan);
    method->build(moved, plan);
    const Visibility built = shaded();
    method->build(*before, plan);
    EXPECT_EQ(shaded(), built);
    method->forgetCamera();
    EXPECT_EQ(shaded(), built);
}

TEST_P(Contract, ScaleDoesNotMatter) {
    const TestFrame frame(boxOverPlate(), 64);
    const Visibility image = render(frame, id());
    // Powers of two change no digit of any float, so no digit of the answer either.
    for (const double factor : {1024.0, 1.0 / 1024.0})
        EXPECT_EQ(render(TestFrame(scaled(boxOverPlate(), factor), 64), id()), image) << factor;
    // Otherwise all coordinates round anew, which turns comparisons within 1e-7 of equality: a
    // handful of the 4096 pixels lie so close to an edge.
    for (const double factor : {1000.0, 1.0 / 1000.0}) {
        const TestFrame other(scaled(boxOverPlate(), factor), 64);
        const Visibility otherImage = render(other, id());
        EXPECT_LE(
            violations(frame, image,
                       [&](float v, std::size_t i) { return std::abs(v - otherImage[i]) < 1e-3; }),
            8)
            << factor;
    }
}

TEST_P(Contract, PlaceInTheWorldDoesNotMatter) {
    World far = boxOverPlate();
    far.origin = {1e5, -3e5, 2e5};
    EXPECT_EQ(render(TestFrame(far, 64), id()), render(TestFrame(boxOverPlate(), 64), id()));
}

TEST_P(Contract, ReceiversBesideTheLightAreLit) {
    // Up to 5 centimetres below the light's plane, 88 degrees off its normal. Ten centimetres from
    // the room's edges: half the light's half width, which no kernel exceeds.
    const AreaLight light = roomLight();
    const auto wall = [&](const glm::dvec3& corner, const glm::dvec3& along) {
        return planeGBuffer(48, 24, corner, along, {0, 0, 2.55}, light);
    };
    const TestFrame frame(
        {roomShape().geometry(), light},
        stacked({planeGBuffer(48, 48, {-1.9, -1.9, 0}, {3.8, 0, 0}, {0, 3.8, 0}, light),
                 wall({2.0, 1.9, 0.1}, {0, -3.8, 0}), wall({-2.0, -1.9, 0.1}, {0, 3.8, 0}),
                 wall({-1.9, 2.0, 0.1}, {3.8, 0, 0}), wall({1.9, -2.0, 0.1}, {-3.8, 0, 0})}));
    ASSERT_EQ(frame.asked().size(), frame->gbuffer.size());
    Visibility image;
    try {
        image = render(frame, id());
    } catch (const Unsupported& reason) {
        GTEST_SKIP() << reason.what();
    }
    EXPECT_EQ(unequal(frame, image, 1.0f), 0);
}

TEST_P(Contract, CastersBesideTheLightShadowFloorAndWall) {
    // The screen crosses the light's plane and hides the light from all of these points, which lie
    // between 20 and 88 degrees off the light's normal.
    const AreaLight light = roomLight();
    Shape shape = roomShape();
    shape.box({0.6, -1.9, 0.5}, {0.7, 1.9, 2.95});
    const TestFrame frame(
        {shape.geometry(), light},
        stacked({planeGBuffer(48, 24, {1.0, -0.5, 0}, {0.9, 0, 0}, {0, 1, 0}, light),
                 planeGBuffer(48, 48, {2.0, 0.5, 0.1}, {0, -1, 0}, {0, 0, 2.55}, light)}));
    ASSERT_EQ(frame.asked().size(), frame->gbuffer.size());
    Visibility image;
    try {
        image = render(frame, id());
    } catch (const Unsupported& reason) {
        GTEST_SKIP() << reason.what();
    }
    EXPECT_EQ(violations(frame, image, [](float v, auto) { return v >= 0.0f && v <= kBlack; }), 0);
}

TEST_P(Contract, CasterThatCrossesTheLightsPlaneCasts) {
    // A tower taller than the light, all of its vertices as far away as the floor or behind the
    // light. The points lie in its full shadow, at least a light's width from the shadow's sides.
    const AreaLight light = lightAt({0.0, 0.0, 2.0}, 0.1, 0.1);
    Shape shape;
    shape.rectangle({-3.0, -3.0}, {3.0, 3.0}, 0.0);
    shape.box({0.8, -1.0, 0.0}, {0.9, 1.0, 4.0});
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(32, 32, {1.0, -0.4, 0.0}, {0.5, 0, 0}, {0, 0.8, 0}, light));
    EXPECT_EQ(violations(frame, render(frame, id()),
                         [](float v, auto) { return v >= 0.0f && v <= kBlack; }),
              0);
}

}  // namespace
}  // namespace penumbra
