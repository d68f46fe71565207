#include "harness/exchange/alignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace penumbra {
namespace {

constexpr int kWidth = 96, kHeight = 80;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A row-major image of `value(x, y)`.
template <class T>
std::vector<T> drawn(const std::function<T(int, int)>& value) {
    std::vector<T> out;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) out.push_back(value(x, y));
    return out;
}

/// The frame: a surface in the shape of a lopsided disc on background, so that no flip maps it to
/// itself; a round shadow on it.
bool isSurface(int x, int y) {
    const bool tab = x > 60 && x < 70 && y < 40;
    return std::hypot(x - 45.5, y - 36.5) < 25.0 || tab;
}
float visibilityAt(int x, int y) {
    const double d = std::hypot(x - 40.0, y - 30.0);
    return static_cast<float>(std::clamp(0.1 * (d - 8.0), 0.0, 1.0));
}

GBuffer frameWith(bool background) {
    GBuffer g;
    g.width = kWidth;
    g.height = kHeight;
    const std::size_t pixels = std::size_t{kWidth} * kHeight;
    g.position.resize(pixels, glm::vec3(0));
    g.geometricNormal.resize(pixels, glm::vec3(0, 1, 0));
    g.shadingNormal = g.geometricNormal;
    g.albedo.resize(pixels, glm::vec3(0.5f));
    g.irradianceUnshadowed.resize(pixels, 1.0f);
    g.mask = drawn<PixelClass>([&](int x, int y) {
        return !background || isSurface(x, y) ? PixelClass::scored : PixelClass::background;
    });
    return g;
}

Reference referenceOf(const GBuffer& g) {
    Reference r = unshadowedReference(g);
    r.visibility = drawn<float>(visibilityAt);
    return r;
}

OutsideImage imageOf(const std::function<float(int, int)>& visibility) {
    OutsideImage image;
    image.name = "mine.exr";
    image.width = kWidth;
    image.height = kHeight;
    image.visibility = drawn<float>(visibility);
    return image;
}
OutsideImage coveredBy(const std::function<bool(int, int)>& surface) {
    OutsideImage image = imageOf([](int, int) { return 1.0f; });
    image.covered = drawn<std::uint8_t>([&](int x, int y) { return surface(x, y); });
    return image;
}

std::string coverage(const OutsideImage& image, const GBuffer& g) {
    return coverageDisplacement(image, g).value_or("");
}
std::string visibility(const OutsideImage& image) {
    const GBuffer g = frameWith(false);
    return visibilityDisplacement(image, g, referenceOf(g)).value_or("");
}

// ---- coverage ----------------------------------------------------------------------------------

TEST(Alignment, CoverageInPlaceIsAccepted) {
    const GBuffer g = frameWith(true);
    EXPECT_EQ(coverage(coveredBy(isSurface), g), "");
    // Another rule for single pixels of the outline.
    EXPECT_EQ(coverage(coveredBy([](int x, int y) {
                           return isSurface(x, y) && (isSurface(x - 1, y) || x % 4 != 0);
                       }),
                       g),
              "");
}

TEST(Alignment, ADisplacedCoverageIsNamedWithTheWayBack) {
    const GBuffer g = frameWith(true);
    const std::string moved =
        coverage(coveredBy([](int x, int y) { return isSurface(x + 2, y - 1); }), g);
    EXPECT_TRUE(moved.starts_with("mine.exr: coverage differs from the frame's in ")) << moved;
    EXPECT_TRUE(moved.ends_with("; moved by (+2, -1) pixels (right, down) it would in 0.00 %"))
        << moved;
    EXPECT_NE(coverage(coveredBy([](int x, int y) { return isSurface(x - 1, y); }), g)
                  .find("moved by (-1, +0)"),
              std::string::npos);
    const auto turned = [&](bool upsideDown, bool mirrored) {
        return coverage(coveredBy([=](int x, int y) {
                            return isSurface(mirrored ? kWidth - 1 - x : x,
                                             upsideDown ? kHeight - 1 - y : y);
                        }),
                        g);
    };
    EXPECT_TRUE(turned(true, false).ends_with("; turned upside down it would in 0.00 %"));
    EXPECT_TRUE(turned(false, true).ends_with("; mirrored left to right it would in 0.00 %"));
    EXPECT_TRUE(turned(true, true).ends_with("; turned by 180 degrees it would in 0.00 %"));
}

TEST(Alignment, HalfAPixelIsTooMuch) {
    const GBuffer g = frameWith(true);
    // Every other pixel of the left and right outline changes, as when edges lie half a pixel off.
    EXPECT_NE(coverage(coveredBy([](int x, int y) { return isSurface(x + y % 2, y); }), g), "");
}

TEST(Alignment, AnotherShapeIsNoDisplacement) {
    const std::string other =
        coverage(coveredBy([](int x, int y) { return (x / 8 + y / 8) % 2 == 0; }), frameWith(true));
    EXPECT_NE(other.find("no shift within 16 pixels and no flip explains it"), std::string::npos)
        << other;
}

