#include "harness/viewer/light_handles.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "harness/viewer/camera_control.hpp"

namespace penumbra {
namespace {

constexpr double kRounding = 1e-9;  // of pixels and metres after a ray and a plane

class LightHandles : public ::testing::Test {
  protected:
    LightHandles() {
        light.centre = {0.2, 3.0, -0.1};
        light.axisU = {1, 0, 0};
        light.axisV = {0, 0, 1};  // shines down: axisU x axisV = -Y
        light.halfU = 0.5;
        light.halfV = 0.3;
        view.camera.position = {2.0, 4.0, 6.0};
        view.camera.back = glm::normalize(view.camera.position - light.centre);
        view.camera.right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), view.camera.back));
        view.camera.up = glm::cross(view.camera.back, view.camera.right);
        view.width = 800;
        view.height = 600;
    }
    glm::dvec2 seen(const glm::dvec3& point) const {
        return projected(view.camera, point, view.width, view.height).value();
    }
    glm::dvec3 placeOf(LightHandle handle) const {
        for (const HandlePoint& h : lightHandles(light, view))
            if (h.handle == handle) return h.at;
        ADD_FAILURE() << "no such handle";
        return {};
    }
    AreaLight drag(LightHandle handle, const glm::dvec3& from, const glm::dvec3& to) const {
        return draggedLight(light, handle, view, seen(from), seen(to));
    }

    AreaLight light;
    HandleView view;
};

TEST_F(LightHandles, EachIsPickedWhereItIsSeenAndNoneElsewhere) {
    const auto handles = lightHandles(light, view);
    for (const HandlePoint& h : handles)
        EXPECT_EQ(pickHandle(handles, view, seen(h.at), 5.0), h.handle);
    EXPECT_EQ(pickHandle(handles, view, {3.0, 3.0}, 5.0), LightHandle::none);
    const glm::dvec2 beside = seen(light.centre) + glm::dvec2(0.0, 4.0);
    EXPECT_EQ(pickHandle(handles, view, beside, 5.0), LightHandle::centre);
}

TEST_F(LightHandles, ArmsAreAsLongAsAskedFor) {
    // The centre is in the middle of the image, where an arm across the view is not foreshortened;
    // those of the world's axes are at most that long.
    for (const LightHandle handle : {LightHandle::alongX, LightHandle::alongY, LightHandle::alongZ})
        EXPECT_LE(glm::distance(seen(placeOf(handle)), seen(light.centre)), 1.2 * view.armPixels);
    EXPECT_GT(glm::distance(seen(placeOf(LightHandle::alongY)), seen(light.centre)),
              0.8 * view.armPixels);
}

TEST_F(LightHandles, ArrowsMoveAlongTheirAxisOnly) {
    const glm::dvec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const LightHandle handles[] = {LightHandle::alongX, LightHandle::alongY, LightHandle::alongZ};
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 tip = placeOf(handles[i]);
        const AreaLight after = drag(handles[i], tip, tip + 0.7 * axes[i]);
        EXPECT_NEAR(glm::distance(after.centre, light.centre + 0.7 * axes[i]), 0.0, kRounding);
        EXPECT_EQ(after.halfU, light.halfU);
        EXPECT_EQ(after.axisU, light.axisU);
    }
}

TEST_F(LightHandles, TheCentreFollowsTheHandAcrossTheImage) {
    const glm::dvec3 to = light.centre + 0.4 * view.camera.right - 0.2 * view.camera.up;
    const AreaLight after = drag(LightHandle::centre, light.centre, to);
    EXPECT_NEAR(glm::distance(after.centre, to), 0.0, kRounding);
}

TEST_F(LightHandles, AnEdgeFollowsTheHandAndTheOtherSideGoesTheOtherWay) {
    const glm::dvec3 edge = light.centre - light.halfU * light.axisU;
    const AreaLight wider = drag(LightHandle::widerU, edge, edge - 0.25 * light.axisU);
    EXPECT_NEAR(wider.halfU, 0.75, kRounding);
    EXPECT_EQ(wider.halfV, light.halfV);
    EXPECT_EQ(wider.centre, light.centre);
    const glm::dvec3 other = light.centre + light.halfV * light.axisV;
    EXPECT_NEAR(drag(LightHandle::widerV, other, other - 0.1 * light.axisV).halfV, 0.2, kRounding);
    // Through the centre and beyond: thin, never inside out.
    EXPECT_NEAR(drag(LightHandle::widerV, other, other - 2.0 * light.axisV).halfV,
                kLeastShrink * light.halfV, kRounding);
}

TEST_F(LightHandles, TheTipTurnsTheLightAndKeepsItsShape) {
    const glm::dvec3 tip = placeOf(LightHandle::aim);
    const AreaLight after =
        draggedLight(light, LightHandle::aim, view, seen(tip), seen(tip) + glm::dvec2(20.0, -50.0));
    EXPECT_NEAR(glm::dot(after.axisU, after.axisV), 0.0, kRounding);
    EXPECT_NEAR(glm::length(after.normal()), 1.0, kRounding);
    EXPECT_LT(glm::dot(after.normal(), light.normal()), 0.95);
    EXPECT_EQ(after.centre, light.centre);
    EXPECT_EQ(after.halfU, light.halfU);
    // The tip is where the hand is.
    light = after;
    EXPECT_NEAR(glm::distance(seen(placeOf(LightHandle::aim)), seen(tip) + glm::dvec2(20.0, -50.0)),
                0.0, 1e-6);
}

TEST_F(LightHandles, TwistingTurnsAboutTheNormal) {
    const glm::dvec3 from = light.centre + light.axisU, to = light.centre + light.axisV;
    const AreaLight after = drag(LightHandle::twist, from, to);
    EXPECT_NEAR(glm::distance(after.axisU, light.axisV), 0.0, kRounding);
    EXPECT_NEAR(glm::distance(after.normal(), light.normal()), 0.0, kRounding);
}

TEST_F(LightHandles, FacingTurnsByTheLeast) {
    for (const glm::dvec3 normal :
         {glm::dvec3(0, -1, 0), glm::dvec3(0, 1, 0), glm::normalize(glm::dvec3(1, -2, 3))}) {
        const AreaLight after = facing(light, normal);
        EXPECT_NEAR(glm::distance(after.normal(), normal), 0.0, kRounding);
        EXPECT_NEAR(glm::dot(after.axisU, after.axisV), 0.0, kRounding);
    }
}

TEST_F(LightHandles, ALightBehindTheCameraHasNone) {
    light.centre = view.camera.position + view.camera.back;
    EXPECT_TRUE(lightHandles(light, view).empty());
}

TEST_F(LightHandles, APointLightCanBeMoved) {
    light.halfU = light.halfV = 0.0;
    const auto handles = lightHandles(light, view);
    EXPECT_EQ(pickHandle(handles, view, seen(light.centre), 5.0), LightHandle::centre);
    EXPECT_TRUE(std::ranges::none_of(
        handles, [](const HandlePoint& h) { return h.handle == LightHandle::widerU; }));
}

}  // namespace
}  // namespace penumbra
