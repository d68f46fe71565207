#include "harness/report/grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/image/srgb.hpp"
#include "harness/report/shade.hpp"

namespace penumbra {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A disc's penumbra on a plane, a band of background above it.
struct Scenery {
    GBuffer gbuffer;
    Reference reference;

    explicit Scenery(int size = 64) {
        const auto pixels = static_cast<std::size_t>(size) * size;
        gbuffer.width = gbuffer.height = reference.width = reference.height = size;
        gbuffer.position.assign(pixels, glm::vec3(0));
        gbuffer.geometricNormal.assign(pixels, glm::vec3(0, 1, 0));
        gbuffer.shadingNormal = gbuffer.geometricNormal;
        gbuffer.albedo.assign(pixels, glm::vec3(0.5F));
        gbuffer.mask.assign(pixels, PixelClass::scored);
        gbuffer.irradianceUnshadowed.assign(pixels, 2.0F);
        reference.standardError.assign(pixels, 0.001F);
        reference.rays.assign(pixels, 1024.0F);
        for (int y = 0; y < size; ++y) {
            for (int x = 0; x < size; ++x) {
                const float r = std::hypot(x - 0.5F * size, y - 0.6F * size) / size;
                reference.visibility.push_back(std::clamp((r - 0.15F) / 0.2F, 0.0F, 1.0F));
                if (y < size / 8) {
                    gbuffer.mask[reference.visibility.size() - 1] = PixelClass::background;
                    gbuffer.irradianceUnshadowed[reference.visibility.size() - 1] = 0.0F;
                }
            }
        }
        reference.irradiance = reference.visibility;
        reference.irradianceUnshadowed = gbuffer.irradianceUnshadowed;
    }
    std::vector<float> shifted(float error) const {
        std::vector<float> v = reference.visibility;
        for (float& x : v) x += error;
        return v;
    }
};

Row okRow() {
    Row row;
    row.scene = "disc";
    row.method = row.setting = "hard";
    row.frameMs = 12.34;
    row.metrics.rmse = 0.0123;
    row.metrics.referenceSe = 0.001;
    return row;
}

std::size_t countPixels(const Image& image, const auto& wanted) {
    std::size_t n = 0;
    for (std::size_t i = 0; i + 2 < image.pixels.size(); i += 3) {
        n += wanted(glm::vec3(image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]));
    }
    return n;
}
bool isRed(const glm::vec3& c) {
    return c.r > 0.5F && c.g < 0.1F && c.b < 0.1F;
}
bool isBlue(const glm::vec3& c) {
    return c.b > 0.5F && c.g < 0.1F && c.r < 0.1F;
}
bool isMagenta(const glm::vec3& c) {
    return c.r > 0.9F && c.g < 0.1F && c.b > 0.9F;
}

TEST(ErrorColour, ZeroIsWhiteAndTheEndsAreRedAndBlue) {
    EXPECT_EQ(errorColour(0.0F), glm::vec3(1.0F));
    EXPECT_TRUE(isRed(errorColour(kErrorScale)));
    EXPECT_TRUE(isBlue(errorColour(-kErrorScale)));
}

TEST(ErrorColour, MovesAwayFromWhiteAllTheWayToTheEndOfTheScale) {
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 less = errorColour(kErrorScale * static_cast<float>(i) / 100);
        const glm::vec3 more = errorColour(kErrorScale * static_cast<float>(i + 1) / 100);
        EXPECT_LT(more.g, less.g) << i;
        EXPECT_LT(more.b, less.b) << i;
        EXPECT_LT(more.r, less.r) << i;
        EXPECT_GE(more.r, more.b) << i;
    }
    EXPECT_EQ(errorColour(0.9F), errorColour(kErrorScale));
    EXPECT_EQ(errorColour(-0.9F), errorColour(-kErrorScale));
}

TEST(ErrorColour, MirroredErrorsHaveRedAndBlueExchanged) {
    for (const float error : {0.001F, 0.05F, 0.125F, 0.25F, 2.0F}) {
        const glm::vec3 leak = errorColour(error), dark = errorColour(-error);
        EXPECT_EQ(leak, glm::vec3(dark.b, dark.g, dark.r)) << error;
    }
}

TEST(ErrorColour, NonfiniteIsMagenta) {
    EXPECT_TRUE(isMagenta(errorColour(kNan)));
    EXPECT_TRUE(isMagenta(errorColour(std::numeric_limits<float>::infinity())));
}

