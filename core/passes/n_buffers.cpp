#include "core/passes/n_buffers.hpp"

namespace penumbra {

NBuffers NBuffers::create() {
    NBuffers buffers;
    buffers.base_ = gl::Program::compute("common/n_buffers_build.glsl", {"PASS_BASE"});
    buffers.next_ = gl::Program::compute("common/n_buffers_build.glsl");
    return buffers;
}

void NBuffers::build(const gl::Texture& source, int levels) {
    const gl::DebugGroup group("N-buffers");
    const int layers = source.layers() * levels;
    if (texture_.width() != source.width() || texture_.height() != source.height() ||
        texture_.layers() != layers) {
        texture_ = gl::Texture::createArray(GL_RGBA16F, source.width(), source.height(), layers);
        glTextureParameteri(texture_.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTextureParameteri(texture_.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    }
    levels_ = levels;
    source.bind(0);
    glBindImageTexture(0, texture_.id(), 0, GL_TRUE, 0, GL_READ_WRITE, texture_.format());
    constexpr int kSide = 8;  // of a work group
    const auto groups = [](int items) { return static_cast<GLuint>((items + kSide - 1) / kSide); };
    for (int level = 0; level < levels; ++level) {
        const gl::Program& program = level == 0 ? base_ : next_;
        program.use();
        program.set("level", level);
        program.set("levels", levels);
        glDispatchCompute(groups(source.width()), groups(source.height()),
                          static_cast<GLuint>(source.layers()));
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
    }
}

}  // namespace penumbra
