#include "core/frame/gbuffer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/procedural.hpp"

namespace penumbra {
namespace {

/// The irradiance by the midpoint rule over n x n pieces of the light.
double byQuadrature(const glm::dvec3& p, const glm::dvec3& normal, const AreaLight& light, int n) {
    double sum = 0.0;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const glm::dvec3 d = light.at((i + 0.5) / n, (j + 0.5) / n) - p;
            const double r2 = glm::dot(d, d);
            sum += std::max(0.0, glm::dot(normal, d)) *
                   std::max(0.0, -glm::dot(light.normal(), d)) / (r2 * r2);
        }
    return sum * light.area() / (static_cast<double>(n) * n);
}

const AreaLight kLight = test::lightAbove(3.0, 2.0, 1.0);

TEST(GBuffer, ClassesFollowFromTheLightsCorners) {
    const glm::dvec3 p(0.0), up(0, 0, 1);
    EXPECT_EQ(classify(p, up, kLight), PixelClass::scored);
    EXPECT_EQ(classify(p, -up, kLight), PixelClass::facingAway);
    // A wall through the light's middle sees one half of it.
    EXPECT_EQ(classify(p, {1, 0, 0}, kLight), PixelClass::horizon);
    EXPECT_EQ(classify({-1.5, 0, 0}, {1, 0, 0}, kLight), PixelClass::scored);
    EXPECT_EQ(classify({1.5, 0, 0}, {1, 0, 0}, kLight), PixelClass::facingAway);
}

TEST(GBuffer, PointsBehindTheLightFaceAway) {
    EXPECT_EQ(classify({0, 0, 4}, {0, 0, -1}, kLight), PixelClass::facingAway);
    EXPECT_EQ(classify({5, 0, 3}, {-1, 0, 0}, kLight), PixelClass::facingAway)
        << "in the light's own plane";
}

TEST(GBuffer, LightFlushWithTheSurfaceIsNotAboveIt) {
    // A ceiling beside the light it holds, with the rounding of a float normal.
    EXPECT_EQ(classify({5, 0, 3 - 1e-7}, glm::normalize(glm::dvec3(1e-8, 0, -1)), kLight),
              PixelClass::facingAway);
}

TEST(GBuffer, PointLightIsScoredOrNot) {
    const AreaLight point = test::lightAbove(3.0, 0.0, 0.0);
    EXPECT_EQ(classify({0, 0, 0}, {0, 0, 1}, point), PixelClass::scored);
    EXPECT_EQ(classify({0, 0, 0}, {0, 0, -1}, point), PixelClass::facingAway);
    EXPECT_EQ(classify({1, 0, 0}, {1, 0, 0}, point), PixelClass::facingAway);
}

TEST(GBuffer, ClassesDoNotDependOnScale) {
    for (const double scale : {1e-3, 1e3}) {
        AreaLight light = kLight;
        light.centre *= scale;
        light.halfU *= scale;
        light.halfV *= scale;
        for (double x = -4.0; x < 4.0; x += 0.37) {
            const glm::dvec3 p(x, 0.2, 0.1), normal = glm::normalize(glm::dvec3(1.0, 0.1, 0.2));
            EXPECT_EQ(classify(scale * p, normal, light), classify(p, normal, kLight)) << x;
        }
    }
}

TEST(GBuffer, IrradianceMatchesQuadratureAlsoAcrossTheHorizon) {
    const glm::dvec3 normals[] = {
        {0, 0, 1}, {1, 0, 0}, {0, -1, 0.2}, {0.7, 0.7, -0.1}, {-1, 0.3, 0.4}};
    for (const glm::dvec3& direction : normals) {
        const glm::dvec3 normal = glm::normalize(direction);
        for (const glm::dvec3& p :
             {glm::dvec3(0, 0, 0), glm::dvec3(0.9, -0.3, 2.0), glm::dvec3(-4, 2, -1)}) {
            const double exact = unshadowedIrradiance(p, normal, kLight);
            // The midpoint rule is off by (1/n)^2 where smooth, by about 1/n^2 of the light along a
            // horizon: both below 1e-5 of the greatest value, pi, at n = 1000.
            EXPECT_NEAR(exact, byQuadrature(p, normal, kLight, 1000), 1e-5 * std::numbers::pi)
                << direction.x << ' ' << p.x;
        }
    }
}

TEST(GBuffer, IrradianceHasItsKnownLimits) {
    const glm::dvec3 up(0, 0, 1);
    // An immense light fills the hemisphere: pi. What it misses is of the order (3 / 3000)^2.
    EXPECT_NEAR(unshadowedIrradiance({0, 0, 0}, up, test::lightAbove(3.0, 6000.0, 6000.0)),
                std::numbers::pi, 1e-5);
    EXPECT_EQ(unshadowedIrradiance({0, 0, 4}, -up, kLight), 0.0) << "behind the light";
    EXPECT_EQ(unshadowedIrradiance({0, 0, 0}, -up, kLight), 0.0) << "below the horizon";
}

TEST(GBuffer, PointLightIsTheLimitPerArea) {
    const glm::dvec3 p(0.4, -0.7, 0.1), normal = glm::normalize(glm::dvec3(0.2, 0.1, 1.0));
    const double limit = unshadowedIrradiance(p, normal, test::lightAbove(3.0, 0.0, 0.0));
    const glm::dvec3 d = glm::dvec3(0, 0, 3) - p;
    EXPECT_NEAR(limit, glm::dot(normal, d) * d.z / std::pow(glm::dot(d, d), 2.0), 1e-15);
    // The difference shrinks with the square of the size, also across the switch of formulas
    // near 1e-4 of the distance, where both are good to 1e-8.
    for (const double size : {1e-1, 1e-2, 1e-3, 4e-4, 1e-4, 1e-6}) {
        const AreaLight light = test::lightAbove(3.0, size, size);
        EXPECT_NEAR(unshadowedIrradiance(p, normal, light) / light.area() / limit, 1.0,
                    size * size + 3e-8)
            << size;
    }
}

/// A floor seen from above, one frame.
class Floor final : public Scene {
  public:
    Floor() {
        materials.resize(1);
        materials[0].baseColor = {0.2f, 0.4f, 0.6f, 1.0f};
        test::Shape shape;
        shape.rectangle({-1, -1}, {1, 1}, 0.0);
        frame_.geometry = shape.geometry();
        frame_.light = kLight;
        frame_.camera.kind = Camera::Kind::orthographic;
        frame_.camera.magY = 2.0;
        frame_.camera.position = {0, 0, 2};
    }
    int frameCount() const override { return 1; }
    SceneFrame frame(int) const override { return frame_; }

