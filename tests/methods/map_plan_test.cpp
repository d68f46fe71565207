#include <gtest/gtest.h>

#include "core/analysis/frame_analysis.hpp"
#include "core/gl/work_counter.hpp"
#include "tests/methods/test_worlds.hpp"
#include "tests/support/gl_fixture.hpp"

/// What methods of one shadow map leave out where the plan does: hard, pcf, pcss, vsm.
namespace penumbra {
namespace {

using namespace test;

class MapPlan : public GlTest {};

struct Counted {
    Visibility image;
    gl::Work work;
    WorkCounters counters;
};

Counted renderCounted(const Frame& frame, const std::string& id, const Assignments& assignments,
                      const EffectChoice& effects) {
    const auto method = findMethod(id).make();
    for (const auto& [parameter, value] : assignments) method->set(id, parameter, value);
    const FrameAnalysis analysis =
        analyseFrame(frame.scene, frame.tracer, frame.light, frame.gbuffer, frame.lightBounds);
    const Plan plan = planFor(effects, analysis.calledFor(), method->traits().simulates);
    method->prepare(frame.scene, plan);
    const TextureTarget target(frame.width(), frame.height());
    target.poison();
    gl::WorkCounter counter;
    method->build(frame, plan);
    method->shade(frame, plan, target);
    const gl::Work work = counter.stop();
    gl::checkErrors(id);
    return {target.read(), work, method->counters()};
}

double greatestDifference(const TestFrame& frame, const Visibility& a, const Visibility& b) {
    double greatest = 0.0;
    for (const std::size_t i : frame.asked())
        greatest = std::max(greatest, static_cast<double>(std::abs(a[i] - b[i])));
    return greatest;
}

/// A floor, spheres at many heights above and in it and a slope that stands on it.
Shape clutter() {
    Shape shape;
    shape.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    for (int i = 0; i < 12; ++i) {
        const glm::dvec2 at(std::sin(2.4 * i) * 0.08 * i, std::cos(2.4 * i) * 0.08 * i);
        shape.sphere({at, 0.1 + 0.09 * i}, 0.12, 12);
    }
    shape.quad({-1.0, 0.6, 0.0}, {1.0, 0.6, 0.0}, {1.0, 1.2, 0.8}, {-1.0, 1.2, 0.8});
    return shape;
}

World clutterUnder(const AreaLight& light) {
    World world{clutter().geometry(), light};
    world.camera = lookingAt({1.5, -2.5, 2.5}, {0.0, 0.1, 0.2});
    return world;
}

TEST_F(MapPlan, TilesAnswerWhatTheFilterWould) {
    struct Setting {
        std::string id;
        Assignments assignments;
        // Comparisons add up to the very number; moments are rounded, and what lies at most at the
        // plane comes out as next to 1.
        double tolerance;
    };
    const std::vector<Setting> settings = {
        // Maps coarse enough for tiles to be worth it at this image size.
        {"pcf", {{"map_size", "256"}}, 0.0},
        {"pcf", {{"kernel", "1.0"}, {"map_size", "256"}}, 0.0},
        {"pcf", {{"compare", "hardware"}, {"taps", "16"}, {"map_size", "128"}}, 0.0},
        {"pcf", {{"pattern", "vogel"}, {"rotation", "true"}, {"map_size", "256"}}, 0.0},
        {"pcf", {{"rotation", "true"}, {"map_size", "250"}}, 0.0},
        {"pcf", {{"pattern", "poisson"}, {"bias", "0"}, {"map_size", "256"}}, 0.0},
        {"pcss", {}, 0.0},
        {"vsm", {}, 1.0 / 255.0},
        {"vsm", {{"kernel", "fixed"}, {"kernel_size", "0.5"}}, 1.0 / 255.0},
        {"vsm", {{"prefilter", "sat_float"}, {"search", "2"}}, 1.0 / 255.0},
        {"vsm", {{"format", "rg16f"}, {"subdivisions", "1"}}, 1.0 / 255.0},
    };
    // No multiple of a tile; and a light at the receivers' height, whose map has side tiles.
    const TestFrame above(clutterUnder(lightAbove(3.0, 0.5, 0.25)), 94);
    const TestFrame beside(clutterUnder(lightAbove(0.9, 0.02, 0.4)), 94);
    for (const Setting& setting : settings)
        for (const TestFrame* frame : {&above, &beside}) {
            const Visibility tiles = render(*frame, setting.id, setting.assignments);
            const Visibility all =
                render(*frame, setting.id, setting.assignments, EffectChoice::parse("all"));
            EXPECT_LE(greatestDifference(*frame, tiles, all), setting.tolerance)
                << setting.id << (frame == &above ? " above" : " beside");
        }
}

TEST_F(MapPlan, EveryPixelNeedsNoClasses) {
    const TestFrame frame(clutterUnder(lightAbove(3.0, 0.3, 0.3)), 128);
    struct Expected {
        std::string id;
        Assignments assignments;
        std::uint64_t draws;  // of every pixel
        double mapMib;        // all that it needs
    };
    const std::vector<Expected> methods = {
        // The map and one pass over the image.
        {"pcf", {{"map_size", "256"}}, 2, 0.25},
        {"pcss", {{"map_size", "256"}, {"pyramid", "off"}}, 2, 0.25},
        // Moments, two scans of the table, which has a row and a column and a column of means more.
        {"vsm", {{"map_size", "256"}}, 5, 0.25 + 0.5 + 8.0 * 257 * 258 / 1048576.0},
    };
    for (const Expected& method : methods) {
        const Counted all =
            renderCounted(*frame, method.id, method.assignments, EffectChoice::parse("all"));
        EXPECT_EQ(all.work.drawCalls, method.draws) << method.id;
        EXPECT_NEAR(all.counters.textureMib, method.mapMib, 1e-9) << method.id;
    }
    // Bounding a map of more texels than there are taps would cost more than it spares.
    EXPECT_EQ(renderCounted(*frame, "pcf", {}, {}).work.drawCalls, 2u);
    // A search narrowed by the pyramid needs that, and nothing else.
    const Counted narrowed =
        renderCounted(*frame, "pcss", {{"pyramid", "narrow"}}, EffectChoice::parse("auto"));
    const Counted all = renderCounted(*frame, "pcss", {}, EffectChoice::parse("all"));
    EXPECT_EQ(all.work.drawCalls, narrowed.work.drawCalls);
    EXPECT_EQ(all.counters.textureMib, narrowed.counters.textureMib);
}

TEST_F(MapPlan, FewPixelsOfALitSceneAreShaded) {
    Shape floor;
    floor.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    World bare = clutterUnder(lightAbove(3.0, 0.3, 0.3));
    const TestFrame cluttered(bare, 128);
    bare.geometry = floor.geometry();
    const TestFrame lit(bare, 128);
    for (const char* id : {"pcf", "pcss", "vsm"}) {
        // A pass over the image that shades becomes one that answers; what comes in addition are
        // the tiles, a sixteenth of the pixels, the pyramid of a map of 8 x 8 blocks, 64 texels at
        // each of 4 levels at most, and the pixels of undecided tiles.
        const auto more = [&](const TestFrame& frame) {
            const Assignments small = {{"map_size", "64"}};
            const auto fragments = [&](const char* effects) {
                return static_cast<double>(
                    renderCounted(*frame, id, small, EffectChoice::parse(effects)).work.fragments);
            };
            return (fragments("auto") - fragments("all")) / (128.0 * 128.0);
        };
        const double besides = 1.0 / 16.0 + 4.0 / 256.0;
        EXPECT_LE(more(lit), besides) << id;
        EXPECT_GT(more(cluttered), besides) << id;
        EXPECT_LT(more(cluttered), besides + 0.75) << id;
    }
}

/// A floor and, high above it, a sheet and a ball, each a part of its own.
World hovering() {
    Shape floor, sheet, ball;
    floor.rectangle({-2.0, -2.0}, {2.0, 2.0}, 0.0);
    sheet.rectangle({-0.4, -0.4}, {0.0, 0.4}, 0.8);
    ball.sphere({0.4, 0.1, 0.7}, 0.2, 12);
    return {joined({{sheet, 0}, {floor, 0}, {ball, 0}}), lightAbove(2.0, 0.3, 0.2)};
}

TEST_F(MapPlan, ComparisonsLeaveOutWhatNoneOfThemFinds) {
    const World world = hovering();
    const TestFrame made(
        world, planeGBuffer(96, 96, {-0.9, -0.9, 0.0}, {1.8, 0, 0}, {0, 1.8, 0}, world.light));
    Frame frame = *made;
    frame.casterFacts.parts[1].inTheWay = false;
    for (const auto& [id, plan] : {std::pair{"hard", "self_shadow"},
                                   {"light_sampled", "penumbra,self_shadow"},
                                   {"adaptive_light_sampled", "penumbra,self_shadow"}}) {
        SCOPED_TRACE(id);
        const auto counted = [&](double besideTangent, const Assignments& assignments) {
            frame.casterFacts.besideTangent = besideTangent;
            return renderCounted(frame, id, assignments, EffectChoice::parse(plan));
        };
        // Half a texel of a map of 64 is less than 0.02, of one of 16 more. The floor is two
        // triangles of every map.
        const Counted all = counted(0.0, {}), some = counted(0.02, {});
        EXPECT_EQ(all.work.triangles - some.work.triangles,
                  2u * static_cast<unsigned>(some.counters.maps));
        EXPECT_EQ(greatestDifference(made, some.image, all.image), 0.0);
        // Less bias than texels look aside, or texels wider than what was looked at.
        for (const Assignments& assignments :
             {Assignments{{"bias", "0.4"}}, Assignments{{"map_size", "16"}}})
            EXPECT_EQ(counted(0.02, assignments).work.triangles,
                      counted(0.0, assignments).work.triangles);
    }
}

TEST_F(MapPlan, WithoutSelfShadowOnlyCastersAreDrawnAndNothingIsBiased) {
    const World world = hovering();
    const TestFrame made(
        world, planeGBuffer(96, 96, {-0.9, -0.9, 0.0}, {1.8, 0, 0}, {0, 1.8, 0}, world.light));
    Frame frame = *made;
    frame.casterFacts.parts[1].casts = false;
    frame.casterFacts.besideTangent = 0.0;  // what comparisons leave out is another test's
    struct Plans {
        std::string id, with, without;
    };
    // vsm needs the receivers in the map of its moments.
    for (const Plans& plans : {Plans{"hard", "self_shadow", "none"},
                               {"pcf", "penumbra,self_shadow", "penumbra"},
                               {"pcf", "self_shadow", "none"},
                               {"pcss", "penumbra,self_shadow", "penumbra"},
                               {"vsm", "self_shadow", "none"}}) {
        SCOPED_TRACE(plans.id + " " + plans.without);
        const auto counted = [&](const Assignments& assignments, const std::string& effects) {
            return renderCounted(frame, plans.id, assignments, EffectChoice::parse(effects));
        };
        const Counted with = counted({}, plans.with), without = counted({}, plans.without);
        // The floor is two triangles in the sheet's draw, as both have both their sides; the ball
        // takes its own.
        EXPECT_EQ(with.work.triangles - without.work.triangles, 2u);
        EXPECT_EQ(without.work.drawCalls, with.work.drawCalls);
        EXPECT_EQ(without.counters.textureMib, with.counters.textureMib);
        // As many texels as the map has would lift every receiver past all casters.
        const Assignments coarse = {{"map_size", "64"}},
                          lifted = {{"map_size", "64"}, {"bias", "64"}};
        EXPECT_EQ(counted(lifted, plans.without).image, counted(coarse, plans.without).image);
        EXPECT_NE(counted(lifted, plans.with).image, counted(coarse, plans.with).image);
        // Half a texel of bias moves no caster, a third of the way up to the light, across a
        // receiver.
        EXPECT_LE(greatestDifference(made, without.image, with.image), 1.0 / 255.0);
    }
}

TEST_F(MapPlan, WithoutPenumbraNothingSoftIsBuilt) {
    const TestFrame frame(clutterUnder(lightAbove(3.0, 0.3, 0.3)), 128);
    const EffectChoice hardOnly = EffectChoice::parse("self_shadow");
    const Counted hard = renderCounted(*frame, "hard", {{"map_size", "256"}}, hardOnly);
    EXPECT_EQ(hard.work.drawCalls, 2u);
    for (const char* id : {"pcf", "pcss", "vsm"}) {
        const Counted counted = renderCounted(*frame, id, {{"map_size", "256"}}, hardOnly);
        EXPECT_EQ(counted.work.drawCalls, hard.work.drawCalls) << id;
        EXPECT_EQ(counted.work.fragments, hard.work.fragments) << id;
        EXPECT_EQ(counted.counters.textureMib, hard.counters.textureMib) << id;
        EXPECT_EQ(counted.image, hard.image) << id;
    }
}

}  // namespace
}  // namespace penumbra
