#include "harness/metrics/penumbra_width.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace penumbra {
namespace {

struct Scanline {
    std::vector<double> positionsM, visibility;

    /// Samples at i * stepM for i in 0..steps.
    Scanline(const std::function<double(double)>& profile, double stepM, int steps) {
        for (int i = 0; i <= steps; ++i) {
            positionsM.push_back(i * stepM);
            visibility.push_back(profile(i * stepM));
        }
    }
    std::optional<EdgeProfile> measured(EdgeShape shape = EdgeShape::rectangle) const {
        return measureEdge(positionsM, visibility, shape);
    }
};

double linear(double x, double centreM, double widthM) {
    return std::clamp((x - centreM) / widthM + 0.5, 0.0, 1.0);
}

/// The visible part of a disc light across a straight edge.
double disc(double x, double centreM, double widthM) {
    const double t = std::clamp(2 * (x - centreM) / widthM, -1.0, 1.0);
    return 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / std::numbers::pi;
}

TEST(MeasureEdge, LinearProfileIsExact) {
    // Crossings at 0.9 m and 1.7 m lie between samples, on straight pieces of the profile.
    const Scanline line([](double x) { return linear(x, 1.3, 1.0); }, 0.07, 40);
    const EdgeProfile edge = line.measured().value();
    EXPECT_NEAR(edge.widthM, 1.0, 1e-13);
    EXPECT_NEAR(edge.centreM, 1.3, 1e-13);
}

TEST(MeasureEdge, DiscProfileToTheErrorOfInterpolation) {
    // Over steps h of t the interpolation errs by at most h^2/8 max|V''| = h^2/8 * 2/pi *
    // t/sqrt(1-t^2), over the slope 2/pi sqrt(1-t^2); at t = 0.687 and h = 0.02 that is 0.00007 per
    // crossing and in t, of a width of 2.
    const Scanline line([](double x) { return disc(x, 1.3, 1.0); }, 0.01, 260);
    const EdgeProfile edge = line.measured(EdgeShape::disc).value();
    EXPECT_NEAR(edge.widthM, 1.0, 1e-4);
    EXPECT_NEAR(edge.centreM, 1.3, 1e-4);
}

TEST(MeasureEdge, ShadowMayLieOnEitherSide) {
    const Scanline rising([](double x) { return linear(x, 1.0, 0.6); }, 0.05, 40);
    const Scanline falling([](double x) { return 1 - linear(x, 1.0, 0.6); }, 0.05, 40);
    EXPECT_NEAR(rising.measured()->widthM, falling.measured()->widthM, 1e-13);
    EXPECT_NEAR(rising.measured()->centreM, falling.measured()->centreM, 1e-13);
}

TEST(MeasureEdge, AHardEdgeLiesBetweenItsSamples) {
    const std::vector<double> x{0, 1, 2, 3}, v{0, 0, 1, 1};
    const EdgeProfile edge = measureEdge(x, v).value();
    EXPECT_NEAR(edge.widthM, 1.0, 1e-13);
    EXPECT_NEAR(edge.centreM, 1.5, 1e-13);
}

TEST(MeasureEdge, DirtOutsideThePenumbraDoesNotCount) {
    Scanline line([](double x) { return linear(x, 2.0, 1.0); }, 0.1, 40);
    line.visibility[3] = 0.4;   // a leak in the umbra
    line.visibility[35] = 0.6;  // acne on lit ground
    EXPECT_NEAR(line.measured()->widthM, 1.0, 1e-13);
    EXPECT_NEAR(line.measured()->centreM, 2.0, 1e-13);
}

TEST(MeasureEdge, UndefinedWithoutUmbraOrLightOrNumbers) {
    const auto profile = [](double low, double high) {
        return Scanline([=](double x) { return std::clamp(x, low, high); }, 0.1, 10).measured();
    };
    EXPECT_TRUE(profile(0.0, 1.0));
    EXPECT_FALSE(profile(0.1, 1.0));
    EXPECT_FALSE(profile(0.0, 0.9));
    EXPECT_FALSE(profile(0.5, 0.5));
    EXPECT_FALSE(measureEdge({}, {}));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(measureEdge(std::vector<double>{0, 1, 2}, std::vector<double>{0, nan, 1}));
}

TEST(MeasureEdge, PositionsMustRise) {
    const std::vector<double> v{0, 0.5, 1};
    EXPECT_THROW(measureEdge(std::vector<double>{0, 0, 1}, v), std::invalid_argument);
    EXPECT_THROW(measureEdge(std::vector<double>{0, 2, 1}, v), std::invalid_argument);
    EXPECT_THROW(measureEdge(std::vector<double>{0, 1}, v), std::invalid_argument);
}

TEST(CompareEdges, InUnitsOfTheReferencesWidth) {
    const EdgeError error = compareEdges({3.0, 1.5}, {2.0, 1.0});
    EXPECT_DOUBLE_EQ(error.width, 0.5);
    EXPECT_DOUBLE_EQ(error.centreShift, 0.25);
}

}  // namespace
}  // namespace penumbra