TEST(Alignment, NansMarkTheBackgroundOnlyWhereThereIsOne) {
    const GBuffer g = frameWith(true);
    const auto nanBeyond = [](int dx) {
        return imageOf([dx](int x, int y) { return isSurface(x + dx, y) ? 1.0f : kNan; });
    };
    EXPECT_EQ(coverage(nanBeyond(0), g), "");
    EXPECT_NE(coverage(nanBeyond(3), g).find("moved by (+3, +0)"), std::string::npos);
    // A defect in a frame full of surfaces, or within the surface.
    EXPECT_EQ(coverage(nanBeyond(0), frameWith(false)), "");
    EXPECT_EQ(coverage(imageOf([](int x, int) { return x == 45 ? kNan : 1.0f; }), g), "");
}

TEST(Alignment, WhatOthersMayLightEitherWayIsNotCompared) {
    GBuffer g = frameWith(true);
    const auto litExcept = [&](PixelClass c) {
        OutsideImage image = coveredBy(isSurface);
        image.coverageIsLit = true;
        for (std::size_t i = 0; i < g.size(); ++i)
            if (g.mask[i] == c) image.covered[i] = 0;
        return image;
    };
    const auto lowerHalf = [&](auto change) {
        for (std::size_t i = g.size() / 2; i < g.size(); ++i)
            if (g.mask[i] != PixelClass::background) change(i);
    };
    lowerHalf([&](std::size_t i) { g.mask[i] = PixelClass::facingAway; });
    EXPECT_EQ(coverage(litExcept(PixelClass::facingAway), g), "");
    EXPECT_NE(coverage(litExcept(PixelClass::scored), g), "") << "lit from the other side";
    lowerHalf([&](std::size_t i) { g.mask[i] = PixelClass::horizon; });
    EXPECT_EQ(coverage(litExcept(PixelClass::horizon), g), "");
    lowerHalf([&](std::size_t i) { g.mask[i] = PixelClass::scored; });
    EXPECT_NE(coverage(coveredBy([](int, int y) { return y < kHeight / 2; }), g), "");
    lowerHalf([&](std::size_t i) { g.albedo[i] = glm::vec3(1e-5f); });  // black in 8 bits
    OutsideImage dark = coveredBy([](int x, int y) { return isSurface(x, y) && y < kHeight / 2; });
    dark.coverageIsLit = true;
    EXPECT_EQ(coverage(dark, g), "");
}

TEST(Alignment, ABackdropOrAmbientLightIsNoSurfaceElsewhere) {
    GBuffer g = frameWith(true);
    OutsideImage everywhere = coveredBy([](int, int) { return true; });
    everywhere.coverageIsLit = true;
    EXPECT_EQ(coverage(everywhere, g), "");
    for (std::size_t i = g.size() / 2; i < g.size(); ++i)
        if (g.mask[i] != PixelClass::background) g.mask[i] = PixelClass::facingAway;
    EXPECT_EQ(coverage(everywhere, g), "");
    OutsideImage sky = everywhere;  // a bright backdrop, but no light from behind
    for (std::size_t i = 0; i < g.size(); ++i)
        if (g.mask[i] == PixelClass::facingAway) sky.covered[i] = 0;
    EXPECT_EQ(coverage(sky, g), "");
    std::ranges::reverse(sky.covered);
    EXPECT_NE(coverage(sky, g), "");
}

// ---- visibility --------------------------------------------------------------------------------

TEST(Alignment, VisibilityInPlaceIsAcceptedHoweverBad) {
    EXPECT_EQ(visibility(imageOf(visibilityAt)), "");
    EXPECT_EQ(visibility(imageOf([](int, int) { return 1.0f; })), "");
    EXPECT_EQ(visibility(imageOf([](int x, int y) { return 1.0f - visibilityAt(x, y); })), "");
    // Hard, and hard in blocks of 4 pixels.
    EXPECT_EQ(
        visibility(imageOf([](int x, int y) { return visibilityAt(x, y) < 0.5f ? 0.0f : 1.0f; })),
        "");
    EXPECT_EQ(visibility(imageOf([](int x, int y) {
                  return visibilityAt(x / 4 * 4 + 2, y / 4 * 4 + 2) < 0.5f ? 0.0f : 1.0f;
              })),
              "");
}

TEST(Alignment, ADisplacedVisibilityIsNamedWithTheNumbers) {
    const std::string moved =
        visibility(imageOf([](int x, int y) { return visibilityAt(x - 3, y + 5); }));
    EXPECT_TRUE(moved.starts_with("mine.exr: the rmse against the reference is 0.")) << moved;
    EXPECT_TRUE(moved.ends_with("; moved by (-3, +5) pixels (right, down) it would be 0.0000"))
        << moved;
    EXPECT_TRUE(visibility(imageOf([](int x, int y) {
                    return visibilityAt(x, kHeight - 1 - y);
                })).ends_with("; turned upside down it would be 0.0000"));
    EXPECT_TRUE(visibility(imageOf([](int x, int y) {
                    return visibilityAt(kWidth - 1 - x, y);
                })).ends_with("; mirrored left to right it would be 0.0000"));
    EXPECT_NE(visibility(imageOf([](int x, int y) { return visibilityAt(x - 1, y); })), "");
}

}  // namespace
}  // namespace penumbra
