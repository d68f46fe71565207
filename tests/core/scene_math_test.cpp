#include <cmath>
#include <numbers>

#include "core/scene/animation.hpp"
#include "core/scene/placement.hpp"
#include "tests/core/scene_files.hpp"

namespace penumbra::testing {
namespace {

using namespace scene_detail;

// --- material.hpp --------------------------------------------------------------------------------

/// Two texels wide, one high: black with alpha 0, white with alpha 255.
TextureImage twoTexels(Wrap wrap, bool linear) {
    TextureImage image;
    image.width = 2;
    image.height = 1;
    image.rgba = {0, 0, 0, 0, 255, 255, 255, 255};
    image.wrapS = image.wrapT = wrap;
    image.linear = linear;
    return image;
}

float alphaAt(const TextureImage& image, float u) {
    Material material;
    material.baseColorTexture = 0;
    return baseColorAt(material, {image}, {u, 0.5f}).a;
}

TEST(SceneMath, BilinearTexelCentresAreAtHalves) {
    const TextureImage image = twoTexels(Wrap::clampToEdge, true);
    EXPECT_FLOAT_EQ(alphaAt(image, 0.25f), 0.0f);
    EXPECT_FLOAT_EQ(alphaAt(image, 0.75f), 1.0f);
    EXPECT_FLOAT_EQ(alphaAt(image, 0.5f), 0.5f);
    EXPECT_FLOAT_EQ(alphaAt(image, 0.0f), 0.0f);
    EXPECT_FLOAT_EQ(alphaAt(image, 1.0f), 1.0f);
}

TEST(SceneMath, WrapsContinueTheTextureAsGlDoes) {
    const TextureImage repeat = twoTexels(Wrap::repeat, true);
    EXPECT_FLOAT_EQ(alphaAt(repeat, 0.0f), 0.5f);  // between the last texel and the first
    EXPECT_FLOAT_EQ(alphaAt(repeat, 3.25f), 0.0f);
    EXPECT_FLOAT_EQ(alphaAt(repeat, -0.25f), 1.0f);
    const TextureImage mirrored = twoTexels(Wrap::mirroredRepeat, true);
    EXPECT_FLOAT_EQ(alphaAt(mirrored, 0.0f), 0.0f);
    EXPECT_FLOAT_EQ(alphaAt(mirrored, 1.25f), 1.0f);
    EXPECT_FLOAT_EQ(alphaAt(mirrored, 1.75f), 0.0f);
    EXPECT_FLOAT_EQ(alphaAt(mirrored, -0.75f), 1.0f);
    const TextureImage clamped = twoTexels(Wrap::clampToEdge, true);
    EXPECT_FLOAT_EQ(alphaAt(clamped, 7.0f), 1.0f);
    EXPECT_FLOAT_EQ(alphaAt(clamped, -7.0f), 0.0f);
}

TEST(SceneMath, NearestTakesTheTexelThatCovers) {
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirroredRepeat, Wrap::clampToEdge}) {
        const TextureImage image = twoTexels(wrap, false);
        EXPECT_FLOAT_EQ(alphaAt(image, 0.49f), 0.0f);
        EXPECT_FLOAT_EQ(alphaAt(image, 0.51f), 1.0f);
    }
    // u - floor(u) rounds to 1 here; it must wrap to the first texel, not read beyond the last.
    EXPECT_FLOAT_EQ(alphaAt(twoTexels(Wrap::repeat, false), -1e-9f), 0.0f);
}

