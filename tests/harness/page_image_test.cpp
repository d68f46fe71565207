#include "harness/report/page_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libdeflate.h>
#include <nettle/base64.h>

#include <array>
#include <limits>
#include <memory>
#include <vector>

namespace penumbra {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<unsigned char> inflated(const std::string& base64, std::size_t size) {
    base64_decode_ctx context;
    base64_decode_init(&context);
    std::vector<unsigned char> packed(BASE64_DECODE_LENGTH(base64.size()));
    std::size_t length = 0;
    EXPECT_TRUE(
        base64_decode_update(&context, &length, packed.data(), base64.size(), base64.data()));
    std::vector<unsigned char> bytes(size);
    const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
        decompressor(libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
    EXPECT_EQ(libdeflate_deflate_decompress(decompressor.get(), packed.data(), length, bytes.data(),
                                            bytes.size(), nullptr),
              LIBDEFLATE_SUCCESS);
    return bytes;
}

/// What a plane of `width` says, decoded from the documentation of packedPlane.
std::vector<std::uint16_t> unpacked(const std::string& base64, std::size_t count,
                                    std::size_t width) {
    const std::vector<unsigned char> bytes = inflated(base64, 2 * count);
    std::vector<std::uint16_t> values(count);
    for (std::size_t i = 0; i < count; ++i) {
        const int folded = bytes[i] + 256 * bytes[count + i];
        const int residual = folded % 2 ? -(folded + 1) / 2 : folded / 2;
        const int a = i % width ? values[i - 1] : 0, b = i >= width ? values[i - width] : 0;
        const int c = i % width && i >= width ? values[i - width - 1] : 0;
        const int predicted = c >= std::max(a, b)   ? std::min(a, b)
                              : c <= std::min(a, b) ? std::max(a, b)
                                                    : a + b - c;
        values[i] = static_cast<std::uint16_t>(predicted + residual);
    }
    return values;
}

/// The plane of the data element `id` in `elements`.
std::string planeOf(const std::string& elements, const std::string& id) {
    const std::string start = "id=\"" + id + "\">";
    const std::size_t at = elements.find(start);
    if (at == std::string::npos) return "no " + id;
    const std::size_t begin = at + start.size();
    return elements.substr(begin, elements.find('<', begin) - begin);
}

TEST(PackedPlane, IsUndoneByItsDefinition) {
    // Every 16-bit number beside numbers near and far, so that residuals wrap both ways.
    std::vector<std::uint16_t> values;
    for (unsigned i = 0; i < 65536; ++i)
        values.push_back(static_cast<std::uint16_t>(i % 3 ? i * 40503U : i));
    EXPECT_EQ(unpacked(packedPlane(values, 256), values.size(), 256), values);
}

TEST(PackedPlane, SmoothGradientsAreSmall) {
    std::vector<std::uint16_t> values;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) values.push_back(static_cast<std::uint16_t>(100 * x + 7 * y));
    // All but the first row and column are predicted exactly: 32 KiB of bytes that repeat.
    EXPECT_LT(packedPlane(values, 128).size(), 1000U);
}

TEST(PageStride, StandardSuiteIsShownWhole) {
    const double pixels = 512.0 * 512.0;
    EXPECT_EQ(pageStride(27 * 11 * pixels), 1);  // frames x methods and the separation
    EXPECT_EQ(pageStride(1215 * pixels), 2);     // its ladder
    EXPECT_EQ(pageStride(0), 1);
}

/// 3 x 2 pixels: background, facing away, horizon / lit, penumbra, umbra.
struct SmallFrame {
    SmallFrame() {
        gbuffer.width = reference.width = 3;
        gbuffer.height = reference.height = 2;
        gbuffer.mask = {PixelClass::background, PixelClass::facingAway, PixelClass::horizon,
                        PixelClass::scored,     PixelClass::scored,     PixelClass::scored};
        gbuffer.position.resize(6);
        gbuffer.geometricNormal.resize(6, {0, 1, 0});
        gbuffer.shadingNormal.resize(6, {0, 1, 0});
        gbuffer.albedo.resize(6, glm::vec3(0.5F));
        gbuffer.irradianceUnshadowed.resize(6, 1.0F);
        reference.visibility = {0, 0, 0.5F, 1, 0.25F, 0};
        reference.standardError = {0, 0, 0.002F, 0, 0.001F, 0};
        reference.rays.resize(6, 4096.0F);
        row.scene = "s";
        row.setting = row.method = "m";
    }
    std::string elements(std::vector<float> visibility, int stride) {
        GridFrame frame{4, &gbuffer, &reference, {}};
        frame.cells.push_back({&row, std::move(visibility)});
        return pageImages(frame, 7, {&row, 1}, stride);
    }

    GBuffer gbuffer;
    Reference reference;
    Row row;
};

TEST(PageImages, PlanesHoldWhatTheirIdsSay) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::string elements = SmallFrame().elements({1, 1, 0.25F, 1.5F, nan, -0.001F}, 1);
    const auto plane = [&](const char* id) { return unpacked(planeOf(elements, id), 6, 3); };
    EXPECT_THAT(plane("class-7-4"), ElementsAre(0, 5, 4, 1, 2, 3));
    EXPECT_THAT(plane("reference-7-4"), ElementsAre(32768, 32768, 33268, 33768, 33018, 32768));
    EXPECT_THAT(plane("standard-error-7-4"), ElementsAre(0, 0, 200, 0, 100, 0));
    // Outside what is asked for V is 0; outside [0,1] it is kept; not finite is 0.
    EXPECT_THAT(plane("visibility-0"), ElementsAre(32768, 32768, 33018, 34268, 0, 32767));
    EXPECT_EQ(plane("red-7-4"), plane("blue-7-4"));
}

TEST(PageImages, AStrideTakesThePixelsItNames) {
    const std::string elements = SmallFrame().elements({0, 0, 0.25F, 1, 0, 0}, 2);
    EXPECT_THAT(unpacked(planeOf(elements, "class-7-4"), 2, 2), ElementsAre(0, 4));
    EXPECT_THAT(unpacked(planeOf(elements, "visibility-0"), 2, 2), ElementsAre(32768, 33018));
}

TEST(PageImages, ARowWithoutAnImageHasNoPlane) {
    EXPECT_THAT(planeOf(SmallFrame().elements({}, 1), "visibility-0"),
                HasSubstr("no visibility-0"));
}

}  // namespace
}  // namespace penumbra
