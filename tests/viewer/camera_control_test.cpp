#include "harness/viewer/camera_control.hpp"

#include <gtest/gtest.h>

namespace penumbra {
namespace {

// A few roundings of numbers of order 1 to 10.
constexpr double kRounding = 1e-12;

Camera tilted() {
    Camera camera;
    camera.position = {1.0, 2.0, 5.0};
    camera.back = glm::normalize(glm::dvec3(0.2, 0.3, 1.0));
    camera.right = glm::normalize(glm::cross(glm::dvec3(0.1, 1.0, 0.0), camera.back));
    camera.up = glm::cross(camera.back, camera.right);
    camera.fovYRad = 0.7;
    camera.nearM = 0.5;
    return camera;
}

void expectOrthonormal(const Camera& c) {
    EXPECT_NEAR(glm::length(c.right), 1.0, kRounding);
    EXPECT_NEAR(glm::length(c.up), 1.0, kRounding);
    EXPECT_NEAR(glm::length(c.back), 1.0, kRounding);
    EXPECT_NEAR(glm::dot(glm::cross(c.right, c.up), c.back), 1.0, kRounding);
}

TEST(CameraControl, OrbitingKeepsThePivotWhereItIsInTheImage) {
    const Camera camera = tilted();
    const glm::dvec3 pivot{0.3, 0.5, -0.2};
    const auto before = projected(camera, pivot, 640, 480);
    const Camera after = orbited(camera, pivot, 0.8, -0.3);
    expectOrthonormal(after);
    const auto now = projected(after, pivot, 640, 480);
    ASSERT_TRUE(before && now);
    EXPECT_NEAR(glm::distance(*before, *now), 0.0, 1e-9);  // pixels
    EXPECT_NEAR(glm::distance(after.position, pivot), glm::distance(camera.position, pivot),
                kRounding);
    EXPECT_GT(glm::distance(after.position, camera.position), 1.0);
    EXPECT_EQ(after.nearM, 0.0) << "clip distances cannot be said in a script";
}

TEST(CameraControl, NoPitchTurnsTheViewOverThePole) {
    Camera camera = tilted();
    // Level, so that pitching leads to the pole itself.
    camera.right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), camera.back));
    camera.up = glm::cross(camera.back, camera.right);
    for (int i = 0; i < 20; ++i) camera = turned(camera, 0.1, 0.4);
    expectOrthonormal(camera);
    EXPECT_LT(-camera.back.y, 1.0);
    EXPECT_GT(-camera.back.y, 0.99);
    for (int i = 0; i < 20; ++i) camera = orbited(camera, glm::dvec3(0.0), 0.0, -0.4);
    EXPECT_GT(-camera.back.y, -1.0);
    EXPECT_LT(-camera.back.y, -0.99);
}

TEST(CameraControl, MovesAlongItsOwnAxes) {
    const Camera camera = tilted();
    const Camera after = moved(camera, {1.0, 2.0, 3.0});
    const glm::dvec3 by = after.position - camera.position;
    EXPECT_NEAR(glm::dot(by, camera.right), 1.0, kRounding);
    EXPECT_NEAR(glm::dot(by, camera.up), 2.0, kRounding);
    EXPECT_NEAR(glm::dot(by, -camera.back), 3.0, kRounding);
}

TEST(CameraControl, ProjectionInvertsTheCameraRay) {
    for (const auto kind : {Camera::Kind::perspective, Camera::Kind::orthographic}) {
        Camera camera = tilted();
        camera.kind = kind;
        const CameraRay ray = cameraRay(camera, 123.25, 77.5, 640, 360);
        const auto seen = projected(camera, ray.origin + 4.0 * ray.direction, 640, 360);
        ASSERT_TRUE(seen);
        EXPECT_NEAR(seen->x, 123.25, 1e-9);
        EXPECT_NEAR(seen->y, 77.5, 1e-9);
    }
    EXPECT_FALSE(projected(tilted(), tilted().position + tilted().back, 10, 10));
}

TEST(CameraControl, APixelCoversWhatTwoProjectionsSay) {
    const Camera camera = tilted();
    const glm::dvec3 point = camera.position - 6.0 * camera.back;
    const double metres = metresPerPixel(camera, point, 480);
    const auto a = projected(camera, point, 640, 480);
    const auto b = projected(camera, point + metres * camera.right, 640, 480);
    EXPECT_NEAR(b->x - a->x, 1.0, 1e-9);
    EXPECT_EQ(metresPerPixel(camera, camera.position + camera.back, 480), 0.0);
}

TEST(CameraControl, BackingOffShowsTheWholeSphere) {
    const glm::dvec3 centre{0.0, 1.0, -2.0};
    for (const double aspect : {2.0, 0.5}) {
        const Camera camera = backedOff(tilted(), centre, 3.0, aspect);
        const int height = 500, width = static_cast<int>(height * aspect);
        for (const glm::dvec3 axis : {camera.right, -camera.right, camera.up, -camera.up}) {
            const auto seen = projected(camera, centre + 3.0 * axis, width, height);
            ASSERT_TRUE(seen);
            EXPECT_GE(seen->x, 0.0);
            EXPECT_LE(seen->x, width);
            EXPECT_GE(seen->y, 0.0);
            EXPECT_LE(seen->y, height);
        }
    }
}

TEST(CameraControl, DollyingGoesTowardsThePivot) {
    const Camera camera = tilted();
    const glm::dvec3 pivot{0.5, 0.5, 0.5};
    const Camera after = dollied(camera, pivot, 0.5);
    EXPECT_NEAR(glm::distance(after.position, pivot), 0.5 * glm::distance(camera.position, pivot),
                kRounding);
    EXPECT_NEAR(after.magY, 0.5 * camera.magY, kRounding);
}

}  // namespace
}  // namespace penumbra
