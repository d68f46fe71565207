#pragma once

#include <glm/gtc/constants.hpp>

#include "core/frame/light_view.hpp"
#include "tests/support/render.hpp"

/// Set-ups that the tests of several methods share.
namespace penumbra::test {

/// A half plane in z = heightM that hides the light from the floor z = 0 beyond `edgeM` along
/// `axis` (0 x, 1 y), where the light is `light` in z = 2: METHODS.md R2.2.
struct HalfPlane {
    static constexpr double kLightM = 2.0;
    double heightM = 0.5;
    int axis = 0;
    double edgeM = 0.1;  ///< of the shadow of the light's centre, on the floor

    World world(double lightWidthM, double lightLengthM) const {
        const double casterEdgeM = edgeM * (kLightM - heightM) / kLightM;
        Shape shape;
        shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
        shape.rectangle(axis == 0 ? glm::dvec2(casterEdgeM, -5.0) : glm::dvec2(-5.0, casterEdgeM),
                        {5.0, 5.0}, heightM);
        return {shape.geometry(), lightAbove(kLightM, lightWidthM, lightLengthM)};
    }
    TestFrame frame(double lightWidthM, double lightLengthM, int size = 96) const {
        const World made = world(lightWidthM, lightLengthM);
        return {made,
                planeGBuffer(size, size, {-0.8, -0.8, 0.0}, {1.6, 0, 0}, {0, 1.6, 0}, made.light)};
    }
    /// Where pixel `i` lies across the edge.
    double across(const TestFrame& frame, std::size_t i) const {
        return static_cast<double>(frame->gbuffer.position[i][axis]);
    }
};

/// Side of a texel on a receiver in depth `zM` of the light's front view, the greater of the two.
inline double texelM(const TestFrame& frame, double guardM, int mapSize, double zM) {
    const glm::dvec2 size =
        LightView::fit(*frame, glm::dvec2(guardM), mapSize).tiles[0].tangentSize() * zM;
    return std::max(size.x, size.y) / mapSize;
}

/// A plane through the origin, steep by `tiltDeg` towards azimuth 30 degrees, under a light of
/// `lightM` in z = 3; and a floor below it, so that the light's view is not fitted to the plane.
/// Its points come first in the G-buffer.
struct TiltedPlane {
    static constexpr int kWidth = 64, kPixels = kWidth * kWidth;
    double tiltDeg = 0.0;

    TestFrame frame(double lightM) const {
        const double tilt = glm::radians(tiltDeg), azimuth = glm::radians(30.0);
        const glm::dvec3 up(std::cos(tilt) * std::cos(azimuth), std::cos(tilt) * std::sin(azimuth),
                            std::sin(tilt));
        const glm::dvec3 along(-std::sin(azimuth), std::cos(azimuth), 0.0);
        Shape shape;
        shape.quad(-1.5 * (up + along), 1.5 * (up - along), 1.5 * (up + along), 1.5 * (along - up));
        shape.rectangle({-2.0, -2.0}, {2.0, 2.0}, -2.0);
        const AreaLight light = lightAbove(3.0, lightM, lightM);
        return {{shape.geometry(), light},
                stacked({planeGBuffer(kWidth, kWidth, -up - along, 2.0 * up, 2.0 * along, light),
                         planeGBuffer(kWidth, 8, {-2, -2, -2}, {4, 0, 0}, {0, 4, 0}, light)})};
    }
};

}  // namespace penumbra::test