TEST(PictureLight, BrightPartMapsToTheWhitePoint) {
    Scenery s;
    const PictureLight light = pictureLight(s.gbuffer);
    const std::vector<float> lit(s.gbuffer.size(), 1.0F);
    const Image image = shadeVisibility(s.gbuffer, lit, light);
    // 0.8 and the 4 % of ambient light on top.
    EXPECT_NEAR(image.at(32, 40, 1), 0.8F * 1.04F, 1e-5F) << "float rounding of a few products";
}

TEST(PictureLight, AFrameWithoutLightStaysFinite) {
    Scenery s;
    s.gbuffer.irradianceUnshadowed.assign(s.gbuffer.size(), 0.0F);
    const PictureLight light = pictureLight(s.gbuffer);
    EXPECT_TRUE(std::isfinite(light.radiance));
    EXPECT_TRUE(std::isfinite(light.ambientIrradiance));
}

TEST(ShadeVisibility, UmbraIsDarkButNotBlackAndBackgroundIsNeutral) {
    const Scenery s;
    const Image image = shadeVisibility(s.gbuffer, s.reference.visibility, pictureLight(s.gbuffer));
    const float umbra = image.at(32, 38, 1);
    EXPECT_GT(umbra, 0.01F);
    EXPECT_LT(umbra, 0.1F * image.at(1, 60, 1));
    EXPECT_EQ(image.at(0, 0, 0), image.at(0, 0, 1));
    EXPECT_EQ(image.at(0, 0, 1), image.at(0, 0, 2));
}

TEST(ErrorMap, BackgroundIsToldApartFromEveryError) {
    const Scenery s;
    const Image map = errorMap(s.gbuffer, s.reference.visibility, s.reference);
    EXPECT_EQ(map.at(32, 32, 0), 1.0F) << "no error is white";
    for (int x = 0; x < map.width; ++x) {
        EXPECT_LT(map.at(x, 0, 0), 0.2F);
        EXPECT_EQ(map.at(x, 0, 0), map.at(x, 0, 2)) << "grey";
    }
}

TEST(ErrorMap, NonfinitePixelsAreMagentaInBothPictures) {
    const Scenery s;
    std::vector<float> v = s.reference.visibility;
    v[40 * 64 + 10] = kNan;
    EXPECT_EQ(countPixels(errorMap(s.gbuffer, v, s.reference), isMagenta), 1U);
    EXPECT_EQ(countPixels(shadeVisibility(s.gbuffer, v, pictureLight(s.gbuffer)), isMagenta), 1U);
}

TEST(ClassMap, PaintsEachClassInItsColour) {
    Scenery s;
    s.gbuffer.mask[63 * 64] = PixelClass::horizon;
    const Image map = classMap(s.gbuffer, s.reference);
    const auto colourAt = [&](int x, int y) {
        return glm::vec3(map.at(x, y, 0), map.at(x, y, 1), map.at(x, y, 2));
    };
    EXPECT_EQ(colourAt(2, 62), classColours()[0].rgb) << "lit";
    EXPECT_EQ(colourAt(32 + 16, 38), classColours()[1].rgb) << "penumbra";
    EXPECT_EQ(colourAt(32, 38), classColours()[2].rgb) << "umbra";
    EXPECT_EQ(colourAt(0, 63), classColours()[3].rgb) << "horizon";
    EXPECT_EQ(map.at(0, 0, 0), map.at(0, 0, 1)) << "background is grey";
}

/// A grid of one scenery whose cells all show `visibility`.
Image gridOf(const Scenery& s, const Row& row, std::size_t cells,
             const std::vector<float>& visibility, std::size_t frames = 1) {
    GridFrame frame{0, &s.gbuffer, &s.reference, {}};
    frame.cells.assign(cells, GridCell{&row, visibility});
    const GridPicture grid = renderGrid("disc", "a disc", std::vector<GridFrame>(frames, frame));
    Image image = Image::withChannels(grid.width, grid.height, {"R", "G", "B"});
    EXPECT_EQ(grid.rgb.size(), image.pixels.size());
    std::ranges::transform(grid.rgb, image.pixels.begin(), linearOf);
    return image;
}

TEST(RenderGrid, WidthFollowsTheColumns) {
    const Scenery s;
    const Row row = okRow();
    const auto widthOf = [&](std::size_t cells) {
        return gridOf(s, row, cells, s.reference.visibility).width;
    };
    const int margins = 2 * 24, gap = 12;
    EXPECT_EQ(widthOf(1), margins + 2 * 384 + gap);
    EXPECT_EQ(widthOf(5), margins + 6 * 384 + 5 * gap);
    EXPECT_EQ(widthOf(6), margins + 7 * 256 + 6 * gap) << "smaller tiles";
    EXPECT_EQ(widthOf(11), margins + 12 * 256 + 11 * gap);
    EXPECT_EQ(widthOf(30), widthOf(11)) << "wraps";
}

