#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <glm/glm.hpp>
#include <random>
#include <vector>

#include "harness/reference/exact_union.hpp"

namespace penumbra {
namespace {

using Corners = std::vector<glm::dvec2>;

/// Corners counter-clockwise.
void add(UnionSweep& sweep, const Corners& polygon) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        sweep.add(a.x, a.y, b.x, b.y, -1);
    }
}

double area(const std::vector<Corners>& polygons) {
    UnionSweep sweep;
    for (const Corners& polygon : polygons) add(sweep, polygon);
    double sum = 0.0;
    for (const Strip& strip : sweep.covered()) sum += strip.signedArea();
    return sum;
}

Corners box(double x0, double y0, double x1, double y1) {
    return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

TEST(UnionSweep, RectanglesByHand) {
    EXPECT_EQ(area({}), 0.0);
    EXPECT_DOUBLE_EQ(area({box(0, 0, 1, 1)}), 1.0);
    EXPECT_DOUBLE_EQ(area({box(.1, .2, .6, .5), box(.3, .4, .9, .8)}), .15 + .24 - .03);
    EXPECT_DOUBLE_EQ(area({box(.1, .2, .6, .5), box(.1, .2, .6, .5)}), .15);
    EXPECT_DOUBLE_EQ(area({box(.1, .2, .6, .5), box(.2, .3, .5, .4)}), .15);
    EXPECT_DOUBLE_EQ(area({box(.1, .2, .6, .5), box(.6, .2, .9, .5)}), .24);
    EXPECT_DOUBLE_EQ(area({box(.1, .2, .6, .5), box(.1, .6, .6, .7)}), .2);
}

TEST(UnionSweep, CrossingDiagonals) {
    // Two triangles on the whole lower and the whole left side, whose long sides cross at the
    // centre: three of the square's four quarters by its diagonals.
    EXPECT_DOUBLE_EQ(area({{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 0}, {0, 1}}}), 0.75);
}

TEST(UnionSweep, OutlinesOpenToTheRightReachTheSquaresSide) {
    UnionSweep sweep;
    sweep.add(0.25, 1.0, 0.25, 0.0, -1);
    ASSERT_EQ(sweep.covered().size(), 2u);
    for (int again = 0; again < 2; ++again) {
        double sum = 0.0;
        for (const Strip& strip : sweep.covered()) sum += strip.signedArea();
        EXPECT_EQ(sum, 0.75);
    }
}

TEST(UnionSweep, AlmostHorizontalAndAlmostEqualEdges) {
    const double tiny = 1e-15;
    EXPECT_NEAR(area({{{0, .5}, {1, .5}, {1, .5 + tiny}}, {{0, .5}, {1, .5 - tiny}, {1, .5}}}), 0.0,
                1e-14);
    EXPECT_NEAR(area({{{.1, .1}, {.9, .1}, {.5, .9}},
                      {{.1 + tiny, .1}, {.9, .1 - tiny}, {.5, .9 + tiny}},
                      {{.1, .1 + tiny}, {.9 - tiny, .1}, {.5 - tiny, .9}}}),
                .32, 1e-12);
}

/// The union's length along the line of height y.
double length(const std::vector<Corners>& polygons, double y) {
    std::vector<std::array<double, 2>> intervals;
    for (const Corners& polygon : polygons) {
        double lo = 2.0, hi = -1.0;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
            if ((a.y < y) == (b.y < y)) continue;
            const double x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
            lo = std::min(lo, x);
            hi = std::max(hi, x);
        }
        if (lo < hi) intervals.push_back({lo, hi});
    }
    std::sort(intervals.begin(), intervals.end());
    double sum = 0.0, end = 0.0;
    for (const auto& [lo, hi] : intervals) {
        sum += std::max(0.0, hi - std::max(lo, end));
        end = std::max(end, hi);
    }
    return sum;
}

TEST(UnionSweep, RandomTrianglesAgainstTheirLengthAlongManyLines) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (const int count : {1, 3, 10, 40, 150}) {
        std::vector<Corners> triangles;
        const double size = count > 20 ? 0.3 : 1.0;
        for (int i = 0; i < count; ++i) {
            Corners t;
            const glm::dvec2 at = (1.0 - size) * glm::dvec2(unit(random), unit(random));
            for (int k = 0; k < 3; ++k)
                t.push_back(at + size * glm::dvec2(unit(random), unit(random)));
            const glm::dvec2 u = t[1] - t[0], v = t[2] - t[0];
            if (u.x * v.y - u.y * v.x < 0.0) std::swap(t[1], t[2]);
            triangles.push_back(t);
        }
        constexpr int kLines = 20000;
        double sum = 0.0;
        for (int i = 0; i < kLines; ++i) sum += length(triangles, (i + 0.5) / kLines);
        // The midpoint rule on some hundred linear pieces; steep bends at sharp corners.
        EXPECT_NEAR(area(triangles), sum / kLines, 3e-6) << count;
    }
}

}  // namespace
}  // namespace penumbra
