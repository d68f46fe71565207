// Maps, weights, evaluation, skipping and reuse; what splits the light is in
// adaptive_light_sampled_comparison_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/error.hpp"
#include "core/gl/work_counter.hpp"
#include "tests/methods/adaptive_light_sampled_support.hpp"

namespace penumbra {
namespace {

using namespace test;
using namespace test::adaptive;

TEST_F(AdaptiveLightSampled, NothingAllowedIsTheFullLattice) {
    // METHODS.md hard case 32. The weights of a full lattice are light_sampled's.
    const TestFrame frame = box().frame();
    for (const auto& [weights, regular] :
         {std::pair("leaf_area", "trapezoid"), {"equal", "equal"}, {"local_depth", "equal"}})
        for (const auto& [evaluation, pcf] :
             {std::pair("array", false), {"array", true}, {"buffer", true}, {"bits", false}}) {
            const Outcome full = outcome(frame, with(kThorough, {{"epsilon", "0"},
                                                                 {"weights", weights},
                                                                 {"evaluation", evaluation},
                                                                 {"pcf", pcf ? "2x2" : "off"}}));
            EXPECT_EQ(full.maps, 81);
            EXPECT_EQ(full.image, render(frame, "light_sampled",
                                         {{"samples", "81"},
                                          {"map_size", "128"},
                                          {"pattern", "lattice"},
                                          {"weights", regular},
                                          {"pcf", pcf ? "true" : "false"}}))
                << weights << ' ' << evaluation << ", pcf " << pcf;
        }
}

TEST_F(AdaptiveLightSampled, NoDepthIsEqualWithoutGamma) {
    const TestFrame frame = box().frame(48);
    for (const char* compare : {"absolute", "relative", "symmetric"})
        EXPECT_EQ(mapsOf(frame, with(kPaper, {{"compare", compare},
                                              {"gamma", "0"},
                                              {"criterion", "compared_pixels"},
                                              {"max_depth", "2"},
                                              {"epsilon", "1"}})),
                  25)
            << compare;
}

TEST_F(AdaptiveLightSampled, EverythingAllowedIsFourMaps) {
    const TestFrame frame = box().frame();
    const Outcome four =
        outcome(frame, {{"epsilon", "1e6"}, {"centre_test", "false"}, {"rim_depth", "-1"}});
    EXPECT_EQ(four.maps, 4);
    EXPECT_EQ(four.image,
              render(frame, "light_sampled", {{"samples", "4"}, {"pattern", "lattice"}}));
    HalfPlane caster;
    EXPECT_EQ(mapsOf(caster.frame(0.8, 0.0), {{"epsilon", "1e6"}, {"centre_test", "false"}}), 2);
}

TEST_F(AdaptiveLightSampled, LinearLightsTakeTheLatticeOfTheirAxis) {
    for (const bool alongU : {true, false}) {
        HalfPlane caster;
        caster.axis = alongU ? 0 : 1;
        const TestFrame frame = caster.frame(alongU ? 0.8 : 0.0, alongU ? 0.0 : 0.8);
        const Outcome full = outcome(
            frame, with(kThorough, {{"epsilon", "0"}, {"max_depth", "5"}, {"weights", "equal"}}));
        EXPECT_EQ(full.maps, 33);
        EXPECT_EQ(full.image,
                  render(frame, "light_sampled",
                         {{"samples", "33"}, {"pattern", "lattice"}, {"map_size", "128"}}));
    }
}

TEST_F(AdaptiveLightSampled, EveryMapIsRenderedOnce) {
    // METHODS.md 12: 4, 9, 14, then 18 with an adjacent part or 19 with the opposite one. Each map
    // is one draw call; the other calls are a pass of marks per level and one of evaluation.
    const TestFrame frame = box().frame(32);
    for (const auto& [most, levels] : {std::pair(4, 1), {9, 2}, {14, 3}, {18, 3}, {81, 4}}) {
        const auto method = findMethod(kId).make();
        method->set(kId, "epsilon", "0");
        method->set(kId, "centre_test", "false");
        method->set(kId, "skip_decided", "false");
        method->set(kId, "max_maps", std::to_string(most));
        const Plan plan = planFor({}, frame.calledFor(), method->traits().simulates);
        method->prepare(frame->scene, plan);
        const TextureTarget target(frame->width(), frame->height());
        gl::WorkCounter counter;
        method->build(*frame, plan);
        method->shade(*frame, plan, target);
        EXPECT_EQ(counter.stop().drawCalls, static_cast<std::uint64_t>(most + levels + 1)) << most;
        EXPECT_EQ(method->counters().maps, most);
    }
    const Outcome full = outcome(frame, {{"epsilon", "0"}});
    const std::string twig = "+....", branch = "+" + twig + twig + twig + twig;
    EXPECT_EQ(full.counters.message,
              "81 maps; 64 of 64 parts at max_depth, 0 refused by max_maps; tree +" + branch +
                  branch + branch + branch);
    const Outcome half =
        outcome(frame, {{"epsilon", "0"}, {"max_maps", "9"}, {"centre_test", "false"}});
    EXPECT_EQ(half.counters.message,
              "9 maps; 0 of 4 parts at max_depth, 4 refused by max_maps; tree +....");
}

TEST_F(AdaptiveLightSampled, FewerMapsAsMoreMayDiffer) {
    const TestFrame frame = box().frame(64);
    struct Case {
        Assignments settings;
        const char* parameter;
    };
    for (const Case& c :
         {Case{kThorough, "epsilon"},
          Case{with(kThorough, {{"criterion", "compared_pixels"}}), "epsilon"},
          Case{with(kThorough, {{"criterion", "worst_tile"}}), "epsilon"},
          Case{with(kThorough, {{"space", "light"}}), "epsilon"}, Case{kPaper, "epsilon"},
          Case{kPaper, "gamma"}, Case{with(kPaper, {{"compare", "absolute"}}), "gamma"},
          Case{with(kPaper, {{"compare", "symmetric"}}), "gamma"}}) {
        int before = std::numeric_limits<int>::max(), first = 0;
        for (const char* value : {"0", "0.01", "0.05", "0.2", "0.5", "100"}) {
            const int maps = mapsOf(frame, with(c.settings, {{c.parameter, value}}));
            EXPECT_LE(maps, before) << c.parameter << '=' << value;
            if (first == 0) first = maps;
            before = maps;
        }
        EXPECT_EQ(first, 81) << c.parameter;
        EXPECT_EQ(before, 4) << c.parameter;
    }
}

TEST_F(AdaptiveLightSampled, EvaluationsAgree) {
    // Leaf areas and equal weights are whole numbers with exact sums; eq. 6's are rounded, once for
    // each of at most 81 maps.
    const TestFrame frame = box().frame();
    for (const char* weights : {"leaf_area", "equal", "local_depth"}) {
        const Assignments settings = with(kThorough, {{"weights", weights}, {"epsilon", "0.05"}});
        const Outcome bits = outcome(frame, with(settings, {{"evaluation", "bits"}}));
        EXPECT_GT(bits.maps, 9);
        EXPECT_LT(bits.maps, 81);
        const double tolerance = std::string(weights) == "local_depth" ? 81 * 6e-8 : 0.0;
        for (const char* evaluation : {"array", "buffer"}) {
            const Outcome other = outcome(frame, with(settings, {{"evaluation", evaluation}}));
            EXPECT_EQ(other.maps, bits.maps);
            EXPECT_EQ(violations(frame, other.image,
                                 [&](float v, std::size_t i) {
                                     return std::abs(v - bits.image[i]) <= tolerance;
                                 }),
                      0)
                << weights << ' ' << evaluation;
        }
    }
}

TEST_F(AdaptiveLightSampled, QueriesCountWhatBitsCount) {
    // Whatever is compared, at whichever pixels: the same tree and so the same image.
    const TestFrame frame = box().frame(80);
    for (const Assignments& settings :
         {Assignments{}, Assignments{{"criterion", "compared_pixels"}},
          Assignments{{"pairs", "diagonals"}}, Assignments{{"centre_test", "true"}},
          Assignments{{"tile", "16"}}, Assignments{{"stride", "3"}, {"tile", "16"}}})
        for (const char* epsilon : {"0.03", "0.2"}) {
            const Assignments all = with(with(kThorough, settings), {{"epsilon", epsilon}});
            EXPECT_EQ(outcome(frame, all).image,
                      outcome(frame, with(all, {{"count_by", "queries"}})).image);
        }
}

TEST_F(AdaptiveLightSampled, QueriesCountInHalfCubesToo) {
    // A floor to 76 degrees off the light's normal.
    const AreaLight light = lightAbove(1.0, 0.4, 0.4);
    Shape shape;
    shape.rectangle({-4.0, -4.0}, {4.0, 4.0}, 0.0);
    shape.box({1.0, -0.3, 0.2}, {1.3, 0.3, 0.5});
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(64, 64, {-4, -4, 0}, {8, 0, 0}, {0, 8, 0}, light));
    const Assignments settings = with(kThorough, {{"epsilon", "0.1"}});
    const Outcome bits = outcome(frame, settings);
    EXPECT_EQ(bits.counters.maps, 5 * bits.maps);
    EXPECT_GT(bits.maps, 4);
    EXPECT_EQ(bits.image, outcome(frame, with(settings, {{"count_by", "queries"}})).image);
    for (const char* space : {"camera", "light"})
        EXPECT_GT(mapsOf(frame, with(kPaper, {{"space", space}})), 4) << space;
}

TEST_F(AdaptiveLightSampled, ATreeInCameraSpaceIsMadeAnewForAnotherCamera) {
    const TestFrame frame = box().frame(64);
    const TextureTarget target(frame->width(), frame->height());
    for (const char* space : {"camera", "light"}) {
        const auto method = findMethod(kId).make();
        method->set(kId, "space", space);
        const Plan plan = planFor({}, frame.calledFor(), method->traits().simulates);
        method->prepare(frame->scene, plan);
        method->build(*frame, plan);
        const auto maps = [&] {
            method->shade(*frame, plan, target);
            return method->counters().shadeMaps;
        };
        EXPECT_EQ(maps(), 0) << space;
        method->forgetCamera();
        EXPECT_EQ(maps(), *space == 'c' ? method->counters().maps : 0) << space;
        EXPECT_EQ(maps(), 0) << space << ": the camera stayed";
    }
}

TEST_F(AdaptiveLightSampled, PointsDrawnInAreTheGridOfEqualCells) {
    // The same 25 points up to double rounding, which may move a pixel at a texel's border from one
    // side to the other; one map's answer is a 25th.
    const TestFrame frame = box().frame();
    const Outcome drawnIn =
        outcome(frame, with(kThorough, {{"epsilon", "0"}, {"max_depth", "2"}, {"rim_depth", "2"}}));
    EXPECT_EQ(drawnIn.maps, 25);
    const Visibility grid =
        render(frame, "light_sampled", {{"samples", "25"}, {"map_size", "128"}});
    EXPECT_LT(violations(frame, drawnIn.image,
                         [&](float v, std::size_t i) { return std::abs(v - grid[i]) < 1e-6; }),
              static_cast<int>(frame.asked().size()) / 100);
}

/// Pixels whose visibility is not the same where lit tiles are skipped, whose maps may be told by
/// `settings`.
int changedBySkipping(const TestFrame& frame, const Assignments& settings) {
    const Visibility all = outcome(frame, with(settings, {{"skip_decided", "false"}})).image;
    const Visibility skipped = outcome(frame, settings).image;
    return violations(frame, skipped, [&](float v, std::size_t i) { return v == all[i]; });
}

/// Whether maps are looked up at some of the pixels only: in a pass of its own, before the one over
/// all pixels that writes the answers.
bool skips(const TestFrame& frame, const Assignments& settings) {
    const auto method = findMethod(kId).make();
    for (const auto& [parameter, value] : settings) method->set(kId, parameter, value);
    const Plan plan = planFor({}, frame.calledFor(), method->traits().simulates);
    method->prepare(frame->scene, plan);
    const TextureTarget target(frame->width(), frame->height());
    method->build(*frame, plan);
    gl::WorkCounter counter;
    method->shade(*frame, plan, target);
    const gl::Work work = counter.stop();
    return work.drawCalls == 2 && work.fragments < 2 * frame->gbuffer.size();
}

TEST_F(AdaptiveLightSampled, SkippingLitTilesChangesNothing) {
    const TestFrame frame = box().frame();
    const Assignments small = {{"map_size", "128"}};
    EXPECT_TRUE(skips(frame, small));
    for (const char* epsilon : {"0", "0.05", "0.4"})
        for (const char* stride : {"1", "4"})
            EXPECT_EQ(
                changedBySkipping(frame, with(small, {{"epsilon", epsilon}, {"stride", stride}})),
                0)
                << epsilon << ' ' << stride;
    for (const char* pcf : {"2x2", "5x5"})
        EXPECT_EQ(changedBySkipping(frame, with(small, {{"pcf", pcf}})), 0) << pcf;
    for (const char* countBy : {"bits", "queries"})
        for (const char* compare : {"tight", "absolute", "relative", "symmetric"})
            EXPECT_EQ(changedBySkipping(frame,
                                        with(small, {{"count_by", countBy}, {"compare", compare}})),
                      0)
                << countBy << ' ' << compare;
}

TEST_F(AdaptiveLightSampled, SkippingLitTilesFindsWhatFallsBetweenComparedPixels) {
    // A wire whose shadow is a pixel wide, on the floor's rows that are not compared.
    Room room;
    const double pixelM = 1.6 / 96, rowM = -0.8 + 50.5 * pixelM;
    room.shape.rectangle({-0.6, rowM - 0.4 * pixelM}, {0.6, rowM + 0.4 * pixelM}, 0.002);
    const TestFrame frame = room.frame();
    const Assignments settings = {{"stride", "8"}, {"map_size", "1024"}, {"epsilon", "0.4"}};
    ASSERT_TRUE(skips(frame, settings));
    EXPECT_GT(
        violations(frame, outcome(frame, settings).image, [](float v, auto) { return v > 0.5f; }),
        40);
    EXPECT_EQ(changedBySkipping(frame, settings), 0);
}

TEST_F(AdaptiveLightSampled, SkippingLitTilesMissesNoneOfManySmallCasters) {
    // Squares of 1 to 3 centimetres, three texels at least, at all heights up to half the light's.
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-0.7, 0.7), height(0.01, 1.0), half(0.005, 0.015);
    for (int round = 0; round < 4; ++round) {
        Room room;
        for (int i = 0; i < 6; ++i) {
            const glm::dvec2 at(place(random), place(random));
            const double halfM = half(random);
            room.shape.rectangle(at - halfM, at + halfM, height(random));
        }
        const TestFrame frame = room.frame();
        for (const char* epsilon : {"0.4", "1e6"}) {
            const Assignments settings = {{"epsilon", epsilon}};
            ASSERT_TRUE(skips(frame, settings));
            EXPECT_EQ(changedBySkipping(frame, settings), 0) << round << ' ' << epsilon;
        }
    }
}

