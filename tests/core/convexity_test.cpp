#include "core/analysis/convexity.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "core/scene/shape.hpp"

namespace penumbra {
namespace {

bool isOne(const Shape& shape) {
    const auto geometry = shape.geometry();
    std::vector<std::uint32_t> all(geometry->triangleCount());
    std::iota(all.begin(), all.end(), 0u);
    return isOneCaster(*geometry, all);
}

/// A double pyramid around the z axis whose rim has `count` corners in `turns` turns.
Shape spindle(int count, int turns, double offM = 0.0) {
    Shape shape;
    const auto rim = [&](int i) {
        const double phi = 2.0 * std::numbers::pi * turns * (i % count) / count;
        // Corners of further turns are not those of the first.
        const double turn = std::floor(static_cast<double>(turns * (i % count)) / count);
        return glm::dvec3(std::cos(phi), std::sin(phi), offM * turn);
    };
    for (int i = 0; i < count; ++i) {
        shape.triangle({0, 0, 1}, rim(i), rim(i + 1));
        shape.triangle({0, 0, -1}, rim(i + 1), rim(i));
    }
    return shape;
}

TEST(IsOneCaster, ConvexSolidsAre) {
    Shape box;
    box.box({10, 20, 30}, {11, 22, 33});  // away from the origin, where floats are coarse
    EXPECT_TRUE(isOne(box));
    EXPECT_TRUE(isOne(spindle(12, 1)));
}

TEST(IsOneCaster, WhateverWayTheirFacesTurn) {
    Shape shape;
    shape.triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    shape.triangle({0, 0, 0}, {1, 0, 0}, {0, 0, 1});
    shape.triangle({0, 0, 0}, {0, 0, 1}, {0, 1, 0});
    shape.triangle({1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    EXPECT_TRUE(isOne(shape));
}

TEST(IsOneCaster, FlatSheetsAre) {
    Shape sheet;
    sheet.rectangle({0, 0}, {1, 1}, 0.3);
    sheet.rectangle({5, 0}, {6, 1}, 0.3);
    EXPECT_TRUE(isOne(sheet));
}

TEST(IsOneCaster, BentSheetsAreNot) {
    Shape shape;
    shape.triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    shape.triangle({1, 0, 0}, {1, 1, 0.5}, {0, 1, 0});
    EXPECT_FALSE(isOne(shape));
}

TEST(IsOneCaster, OpenSolidsAreNot) {
    Shape pot;
    const auto at = [](int x, int y, int z) { return glm::dvec3(x, y, z); };
    pot.quad(at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0));
    pot.quad(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
    pot.quad(at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0));
    EXPECT_FALSE(isOne(pot));
}

TEST(IsOneCaster, DentedSolidsAreNot) {
    Shape dented;  // a box whose lid is a hollow pyramid
    const auto at = [](int x, int y, int z) { return glm::dvec3(x, y, z); };
    dented.quad(at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0));
    dented.quad(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
    dented.quad(at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0));
    dented.quad(at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0));
    dented.quad(at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1));
    const glm::dvec3 pit(0.5, 0.5, 0.9);
    dented.triangle(at(0, 0, 1), at(1, 0, 1), pit);
    dented.triangle(at(1, 0, 1), at(1, 1, 1), pit);
    dented.triangle(at(1, 1, 1), at(0, 1, 1), pit);
    dented.triangle(at(0, 1, 1), at(0, 0, 1), pit);
    EXPECT_FALSE(isOne(dented));
}

TEST(IsOneCaster, TwoSolidsAreNot) {
    Shape two;
    two.box({0, 0, 0}, {1, 1, 1});
    two.box({0, 0, 2}, {1, 1, 3});
    EXPECT_FALSE(isOne(two));
}

TEST(IsOneCaster, ASurfaceThatIsWoundTwiceIsNot) {
    // Closed, of the topology of a sphere, its faces turned outward everywhere: rays meet it twice.
    EXPECT_FALSE(isOne(spindle(13, 2, 1e-3)));
}

}  // namespace
}  // namespace penumbra
