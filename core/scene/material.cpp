#include "core/scene/material.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace penumbra {
namespace {

std::array<float, 256> makeSrgbToLinear() {
    std::array<float, 256> table{};
    for (int i = 0; i < 256; ++i) {
        const double s = i / 255.0;
        table[i] =
            static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return table;
}

/// Folds a texture coordinate into [0, 1]. Mirroring leaves the texel next to an edge its own
/// neighbour, so beyond here only `repeat` still needs a modulo.
float folded(float u, Wrap wrap) {
    switch (wrap) {
        case Wrap::repeat:
            return u - std::floor(u);
        case Wrap::mirroredRepeat: {
            const float t = u - 2.0f * std::floor(0.5f * u);
            return t > 1.0f ? 2.0f - t : t;
        }
        case Wrap::clampToEdge:
            break;
    }
    return std::clamp(u, 0.0f, 1.0f);
}

int wrapped(int texel, int size, Wrap wrap) {
    if (wrap == Wrap::repeat) return (texel + size) % size;
    return std::clamp(texel, 0, size - 1);
}

glm::vec4 texelAt(const TextureImage& image, int x, int y) {
    static const std::array<float, 256> srgbToLinear = makeSrgbToLinear();
    const std::uint8_t* t = &image.rgba[4 * (static_cast<std::size_t>(y) * image.width + x)];
    return {srgbToLinear[t[0]], srgbToLinear[t[1]], srgbToLinear[t[2]],
            static_cast<float>(t[3]) / 255.0f};
}

glm::vec4 sampled(const TextureImage& image, glm::vec2 uv) {
    const float x = folded(uv.x, image.wrapS) * static_cast<float>(image.width);
    const float y = folded(uv.y, image.wrapT) * static_cast<float>(image.height);
    const auto at = [&](int i, int j) {
        return texelAt(image, wrapped(i, image.width, image.wrapS),
                       wrapped(j, image.height, image.wrapT));
    };
    if (!image.linear) return at(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
    const float left = std::floor(x - 0.5f), top = std::floor(y - 0.5f);
    const float fx = x - 0.5f - left, fy = y - 0.5f - top;
    const int i = static_cast<int>(left), j = static_cast<int>(top);
    return glm::mix(glm::mix(at(i, j), at(i + 1, j), fx),
                    glm::mix(at(i, j + 1), at(i + 1, j + 1), fx), fy);
}

}  // namespace

glm::vec4 baseColorAt(const Material& material, const std::vector<TextureImage>& images,
                      glm::vec2 uv) {
    if (material.baseColorTexture < 0) return material.baseColor;
    return material.baseColor * sampled(images[material.baseColorTexture], uv);
}

}  // namespace penumbra