TEST_F(AdaptiveLightSampled, CastersCloseToTheLightAreInTheWayOfAllThatTheyShadow) {
    // 2 centimetres from a light of 0.8 metres; the second, seen from the light's middle, is beside
    // the floor, and shadows all of it.
    Room under, beside;
    under.shape.rectangle({-0.01, -0.01}, {0.01, 0.01}, 1.98);
    beside.shape.rectangle({0.3, 0.3}, {0.32, 0.32}, 1.98);
    EXPECT_EQ(changedBySkipping(under.frame(), {}), 0);
    EXPECT_EQ(changedBySkipping(beside.frame(), {}), 0);
    EXPECT_FALSE(skips(beside.frame(), {}));
}

TEST_F(AdaptiveLightSampled, WhatIsBelowPartOfTheLightsHorizonIsNotSkipped) {
    // A wall that stands under the light's edge at 0.4 metres: without casters its face sees the
    // part of the light before it, and only where it is under the light.
    const AreaLight light = lightAbove(2.0, 0.8, 0.8);
    Shape away;
    away.rectangle({0.39, -1.0}, {0.4, 1.0}, 0.0);
    const TestFrame frame({away.geometry(), light},
                          planeGBuffer(48, 48, {0.1, -0.5, 0.1}, {0, 1, 0}, {0, 0, 1}, light));
    const Visibility image = outcome(frame, {}).image;
    EXPECT_GT(violations(frame, image, [](float v, auto) { return v == 1.0f; }), 0);
    EXPECT_EQ(changedBySkipping(frame, {}), 0);
}

