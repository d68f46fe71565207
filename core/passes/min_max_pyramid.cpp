#include "core/passes/min_max_pyramid.hpp"

#include <algorithm>
#include <bit>

namespace penumbra {
namespace {

constexpr GLuint kUnit = 1;  // shaders/common/min_max_pyramid.glsl
constexpr int kLeastBlockTexels = 8;
constexpr int kMostBlocks = 256;  // across, so that all levels of one map stay within 10 MiB

}  // namespace

MinMaxPyramid MinMaxPyramid::create() {
    MinMaxPyramid pyramid;
    pyramid.base_ = gl::Program::graphics("common/min_max_pyramid_pass.glsl", {"PASS_BASE"});
    pyramid.reduce_ = gl::Program::graphics("common/min_max_pyramid_pass.glsl", {"PASS_REDUCE"});
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    pyramid.framebuffer_ = gl::Framebuffer(id);
    glCreateVertexArrays(1, &id);
    pyramid.empty_ = gl::VertexArray(id);
    return pyramid;
}

void MinMaxPyramid::build(const DepthPass& depth, double widestTexels) {
    const gl::DebugGroup group("min/max pyramid");
    const gl::Texture& map = depth.map();
    blockTexels_ = kLeastBlockTexels;
    while (kMostBlocks * blockTexels_ < map.width()) blockTexels_ *= 2;
    const int blocks = (map.width() + blockTexels_ - 1) / blockTexels_;
    const double widestBlocks = std::clamp(widestTexels / blockTexels_, 1.0, double(blocks));
    levels_ = std::bit_width(static_cast<unsigned>(widestBlocks));
    if (texture_.width() != blocks || texture_.layers() != map.layers() * levels_)
        texture_ = gl::Texture::createArray(GL_RGBA32UI, blocks, blocks, map.layers() * levels_);

    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glBindVertexArray(empty_.id());
    map.bind(0);
    base_.set("mapSize", map.width());
    for (const gl::Program* program : {&base_, &reduce_}) bind(*program);
    for (int level = 0; level < levels_; ++level) {
        const gl::Program& program = level == 0 ? base_ : reduce_;
        // Windows that reach beyond the map are never asked for.
        const int windows = blocks - (1 << level) + 1;
        glViewport(0, 0, windows, windows);
        program.use();
        program.set("childBlocks", 1 << std::max(level - 1, 0));
        for (int tile = 0; tile < map.layers(); ++tile) {
            const int layer = tile * levels_ + level;
            glNamedFramebufferTextureLayer(framebuffer_.id(), GL_COLOR_ATTACHMENT0, texture_.id(),
                                           0, layer);
            program.set("layer", level == 0 ? tile : layer - 1);
            glDrawArrays(GL_TRIANGLES, 0, 3);
        }
        glTextureBarrier();  // other layers of the texture that is drawn to are read next
    }
}

void MinMaxPyramid::bind(const gl::Program& program) const {
    texture_.bind(kUnit);
    program.set("pyramidLevels", levels_);
    program.set("pyramidBlocks", texture_.width());
    program.set("pyramidBlockTexels", static_cast<float>(blockTexels_));
}

}  // namespace penumbra