TEST(RenderGrid, LinesAndFramesStack) {
    const Scenery s;
    const Row row = okRow();
    const auto heightOf = [&](std::size_t cells, std::size_t frames) {
        return gridOf(s, row, cells, s.reference.visibility, frames).height;
    };
    const int line = heightOf(12, 1) - heightOf(11, 1);
    EXPECT_GT(line, 2 * 256) << "a further line holds two tiles and a caption";
    EXPECT_EQ(heightOf(24, 1) - heightOf(23, 1), line);
    EXPECT_EQ(heightOf(23, 1), heightOf(12, 1));
    EXPECT_GT(heightOf(11, 2), heightOf(11, 1) + line);
    EXPECT_EQ(heightOf(11, 3) - heightOf(11, 2), heightOf(11, 4) - heightOf(11, 3));
}

TEST(RenderGrid, PixelsFillTheImage) {
    const Scenery s;
    const Image grid = gridOf(s, okRow(), 2, s.reference.visibility);
    EXPECT_EQ(grid.channelCount(), 3U);
    EXPECT_EQ(grid.pixels.size(), static_cast<std::size_t>(grid.width) * grid.height * 3);
    EXPECT_TRUE(std::all_of(grid.pixels.begin(), grid.pixels.end(),
                            [](float v) { return std::isfinite(v); }));
}

TEST(RenderGrid, AnErrorShowsItsColour) {
    const Scenery s;
    const Row row = okRow();
    const Image good = gridOf(s, row, 1, s.reference.visibility);
    const Image leak = gridOf(s, row, 1, s.shifted(0.3F));
    const Image dark = gridOf(s, row, 1, s.shifted(-0.3F));
    // 7/8 of the tile is surface; the row of target pixels at its edge may mix both.
    const std::size_t tile = 384 * 384 * 13 / 16;
    EXPECT_GT(countPixels(leak, isRed), countPixels(good, isRed) + tile);
    EXPECT_GT(countPixels(dark, isBlue), countPixels(good, isBlue) + tile);
    EXPECT_EQ(countPixels(leak, isBlue), countPixels(good, isBlue)) << "only the legend is blue";
}

TEST(RenderGrid, TheLabelNamesEffectsBeyondTheMethod) {
    const Scenery s;
    Row row = okRow();
    const Image plain = gridOf(s, row, 1, s.reference.visibility);
    row.effectsMissing = "alpha_mask";
    const Image named = gridOf(s, row, 1, s.reference.visibility);
    ASSERT_EQ(named.pixels.size(), plain.pixels.size());
    // Below the tiles, in the second column's caption.
    int first = named.height, left = named.width;
    for (int y = 0; y < named.height; ++y)
        for (int x = 0; x < named.width; ++x)
            if (named.at(x, y, 0) != plain.at(x, y, 0))
                first = std::min(first, y), left = std::min(left, x);
    EXPECT_GT(first, 2 * 384);
    EXPECT_LT(first, named.height);
    EXPECT_GE(left, 24 + 384 + 12);
}

TEST(RenderGrid, AFailedCellSaysWhy) {
    const Scenery s;
    Row row = okRow();
    row.metrics = {};
    row.frameMs.reset();
    row.status = "failed";
    row.message = "GL_INVALID_OPERATION in pass filter";
    const Image failed = gridOf(s, row, 1, {});
    row.message.clear();
    const Image silent = gridOf(s, row, 1, {});
    row.status = "unsupported";
    const Image unsupported = gridOf(s, row, 1, {});
    EXPECT_EQ(failed.width, silent.width);
    EXPECT_EQ(failed.height, silent.height);
    EXPECT_NE(failed.pixels, silent.pixels) << "the message is drawn";
    EXPECT_NE(silent.pixels, unsupported.pixels) << "the status is drawn";
}

TEST(RenderGrid, OddSizesFit) {
    const Row row = okRow();
    for (const int size : {1, 7, 300, 700}) {
        const Scenery s(size);
        EXPECT_GT(gridOf(s, row, 1, s.reference.visibility).height, 2 * 384) << size;
    }
}

}  // namespace
}  // namespace penumbra
