#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace penumbra {

enum class Wrap { repeat, mirroredRepeat, clampToEdge };

/// A decoded image of an asset: 8-bit RGBA, top row first, colour in sRGB and alpha linear.
struct TextureImage {
    std::string name;
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgba;  ///< 4 * width * height bytes
    Wrap wrapS = Wrap::repeat;
    Wrap wrapT = Wrap::repeat;
    bool linear = true;  ///< bilinear at base level, else nearest; nobody minifies (core/trace, depth pass)
};

/// What of a glTF material a shadow depends on.
struct Material {
    std::string name;
    glm::vec4 baseColor{1.0f};  ///< linear; alpha multiplies the texture's alpha
    int baseColorTexture = -1;  ///< index into Scene::images, -1 for none
    bool masked = false;        ///< alphaMode MASK: opaque where alpha >= alphaCutoff, absent elsewhere
    float alphaCutoff = 0.5f;
};

/// Alpha and colour of `material` at `uv`: base colour times texture, colour in linear RGB.
/// The one rule for every ray and every pixel on the CPU; shaders/common/alpha.glsl states it again
/// for the GPU.
glm::vec4 baseColorAt(const Material& material, const std::vector<TextureImage>& images,
                      glm::vec2 uv);

}  // namespace penumbra