TEST_F(AdaptiveLightSampled, LargerKernelsAreSmootherAndStayWithinTheMaps) {
    // Of one hard edge, a kernel of n makes a ramp of n - 1 texels.
    const TestFrame frame = HalfPlane{}.frame(0.8, 0.0, 256);
    int before = 0;
    for (const char* pcf : {"off", "2x2", "3x3", "5x5"}) {
        const Visibility image = render(
            frame, kId,
            {{"epsilon", "1e6"}, {"pcf", pcf}, {"centre_test", "false"}, {"map_size", "64"}});
        const int between = violations(
            frame, image, [](float v, auto) { return v == 0.0f || v == 0.5f || v == 1.0f; });
        EXPECT_TRUE(between > before || between == 0) << pcf;
        EXPECT_EQ(outOfRange(frame, image), 0);
        before = between;
    }
    EXPECT_GT(before, 0);
}

TEST_F(AdaptiveLightSampled, ReuseKeepsAndForgetsTheTree) {
    // The same frame again: the same tree, judged in one pass instead of one per level. Without the
    // box its parts are joined a level per frame.
    const TestFrame frame = box().frame(), empty = Room().frame();
    const auto method = findMethod(kId).make();
    for (const auto& [parameter, value] : Assignments{{"reuse", "true"},
                                                      {"epsilon", "0.02"},
                                                      {"centre_test", "false"},
                                                      {"skip_decided", "false"}})
        method->set(kId, parameter, value);
    const Plan plan = planFor({}, frame.calledFor(), method->traits().simulates);
    method->prepare(frame->scene, plan);
    const TextureTarget target(frame->width(), frame->height());
    const auto image = [&](const TestFrame& of) {
        method->build(*of, plan);
        method->shade(*of, plan, target);
        return target.read();
    };
    const Outcome anew =
        outcome(frame, {{"epsilon", "0.02"}, {"centre_test", "false"}, {"skip_decided", "false"}});
    ASSERT_GT(anew.maps, 25);
    EXPECT_EQ(image(frame), anew.image);
    gl::WorkCounter counter;
    EXPECT_EQ(image(frame), anew.image);
    EXPECT_EQ(counter.stop().drawCalls, static_cast<std::uint64_t>(anew.maps + 2));
    std::vector<int> maps;
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(unequal(empty, image(empty), 1.0f), 0);
        maps.push_back(method->counters().maps);
    }
    EXPECT_EQ(maps, (std::vector<int>{anew.maps, 25, 9, 4}));
}

TEST_F(AdaptiveLightSampled, NonsenseIsRefused) {
    const auto method = findMethod(kId).make();
    for (const char* parameter : {"epsilon", "gamma"})
        for (const char* value : {"nan", "-0.1", "inf", "-inf", "some"})
            EXPECT_THROW(method->set(kId, parameter, value), InputError) << parameter << value;
    EXPECT_THROW(method->set(kId, "max_maps", "3"), InputError);
    EXPECT_THROW(method->set(kId, "max_depth", "-1"), InputError);
}

TEST_F(AdaptiveLightSampled, WithoutPenumbraItIsTheHardMap) {
    const TestFrame point = HalfPlane{}.frame(0.0, 0.0);
    EXPECT_EQ(render(point, kId, {{"map_size", "256"}}),
              render(point, "hard", {{"map_size", "256"}}));
    const TestFrame wide = HalfPlane{}.frame(0.8, 0.8);
    EXPECT_EQ(render(wide, kId, {{"map_size", "256"}}, EffectChoice::parse("none")),
              render(wide, "hard", {{"map_size", "256"}}, EffectChoice::parse("none")));
}

}  // namespace
}  // namespace penumbra
