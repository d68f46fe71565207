#include "core/passes/accumulation_buffer.hpp"

namespace penumbra {

AccumulationBuffer::AccumulationBuffer(int width, int height)
    : sum_(gl::Texture::create2D(GL_R32F, width, height)) {
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    framebuffer_ = gl::Framebuffer(id);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, sum_.id(), 0);
    glCreateVertexArrays(1, &id);
    empty_ = gl::VertexArray(id);
}

void AccumulationBuffer::clear() const {
    constexpr float kNothing = 0.0f;
    glClearTexImage(sum_.id(), 0, GL_RED, GL_FLOAT, &kNothing);
}

void AccumulationBuffer::add(const gl::Program& program, const GBufferTextures& gbuffer) const {
    constexpr GLuint kPositionUnit = 8, kNormalUnit = 9;  // shaders/common/receiver.glsl
    gbuffer.position.bind(kPositionUnit);
    gbuffer.normal.bind(kNormalUnit);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glViewport(0, 0, width(), height());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ONE);
    program.use();
    glBindVertexArray(empty_.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindVertexArray(0);
    glDisable(GL_BLEND);
}

}  // namespace penumbra