  private:
    SceneFrame frame_;
};

TEST(GBuffer, RendersPixelCentresOfTheCamera) {
    const Floor scene;
    const SceneFrame frame = scene.frame(0);
    const Tracer tracer(frame.geometry, scene.materials, scene.images);
    constexpr int kSize = 8;
    const GBuffer g = renderGBuffer(tracer, frame, scene, kSize, kSize);
    ASSERT_EQ(g.size(), static_cast<std::size_t>(kSize * kSize));
    EXPECT_EQ(g.count(PixelClass::scored), 16u) << "the floor fills half the width and height";
    EXPECT_EQ(g.count(PixelClass::background), 48u);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * kSize + x;
            const bool onFloor = x >= 2 && x < 6 && y >= 2 && y < 6;
            ASSERT_EQ(g.mask[i] == PixelClass::scored, onFloor);
            if (!onFloor) continue;
            EXPECT_EQ(g.position[i], glm::vec3(-1.75f + 0.5f * x, 1.75f - 0.5f * y, 0.0f));
            EXPECT_EQ(g.geometricNormal[i], glm::vec3(0, 0, 1));
            EXPECT_EQ(g.albedo[i], glm::vec3(0.2f, 0.4f, 0.6f));
            EXPECT_FLOAT_EQ(g.irradianceUnshadowed[i],
                            static_cast<float>(unshadowedIrradiance(glm::dvec3(g.position[i]),
                                                                    {0, 0, 1}, kLight)));
        }
}

}  // namespace
}  // namespace penumbra
