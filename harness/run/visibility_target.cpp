#include "harness/run/visibility_target.hpp"

#include <limits>

namespace penumbra {

TextureTarget::TextureTarget(int width, int height)
    : texture_(gl::Texture::create2D(GL_R32F, width, height)) {
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    framebuffer_ = gl::Framebuffer(id);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, texture_.id(), 0);
    glCreateVertexArrays(1, &id);
    empty_ = gl::VertexArray(id);
}

void TextureTarget::draw(const gl::Program& program, const GBufferTextures& gbuffer) const {
    constexpr GLuint kPositionUnit = 8, kNormalUnit = 9;  // shaders/common/receiver.glsl
    gbuffer.position.bind(kPositionUnit);
    gbuffer.normal.bind(kNormalUnit);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glViewport(0, 0, width(), height());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    program.use();
    glBindVertexArray(empty_.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void TextureTarget::upload(std::span<const float> visibility) const {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(texture_.id(), 0, 0, 0, width(), height(), GL_RED, GL_FLOAT,
                        visibility.data());
}

void TextureTarget::poison() const {
    const float nothing = std::numeric_limits<float>::quiet_NaN();
    glClearTexImage(texture_.id(), 0, GL_RED, GL_FLOAT, &nothing);
}

std::vector<float> TextureTarget::read() const {
    std::vector<float> pixels(static_cast<std::size_t>(width()) * height());
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glGetTextureImage(texture_.id(), 0, GL_RED, GL_FLOAT,
                      static_cast<GLsizei>(pixels.size() * sizeof(float)), pixels.data());
    return pixels;
}

}  // namespace penumbra
