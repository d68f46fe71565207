#include "core/sampling/light_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>

namespace penumbra {
namespace {

constexpr glm::bvec2 kRectangle(true, true), kAlongU(true, false), kAlongV(false, true);

void splitAll(LightTree& tree) {
    for (bool again = true; again;) {
        again = false;
        const std::size_t count = tree.leaves().size();
        for (std::size_t i = 0; i < count; ++i)
            if (tree.canSplit(tree.leaves()[i])) {
                tree.split(i);
                again = true;
            }
    }
}

double sum(const std::vector<double>& weights) {
    return std::accumulate(weights.begin(), weights.end(), 0.0);
}

/// The root and its first quarter split: Schwaerzler 2009, fig. 1.
LightTree fourteen() {
    LightTree tree(kRectangle, 3);
    tree.split(0);
    tree.split(0);
    return tree;
}

std::size_t leafWithLow(const LightTree& tree, glm::ivec2 low) {
    for (std::size_t i = 0; i < tree.leaves().size(); ++i)
        if (tree.leaves()[i].low == low) return i;
    ADD_FAILURE() << "no leaf at " << low.x << ", " << low.y;
    return 0;
}

TEST(LightTree, CornersAreSharedAndCountAsInThePaper) {
    // METHODS.md 12: 4, 9, 14, then 18 with an adjacent child or 19 with the opposite one.
    LightTree tree(kRectangle, 3);
    EXPECT_EQ(tree.sampleCount(), 4u);
    EXPECT_EQ(tree.samplesIfSplit(0), 5);
    tree.split(0);
    EXPECT_EQ(tree.sampleCount(), 9u);
    tree.split(0);
    EXPECT_EQ(tree.sampleCount(), 14u);
    LightTree adjacent = tree, opposite = tree;
    EXPECT_EQ(adjacent.samplesIfSplit(leafWithLow(adjacent, {4, 0})), 4);
    adjacent.split(leafWithLow(adjacent, {4, 0}));
    EXPECT_EQ(adjacent.sampleCount(), 18u);
    opposite.split(leafWithLow(opposite, {4, 4}));
    EXPECT_EQ(opposite.sampleCount(), 19u);
    splitAll(tree);
    EXPECT_EQ(tree.sampleCount(), 81u);
}

TEST(LightTree, EverySampleIsListedOnce) {
    LightTree tree(kRectangle, 4);
    splitAll(tree);
    std::set<std::pair<double, double>> places;
    for (std::size_t i = 0; i < tree.sampleCount(); ++i)
        places.insert({tree.position(i).x, tree.position(i).y});
    EXPECT_EQ(tree.sampleCount(), 289u);
    EXPECT_EQ(places.size(), 289u);
    EXPECT_EQ(places.begin()->first, -1.0);
    EXPECT_EQ(places.rbegin()->second, 1.0);
}

TEST(LightTree, LinearLightsAreHalved) {
    for (const glm::bvec2 extent : {kAlongU, kAlongV}) {
        LightTree tree(extent, 7);
        EXPECT_EQ(tree.sampleCount(), 2u);
        tree.split(0);
        EXPECT_EQ(tree.sampleCount(), 3u);
        EXPECT_EQ(tree.samplesIfSplit(1), 1);
        tree.addCentre(1);
        EXPECT_EQ(tree.samplesIfSplit(1), 0);
        splitAll(tree);
        EXPECT_EQ(tree.sampleCount(), 129u);
        for (std::size_t i = 0; i < tree.sampleCount(); ++i)
            EXPECT_EQ(extent.x ? tree.position(i).y : tree.position(i).x, 0.0);
    }
}

TEST(LightTree, EquationsFiveAndSixSumToOneAtUniformDepth) {
    for (const int depth : {0, 1, 3}) {
        LightTree plane(kRectangle, depth), line(kAlongV, depth);
        splitAll(plane);
        splitAll(line);
        // Rounding of some hundred doubles.
        EXPECT_NEAR(sum(plane.weights(LightTreeWeights::localDepth)), 1.0, 1e-12);
        EXPECT_NEAR(sum(line.weights(LightTreeWeights::localDepth)), 1.0, 1e-12);
        EXPECT_NEAR(line.weights(LightTreeWeights::localDepth)[0], 1.0 / ((1 << depth) + 1), 1e-15);
    }
}

TEST(LightTree, EquationSixFallsShortOfOneAtMixedDepth) {
    // Five samples touch no deeper leaf than the root's quarters, nine touch its quarter's.
    const std::vector<double> weights = fourteen().weights(LightTreeWeights::localDepth);
    EXPECT_NEAR(sum(weights), 5.0 / 9 + 9.0 / 25, 1e-12);
    EXPECT_NEAR(sum(weights), 0.9156, 5e-5);
}

TEST(LightTree, LeafAreasSumToOneAtAnyDepth) {
    LightTree tree = fourteen();
    tree.addCentre(leafWithLow(tree, {4, 4}));
    const std::vector<double> weights = tree.weights(LightTreeWeights::leafArea);
    EXPECT_NEAR(sum(weights), 1.0, 1e-12);
    for (const double weight : weights) EXPECT_GT(weight, 0.0);
    // The far corner has an eighth of its leaf's quarter, as half of it stands with its centre.
    EXPECT_EQ(weights.back(), 0.125);
    EXPECT_NEAR(sum(tree.weights(LightTreeWeights::equal)), 1.0, 1e-12);
}

TEST(LightTree, LeafAreasOfAFullLatticeAreTrapezoids) {
    LightTree tree(kRectangle, 2);
    splitAll(tree);
    const std::vector<double> weights = tree.weights(LightTreeWeights::leafArea);
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const glm::dvec2 rim = glm::abs(tree.position(i));
        EXPECT_EQ(weights[i], (rim.x == 1.0 ? 0.5 : 1.0) * (rim.y == 1.0 ? 0.5 : 1.0) / 16.0);
    }
}

TEST(LightTree, DrawnInSamplesStandAmidEqualCells) {
    for (const int depth : {1, 2}) {
        LightTree tree(kRectangle, depth, depth), line(kAlongU, depth, depth);
        splitAll(tree);
        splitAll(line);
        const int cells = (1 << depth) + 1;
        // Rounding of sums of at most nine terms.
        for (const double weight : tree.weights(LightTreeWeights::leafArea))
            EXPECT_NEAR(weight, 1.0 / (cells * cells), 1e-15);
        for (const double weight : line.weights(LightTreeWeights::leafArea))
            EXPECT_NEAR(weight, 1.0 / cells, 1e-15);
        EXPECT_NEAR(tree.position(0).x, 1.0 / cells - 1.0, 1e-15);
        EXPECT_EQ(tree.position(0).x, -tree.position(3).x);
    }
}

TEST(LightTree, LeafAreasAreWholeMultiplesOfTheirUnit) {
    for (const std::optional<int> rim : {std::optional<int>(), {0}, {2}, {5}})
        for (const glm::bvec2 extent : {kRectangle, kAlongV}) {
            LightTree tree(extent, 3, rim);
            tree.split(0);
            tree.addCentre(1);
            tree.split(0);
            tree.addCentre(0);
            const std::vector<double> weights = tree.weights(LightTreeWeights::leafArea);
            EXPECT_NEAR(sum(weights), 1.0, 1e-12);
            for (const double weight : weights) {
                const double units = weight / tree.leafAreaUnit();
                EXPECT_NEAR(units, std::round(units), 1e-9 * units);
                EXPECT_GE(units, 0.5);
            }
        }
}

TEST(LightTree, PreorderShowsTheTree) {
    EXPECT_EQ(LightTree(kRectangle, 3).preorder(), ".");
    EXPECT_EQ(fourteen().preorder(), "++.......");
    LightTree line(kAlongU, 3);
    line.split(0);
    line.split(1);
    EXPECT_EQ(line.preorder(), "+.+..");
}

TEST(LightTree, RemembersWhatWasSplit) {
    const LightTree tree = fourteen();
    ASSERT_EQ(tree.inner().size(), 2u);
    EXPECT_EQ(tree.inner()[0].depth, 0);
    EXPECT_FALSE(tree.isTwig(tree.inner()[0]));
    EXPECT_TRUE(tree.isTwig(tree.inner()[1]));
    EXPECT_EQ(tree.find({0, 0}, 2), 0u);
    EXPECT_EQ(tree.find({0, 0}, 1), tree.leaves().size());
}

TEST(LightTree, OrderOfTheSplitsDoesNotMatter) {
    LightTree one = fourteen(), other(kRectangle, 3);
    one.split(leafWithLow(one, {4, 4}));
    other.split(0);
    other.split(leafWithLow(other, {4, 4}));
    other.split(leafWithLow(other, {0, 0}));
    for (const LightTreeWeights kind :
         {LightTreeWeights::leafArea, LightTreeWeights::localDepth, LightTreeWeights::equal}) {
        const auto sorted = [&](const LightTree& tree) {
            std::set<std::tuple<double, double, double>> entries;
            for (std::size_t i = 0; i < tree.sampleCount(); ++i)
                entries.insert({tree.position(i).x, tree.position(i).y, tree.weights(kind)[i]});
            return entries;
        };
        EXPECT_EQ(sorted(one), sorted(other));
    }
}

}  // namespace
}  // namespace penumbra
