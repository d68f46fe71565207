// A camera that looks at a small part of a large scene: light views are fitted to what it sees, and
// every method with maps is as accurate as if the rest of the scene were not there.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>

#include "tests/support/gl_fixture.hpp"
#include "tests/support/render.hpp"

namespace penumbra {
namespace {

using namespace test;

constexpr int kSize = 64;

/// Boxes on a floor of `halfM` about the origin, of which the camera sees some four metres.
World boxesOnFloor(double halfM, double lightTiltDeg) {
    Shape shape;
    shape.rectangle({-halfM, -halfM}, {halfM, halfM}, 0.0);
    shape.box({-0.6, -0.3, 0.3}, {-0.2, 0.4, 0.5});
    shape.box({0.2, -0.5, 0.0}, {0.5, -0.2, 0.6});
    shape.sphere({0.5, 0.5, 0.4}, 0.25, 12);
    AreaLight light = lightAbove(0.0, 0.5, 0.4);
    const double tilt = glm::radians(lightTiltDeg);
    // The normal points from the light's place to the origin; axisU stays horizontal.
    light.centre = 3.0 * glm::dvec3(0.0, -std::sin(tilt), std::cos(tilt));
    light.axisV = glm::dvec3(0.0, -std::cos(tilt), -std::sin(tilt));
    World world{shape.geometry(), light};
    world.camera = lookingAt({0.3, -1.2, 3.2}, {0.0, 0.1, 0.1});
    return world;
}

double rmse(const TestFrame& frame, const Visibility& image, const Visibility& truth) {
    double sum = 0.0;
    const std::vector<std::size_t> asked = frame.asked();
    for (const std::size_t i : asked) sum += std::pow(double{image[i]} - truth[i], 2.0);
    return std::sqrt(sum / static_cast<double>(asked.size()));
}

bool hasMaps(const ShadowMethod& method) {
    return std::ranges::any_of(method.parameters(), [](const Parameter* parameter) {
        return parameter->id() == "map_size";
    });
}

class LargeExtent : public GlTest,
                    public ::testing::WithParamInterface<std::tuple<std::string, double>> {};

INSTANTIATE_TEST_SUITE_P(Methods, LargeExtent,
                         ::testing::Combine(::testing::ValuesIn([] {
                                                std::vector<std::string> ids;
                                                for (const MethodInfo& method : methodRegistry())
                                                    if (hasMaps(*method.make()))
                                                        ids.push_back(method.id);
                                                return ids;
                                            }()),
                                            ::testing::Values(0.0, 35.0)),
                         [](const auto& of) {
                             return std::get<0>(of.param) + "_light_tilted_" +
                                    std::to_string(static_cast<int>(std::get<1>(of.param)));
                         });

TEST_P(LargeExtent, CostsNoAccuracyWhereTheCameraLooks) {
    const auto& [method, tiltDeg] = GetParam();
    const TestFrame small(boxesOnFloor(2.5, tiltDeg), kSize);
    // The camera sees floor and boxes only.
    ASSERT_EQ(small->gbuffer.count(PixelClass::background), 0u);
    const TestFrame large(boxesOnFloor(2500.0, tiltDeg), kSize);
    // Plans of their own could skip different things; the maps are what this is about.
    const Visibility truth =
        render(small, "ray_traced", {{"rays", "1024"}}, EffectChoice::parse("all"));
    const auto error = [&](const TestFrame& frame) {
        return rmse(frame, render(frame, method, {}, EffectChoice::parse("all")), truth);
    };
    const double alone = error(small), amid = error(large);
    // The views agree to rounding, but for nearM, which is that of the nearest vertex anywhere and
    // decides what rounding there is. A map that held all of the floor would have texels of metres
    // and an error of some tenths.
    EXPECT_NEAR(amid, alone, 0.05 * alone + 5e-4) << "alone " << alone;
}

}  // namespace
}  // namespace penumbra
