#include "core/passes/layer_pass.hpp"

namespace penumbra {

LayerPass LayerPass::create() {
    LayerPass pass;
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    pass.framebuffer_ = gl::Framebuffer(id);
    glCreateVertexArrays(1, &id);
    pass.empty_ = gl::VertexArray(id);
    return pass;
}

void LayerPass::draw(const gl::Program& program, const gl::Texture& target, int layer) const {
    glNamedFramebufferTextureLayer(framebuffer_.id(), GL_COLOR_ATTACHMENT0, target.id(), 0, layer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glViewport(0, 0, target.width(), target.height());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    program.use();
    glBindVertexArray(empty_.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace penumbra
