#include "core/frame/frame.hpp"

namespace penumbra {
namespace {

gl::Texture upload(const std::vector<glm::vec4>& texels, int width, int height) {
    gl::Texture texture = gl::Texture::create2D(GL_RGBA32F, width, height);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(texture.id(), 0, 0, 0, width, height, GL_RGBA, GL_FLOAT, texels.data());
    return texture;
}

}  // namespace

GBufferTextures uploadGBuffer(const GBuffer& gbuffer) {
    std::vector<glm::vec4> position(gbuffer.size()), normal(gbuffer.size());
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        position[i] = glm::vec4(gbuffer.position[i], static_cast<float>(gbuffer.mask[i]));
        normal[i] = glm::vec4(gbuffer.geometricNormal[i], 0.0f);
    }
    return {upload(position, gbuffer.width, gbuffer.height),
            upload(normal, gbuffer.width, gbuffer.height)};
}

}  // namespace penumbra