TEST(SceneMath, ColourIsDecodedFromSrgbBeforeFiltering) {
    TextureImage image = twoTexels(Wrap::clampToEdge, true);
    image.rgba[0] = 188;  // a linear 0.5029 by IEC 61966-2-1
    Material material;
    material.baseColorTexture = 0;
    material.baseColor = {0.5f, 1, 1, 1};
    const double decoded = std::pow((188 / 255.0 + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(baseColorAt(material, {image}, {0.25f, 0}).r, 0.5 * decoded, 1e-6);
    EXPECT_NEAR(baseColorAt(material, {image}, {0.5f, 0}).r, 0.5 * 0.5 * (decoded + 1), 1e-6);
}

TEST(SceneMath, TopRowIsVZero) {
    TextureImage image;
    image.width = 1;
    image.height = 2;
    image.rgba = {0, 0, 0, 10, 0, 0, 0, 20};
    image.linear = false;
    Material material;
    material.baseColorTexture = 0;
    EXPECT_FLOAT_EQ(baseColorAt(material, {image}, {0.5f, 0.25f}).a, 10 / 255.0f);
    EXPECT_FLOAT_EQ(baseColorAt(material, {image}, {0.5f, 0.75f}).a, 20 / 255.0f);
}

// --- camera.hpp ----------------------------------------------------------------------------------

TEST(SceneMath, PerspectiveRaysSpanTheAngles) {
    Camera camera;
    camera.position = {1, 2, 3};
    camera.fovYRad = 2 * std::atan(0.5);
    camera.nearM = 2;
    camera.farM = 4;
    const CameraRay centre = cameraRay(camera, 100, 50, 200, 100);
    expectNear(centre.origin, {1, 2, 3}, 0);
    expectNear(centre.direction, {0, 0, -1}, 1e-15);
    EXPECT_DOUBLE_EQ(centre.tNear, 2);
    // Twice as wide as high: the top left corner lies at (-1, 0.5, -1).
    const CameraRay corner = cameraRay(camera, 0, 0, 200, 100);
    expectNear(corner.direction, glm::normalize(glm::dvec3(-1, 0.5, -1)), 1e-15);
    EXPECT_NEAR(corner.tNear * -corner.direction.z, 2, 1e-12);
    EXPECT_NEAR(corner.tFar * -corner.direction.z, 4, 1e-12);
}

TEST(SceneMath, OrthographicRaysAreParallel) {
    Camera camera;
    camera.kind = Camera::Kind::orthographic;
    camera.magY = 3;
    camera.nearM = 0.5;
    camera.farM = 8;
    const CameraRay ray = cameraRay(camera, 200, 100, 200, 100);  // bottom right
    expectNear(ray.origin, {6, -3, 0}, 1e-12);
    expectNear(ray.direction, {0, 0, -1}, 0);
    EXPECT_DOUBLE_EQ(ray.tNear, 0.5);
    EXPECT_DOUBLE_EQ(ray.tFar, 8);
}

// --- geometry.hpp --------------------------------------------------------------------------------

TEST(SceneMath, PartOfFindsTheRange) {
    Geometry geometry;
    for (const std::uint32_t count : {6u, 3u, 30u}) {
        Part part;
        part.firstIndex = geometry.parts.empty()
                              ? 0
                              : geometry.parts.back().firstIndex + geometry.parts.back().indexCount;
        part.indexCount = count;
        geometry.parts.push_back(part);
    }
    const std::vector<std::size_t> expected = {0, 0, 1, 2, 2};
    for (std::uint32_t t = 0; t < expected.size(); ++t) EXPECT_EQ(geometry.partOf(t), expected[t]);
    EXPECT_EQ(geometry.partOf(12), 2u);
}

TEST(SceneMath, BoundsHoldAllPoints) {
    const Bounds bounds = boundsOf({{1, 2, 3}, {-1, 4, 0}});
    expectNear(bounds.lo, {-1, 2, 0}, 0);
    expectNear(bounds.hi, {1, 4, 3}, 0);
    EXPECT_TRUE(boundsOf({}).empty());
    EXPECT_EQ(boundsOf({}).radius(), 0.0);
}

// --- Curves --------------------------------------------------------------------------------------

TEST(SceneMath, LinearAndStepCurvesHoldTheirEnds) {
    Curve curve{{1, 2, 4}, {{0, 0, 0, 0}, {10, 0, 0, 0}, {30, 0, 0, 0}}};
    EXPECT_DOUBLE_EQ(curve.at(0).x, 0);
    EXPECT_DOUBLE_EQ(curve.at(1.5).x, 5);
    EXPECT_DOUBLE_EQ(curve.at(2).x, 10);
    EXPECT_DOUBLE_EQ(curve.at(3).x, 20);
    EXPECT_DOUBLE_EQ(curve.at(9).x, 30);
    curve.interpolation = Interpolation::step;
    EXPECT_DOUBLE_EQ(curve.at(1.999).x, 0);
    EXPECT_DOUBLE_EQ(curve.at(2).x, 10);
    EXPECT_DOUBLE_EQ(curve.at(3.9).x, 10);
    EXPECT_DOUBLE_EQ(curve.at(4).x, 30);
}

TEST(SceneMath, CubicSplineHasTheGivenTangents) {
    // In-tangent, value, out-tangent: a cubic with value t^3 on [0, 2], slope 0 and 12.
    const Curve curve{
        {0, 2},
        {{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}, {12, 0, 0, 0}, {8, 0, 0, 0}, {0, 0, 0, 0}},
        Interpolation::cubicSpline};
    for (const double t : {0.0, 0.3, 1.0, 1.7, 2.0}) EXPECT_NEAR(curve.at(t).x, t * t * t, 1e-12);
}

TEST(SceneMath, RotationsTakeTheShortWayAtConstantSpeed) {
    // From no turn to 90 degrees about Z, the second written with the opposite sign.
    const double s = std::sqrt(0.5);
    const Curve curve{{0, 1}, {{0, 0, 0, 1}, {0, 0, -s, -s}}, Interpolation::linear, true};
    Transform transform;
    transform.set(NodeProperty::rotation, curve.at(1.0 / 3));
    const double angle = std::numbers::pi / 6;
    expectNear(glm::dvec3(transform.matrix() * glm::dvec4(1, 0, 0, 1)),
               {std::cos(angle), std::sin(angle), 0}, 1e-12);
}

TEST(SceneMath, EulerAnglesTurnAboutXThenYThenZ) {
    Transform transform;
    transform.set(NodeProperty::eulerDegrees, {90, 0, 90, 0});
    // y -X-> z -Z-> z; z -X-> -y -Z-> x.
    expectNear(glm::dvec3(transform.matrix() * glm::dvec4(0, 1, 0, 1)), {0, 0, 1}, 1e-12);
    expectNear(glm::dvec3(transform.matrix() * glm::dvec4(0, 0, 1, 1)), {1, 0, 0}, 1e-12);
}

// --- Placement -----------------------------------------------------------------------------------

TEST(SceneMath, LightFacesItsTargetWithWidthAcrossUp) {
    for (const glm::dvec3 target : {glm::dvec3(1, 2, 3), {0, -5, 0}, {4, 0, 0}, {0, 3, 0.1}}) {
        const auto light = lightFacing({0, 0, 0}, target, std::nullopt, {2, 4});
        ASSERT_TRUE(light);
        expectNear(light->normal(), glm::normalize(target), 1e-12);
        EXPECT_DOUBLE_EQ(light->halfU, 1);
        EXPECT_DOUBLE_EQ(light->halfV, 2);
    }
    expectNear(lightFacing({0, 5, 0}, {0, 0, 0}, std::nullopt, {1, 1})->axisV, {0, 0, -1}, 1e-12);
    expectNear(lightFacing({5, 0, 0}, {0, 0, 0}, std::nullopt, {1, 1})->axisV, {0, 1, 0}, 1e-12);
    EXPECT_FALSE(lightFacing({1, 1, 1}, {1, 1, 1}, std::nullopt, {1, 1}));
    EXPECT_FALSE(lightFacing({0, 5, 0}, {0, 0, 0}, glm::dvec3(0, 1, 0), {1, 1}));
}

TEST(SceneMath, CameraLooksAtItsTarget) {
    const auto camera = cameraFacing({0, 0, 5}, {0, 0, 0}, std::nullopt, 1);
    ASSERT_TRUE(camera);
    expectNear(camera->right, {1, 0, 0}, 1e-12);
    expectNear(camera->up, {0, 1, 0}, 1e-12);
    const auto down = cameraFacing({0, 5, 0}, {0, 0, 0}, std::nullopt, 1);
    ASSERT_TRUE(down);
    expectNear(down->up, {0, 0, -1}, 1e-12);
    EXPECT_FALSE(cameraFacing({0, 5, 0}, {0, 0, 0}, glm::dvec3(0, 2, 0), 1));
}

}  // namespace
}  // namespace penumbra::testing
