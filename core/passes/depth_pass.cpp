#include "core/passes/depth_pass.hpp"

#include <array>

namespace penumbra {

DepthPass::DepthPass(bool alphaMask)
    : program_(gl::Program::graphics(
          "common/depth_pass.glsl",
          alphaMask ? std::vector<std::string>{"ALPHA_MASK"} : std::vector<std::string>{})),
      alphaMask_(alphaMask) {
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    framebuffer_ = gl::Framebuffer(id);
    glNamedFramebufferDrawBuffer(id, GL_NONE);
}

void DepthPass::render(const Frame& frame, const LightView& view, int size) {
    const gl::DebugGroup group("depth pass");
    view_ = view;
    const int layers = static_cast<int>(view.tiles.size());
    if (map_.width() != size || map_.layers() != layers)
        map_ = gl::Texture::createArray(GL_DEPTH_COMPONENT32F, size, size, layers);

    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glEnable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    glDisable(GL_POLYGON_OFFSET_FILL);
    glDisable(GL_SCISSOR_TEST);
    glViewport(0, 0, size, size);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    program_.use();
    for (int layer = 0; layer < layers; ++layer) {
        glNamedFramebufferTextureLayer(framebuffer_.id(), GL_DEPTH_ATTACHMENT, map_.id(), 0, layer);
        constexpr float kNothing = 0.0f;
        glClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &kNothing);
        program_.set("clipFromWorld", view.clipFromWorld(static_cast<std::size_t>(layer)));
        frame.gpuGeometry.draw(program_.id(), alphaMask_);
    }
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_DEPTH_TEST);
}

void DepthPass::bind(const gl::Program& program, GLuint unit) const {
    map_.bind(unit);
    program.set("lightCentre", glm::vec3(view_.centre));
    program.set("tileCount", static_cast<int>(view_.tiles.size()));
    program.set("mapSize", map_.width());
    for (std::size_t i = 0; i < view_.tiles.size(); ++i) {
        const LightTile& tile = view_.tiles[i];
        const std::string index = "[" + std::to_string(i) + "]";
        program.set(("tileAxes" + index).c_str(),
                    glm::mat3(glm::transpose(glm::dmat3(tile.axisX, tile.axisY, tile.axisZ))));
        program.set(("tileTangents" + index).c_str(),
                    glm::vec4(tile.tangentLo, 1.0 / tile.tangentSize()));
        program.set(("tileNear" + index).c_str(), static_cast<float>(tile.nearM));
    }
}

double DepthPass::texels() const {
    return static_cast<double>(map_.width()) * map_.height() * map_.layers();
}

}  // namespace penumbra
