#include "core/sampling/light_refinement.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace penumbra {
namespace {

using Part = LightRefinement::Part;

LightTree square(int maxDepth) {
    return {glm::bvec2(true, true), maxDepth};
}

/// Only what touches the light's corner -u -v differs.
void cornerDiffers(const LightTree&, std::span<Part> parts, int) {
    for (Part& part : parts) part.error = part.leaf.low == glm::ivec2(0) ? 1.0 : 0.0;
}

TEST(LightRefinement, SplitsWhereItIsToldTo) {
    LightRefinement refinement;
    std::vector<int> known;
    refinement.run(square(2), {.epsilon = 0.5, .mostSamples = 81},
                   [&](const LightTree& tree, std::span<Part> parts, int before) {
                       known.push_back(before);
                       cornerDiffers(tree, parts, before);
                   });
    // METHODS.md 12: 4, 9, 14.
    EXPECT_EQ(known, (std::vector<int>{0, 4, 9}));
    EXPECT_EQ(refinement.summary(),
              "14 maps; 4 of 7 parts at max_depth, 0 refused by max_maps; tree ++.......");
}

TEST(LightRefinement, WhatDiffersMostComesFirstWhereSamplesAreFew) {
    LightRefinement refinement;
    refinement.run(square(2), {.epsilon = 0.5, .mostSamples = 14},
                   [&](const LightTree&, std::span<Part> parts, int) {
                       for (Part& part : parts)
                           part.error = 1.0 + part.leaf.low.x + 2 * part.leaf.low.y;
                   });
    EXPECT_EQ(refinement.tree().preorder(), "+...+....");
    EXPECT_EQ(refinement.tree().sampleCount(), 14u);
}

TEST(LightRefinement, ReuseJudgesInOneGoAndForgetsALevelAtATime) {
    LightRefinement refinement;
    const LightRefinement::Limits limits{.epsilon = 0.5, .mostSamples = 81, .reuse = true};
    refinement.run(square(2), limits, cornerDiffers);
    const std::string before = refinement.tree().preorder();
    int levels = 0;
    refinement.run(square(2), limits, [&](const LightTree& tree, std::span<Part> parts, int known) {
        ++levels;
        cornerDiffers(tree, parts, known);
    });
    EXPECT_EQ(refinement.tree().preorder(), before);
    EXPECT_EQ(levels, 1);
    std::vector<std::size_t> samples;
    for (int i = 0; i < 3; ++i) {
        refinement.run(square(2), limits, [](const LightTree&, std::span<Part>, int) {});
        samples.push_back(refinement.tree().sampleCount());
    }
    EXPECT_EQ(samples, (std::vector<std::size_t>{14, 9, 4}));
}

}  // namespace
}  // namespace penumbra
