#include <gtest/gtest.h>

#include "tests/methods/test_worlds.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra {
namespace {

using namespace test;

class Hard : public GlTest {};

TEST_F(Hard, UnoccludedPlanesOfAnySlopeDoNotShadowThemselves) {
    for (const double tiltDeg : {0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0, 89.9}) {
        const TestFrame frame = TiltedPlane{tiltDeg}.frame(0.0);
        ASSERT_EQ(frame->gbuffer.mask[TiltedPlane::kPixels / 2], PixelClass::scored);
        for (const char* mapSize : {"64", "1024"})
            EXPECT_EQ(violations(frame, render(frame, "hard", {{"map_size", mapSize}}),
                                 [](float v, std::size_t i) {
                                     return i >= TiltedPlane::kPixels || v == 1.0f;
                                 }),
                      0)
                << tiltDeg << " degrees, map of " << mapSize;
    }
}

TEST_F(Hard, EdgeOfAHalfPlaneIsWhereItBelongs) {
    for (const double heightM : {0.01, 0.5, 1.0, 1.9})
        for (const double edgeM : {-0.31, 0.1, 0.104, 0.27})
            for (const int mapSize : {128, 1024}) {
                const HalfPlane caster{heightM, 0, edgeM};
                const TestFrame frame = caster.frame(0.0, 0.0, 256);
                const Visibility image =
                    render(frame, "hard", {{"map_size", std::to_string(mapSize)}});
                // The nearest texel's centre is looked up: half a texel, and a hundredth for
                // rounding.
                const double reachM = 0.51 * texelM(frame, 0.0, mapSize, HalfPlane::kLightM);
                EXPECT_EQ(violations(frame, image,
                                     [&](float v, std::size_t i) {
                                         const double x = caster.across(frame, i) - edgeM;
                                         return std::abs(x) < reachM || v == (x < 0 ? 1.0f : 0.0f);
                                     }),
                          0)
                    << heightM << " m high, edge at " << edgeM << ", map of " << mapSize;
            }
}

TEST_F(Hard, LightsExtentIsIgnored) {
    const HalfPlane caster;
    const TestFrame frame = caster.frame(0.6, 0.4);
    const Visibility image = render(frame, "hard");
    EXPECT_EQ(image, render(caster.frame(0.0, 0.0), "hard"));
    EXPECT_EQ(violations(frame, image, [](float v, auto) { return v == 0.0f || v == 1.0f; }), 0);
}

TEST_F(Hard, ContactShadowReachesTheFootWithinTheBias) {
    // A panel without thickness stands on the floor at x = 0, lit at 45 degrees: the shadow falls
    // towards +x. Its height over the ray equals the distance from its foot.
    AreaLight light = lightAbove(2.0, 0.0, 0.0);
    light.centre.x = -2.0;
    Shape shape;
    shape.rectangle({-1.0, -1.0}, {1.0, 1.0}, 0.0);
    shape.quad({0, -2, 0}, {0, 2, 0}, {0, 2, 1}, {0, -2, 1});
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(256, 8, {-0.1, -0.1, 0.0}, {0.2, 0, 0}, {0, 0.2, 0}, light));
    constexpr int kMapSize = 256;
    const double texel = texelM(frame, 0.0, kMapSize, 2.0);
    for (const double bias : {0.0, 0.5, 8.0}) {
        const Visibility image =
            render(frame, "hard", {{"map_size", "256"}, {"bias", std::to_string(bias)}});
        // The bias lifts the receiver by so many texels, along a ray that rises as it goes; the
        // texel asked may lie half a texel aside.
        const double gapM = (bias + 1.0) * texel;
        EXPECT_EQ(violations(frame, image,
                             [&](float v, std::size_t i) {
                                 const double x = frame->gbuffer.position[i].x;
                                 return x < -gapM ? v == 1.0f : x > gapM ? v == 0.0f : true;
                             }),
                  0)
            << bias << " texels of bias";
    }
}

TEST_F(Hard, MaskedCasterCastsItsCutOut) {
    // Four by four texels of no symmetry, a metre wide, half way up to the light.
    TextureImage image{"mask", 4, 4, {}, Wrap::clampToEdge, Wrap::clampToEdge, false};
    for (const char present : std::string("#..##.#....#.##."))
        image.rgba.insert(image.rgba.end(),
                          {255, 255, 255, present == '#' ? std::uint8_t{200} : std::uint8_t{50}});
    Material masked;
    masked.baseColorTexture = 0;
    masked.masked = true;
    Shape floor, caster;
    floor.rectangle({-1.2, -1.2}, {1.2, 1.2}, 0.0);
    caster.rectangle({-0.5, -0.5}, {0.5, 0.5}, 1.0);
    World world{joined({{floor, 0}, {caster, 1}}), lightAbove(2.0, 0.0, 0.0)};
    world.materials = {Material{}, masked};
    world.images = {image};
    const TestFrame frame(
        world, planeGBuffer(96, 96, {-0.98, -0.98, 0.0}, {1.96, 0, 0}, {0, 1.96, 0}, world.light));
    const double reachUv = texelM(frame, 0.0, 1024, 1.0);  // the caster is one metre wide
    const Visibility visibility = render(frame, "hard");
    EXPECT_EQ(
        violations(frame, visibility,
                   [&](float v, std::size_t i) {
                       const glm::vec2 uv = 0.5f * glm::vec2(frame->gbuffer.position[i]) + 0.5f;
                       const glm::vec2 inTexel = glm::fract(4.0f * uv);
                       const glm::vec2 edge = glm::min(inTexel, 1.0f - inTexel) / 4.0f;
                       if (std::min(edge.x, edge.y) < reachUv) return true;
                       return v == (baseColorAt(masked, world.images, uv).a >= masked.alphaCutoff
                                        ? 0.0f
                                        : 1.0f);
                   }),
        0);
    const Visibility asOpaque = render(frame, "hard", {}, EffectChoice::parse("none"));
    EXPECT_EQ(unequal(frame, asOpaque, 0.0f), 0) << "left out of the plan, the mask costs nothing";
}

}  // namespace
}  // namespace penumbra
