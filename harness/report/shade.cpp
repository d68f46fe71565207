#include "harness/report/shade.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <vector>

#include "harness/report/shade_rows.hpp"

namespace penumbra {

namespace {

constexpr glm::vec3 kBackground{0.03F};
constexpr glm::vec3 kNotFinite{1.0F, 0.0F, 1.0F};
constexpr float kAmbientShare = 0.04F;
constexpr float kWhitePoint = 0.8F;

Image rgbImage(const GBuffer& gbuffer) {
    return Image::withChannels(gbuffer.width, gbuffer.height, {"R", "G", "B"});
}

void setPixel(std::span<float> image, std::size_t pixel, const glm::vec3& rgb) {
    float* at = &image[3 * pixel];
    at[0] = rgb.r;
    at[1] = rgb.g;
    at[2] = rgb.b;
}

float luminance(const glm::vec3& rgb) {
    return glm::dot(rgb, {0.2126F, 0.7152F, 0.0722F});
}

/// 0 of an empty vector. Nearest rank, reorders.
float percentile95(std::vector<float>& values) {
    if (values.empty()) return 0.0F;
    const auto nth =
        values.begin() + static_cast<std::ptrdiff_t>((95 * values.size() + 99) / 100 - 1);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

/// Grey diagonal stripes eight pixels apart.
glm::vec3 hatching(const GBuffer& gbuffer, std::size_t pixel) {
    const auto width = static_cast<std::size_t>(gbuffer.width);
    return glm::vec3((pixel % width + pixel / width) % 16 < 8 ? 0.10F : 0.13F);
}

}  // namespace

PictureLight pictureLight(const GBuffer& gbuffer) {
    std::vector<float> irradiances, luminances;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        const float irradiance = gbuffer.irradianceUnshadowed[i];
        if (!isAsked(gbuffer.mask[i]) || !(irradiance > 0.0F)) continue;
        irradiances.push_back(irradiance);
        luminances.push_back(luminance(gbuffer.albedo[i]) * irradiance * glm::one_over_pi<float>());
    }
    const float bright = percentile95(luminances);
    PictureLight light;
    light.radiance = bright > 0.0F ? kWhitePoint / bright : 1.0F;
    light.ambientIrradiance = kAmbientShare * percentile95(irradiances) * light.radiance;
    return light;
}

void shadeRows(const GBuffer& gbuffer, std::span<const float> visibility, const PictureLight& light,
               int beginRow, int endRow, std::span<float> rgb) {
    const auto width = static_cast<std::size_t>(gbuffer.width);
    const std::size_t begin = width * static_cast<std::size_t>(beginRow);
    for (std::size_t i = begin; i < width * static_cast<std::size_t>(endRow); ++i) {
        glm::vec3 colour = kBackground;
        if (gbuffer.mask[i] != PixelClass::background) {
            const float v = std::clamp(visibility[i], 0.0F, 1.0F);
            const float direct = gbuffer.irradianceUnshadowed[i] * light.radiance * v;
            colour = std::isfinite(visibility[i]) ? gbuffer.albedo[i] * glm::one_over_pi<float>() *
                                                        (direct + light.ambientIrradiance)
                                                  : kNotFinite;
        }
        setPixel(rgb, i - begin, colour);
    }
}

Image shadeVisibility(const GBuffer& gbuffer, std::span<const float> visibility,
                      const PictureLight& light) {
    Image image = rgbImage(gbuffer);
    shadeRows(gbuffer, visibility, light, 0, gbuffer.height, image.pixels);
    return image;
}

glm::vec3 errorColour(float error) {
    if (!std::isfinite(error)) return kNotFinite;
    // Mixed as square roots of linear values: near enough to sRGB for the steps to look even. What
    // is taken from white is looked up, for no branch foretells the signs of noise.
    static constexpr std::array<glm::vec3, 2> kTaken{
        {{0.20F, 0.94F, 0.90F}, {0.90F, 0.94F, 0.20F}}};
    const float t = std::min(std::abs(error) / kErrorScale, 1.0F);
    const glm::vec3 root = 1.0F - t * kTaken[error < 0.0F];
    return root * root;
}

void errorRows(const GBuffer& gbuffer, std::span<const float> visibility,
               const Reference& reference, int beginRow, int endRow, std::span<float> rgb) {
    const auto width = static_cast<std::size_t>(gbuffer.width);
    const std::size_t begin = width * static_cast<std::size_t>(beginRow);
    for (std::size_t i = begin; i < width * static_cast<std::size_t>(endRow); ++i)
        setPixel(rgb, i - begin,
                 isAsked(gbuffer.mask[i]) ? errorColour(visibility[i] - reference.visibility[i])
                                          : hatching(gbuffer, i));
}

Image errorMap(const GBuffer& gbuffer, std::span<const float> visibility,
               const Reference& reference) {
    Image image = rgbImage(gbuffer);
    errorRows(gbuffer, visibility, reference, 0, gbuffer.height, image.pixels);
    return image;
}

const std::array<ClassColour, 4>& classColours() {
    static const std::array<ClassColour, 4> kColours{{
        {"lit", {0.88F, 0.80F, 0.52F}},
        {"penumbra", {0.80F, 0.28F, 0.03F}},
        {"umbra", {0.02F, 0.03F, 0.12F}},
        {"horizon", {0.06F, 0.30F, 0.32F}},
    }};
    return kColours;
}

Image classMap(const GBuffer& gbuffer, const Reference& reference) {
    const std::vector<LightClass> classes = classifyLight(reference, gbuffer);
    const auto& [lit, penumbra, umbra, horizon] = classColours();
    Image image = rgbImage(gbuffer);
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (gbuffer.mask[i] == PixelClass::horizon) {
            setPixel(image.pixels, i, horizon.rgb);
        } else if (gbuffer.mask[i] != PixelClass::scored) {
            setPixel(image.pixels, i, hatching(gbuffer, i));
        } else if (classes[i] == LightClass::lit) {
            setPixel(image.pixels, i, lit.rgb);
        } else {
            setPixel(image.pixels, i,
                     classes[i] == LightClass::penumbra ? penumbra.rgb : umbra.rgb);
        }
    }
    return image;
}

}  // namespace penumbra
