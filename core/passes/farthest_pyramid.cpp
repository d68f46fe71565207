#include "core/passes/farthest_pyramid.hpp"

#include <algorithm>
#include <bit>

namespace penumbra {

FarthestPyramid FarthestPyramid::create() {
    FarthestPyramid pyramid;
    pyramid.base_ = gl::Program::compute("common/farthest_pyramid_build.glsl", {"PASS_BASE"});
    pyramid.reduce_ = gl::Program::compute("common/farthest_pyramid_build.glsl", {"PASS_REDUCE"});
    return pyramid;
}

void FarthestPyramid::build(const std::array<const gl::Texture*, 2>& maps) {
    const gl::DebugGroup group("farthest pyramid");
    // Of whole blocks at every level.
    const int blocks = static_cast<int>(
        std::bit_ceil(static_cast<unsigned>((maps[0]->width() - 1) / kBlockTexels + 1)));
    if (texture_.width() != blocks) {
        levels_ = std::bit_width(static_cast<unsigned>(blocks));
        texture_ = gl::Texture::createArray(GL_R32F, blocks, blocks, 2, levels_);
    }
    const auto groups = [&](int level) { return static_cast<GLuint>(((blocks >> level) + 7) / 8); };
    const auto writeTo = [&](int level) {
        glBindImageTexture(0, texture_.id(), level, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    };
    base_.use();
    writeTo(0);
    for (int layer = 0; layer < 2; ++layer) {
        maps[static_cast<std::size_t>(layer)]->bind(0);
        base_.set("layer", layer);
        glDispatchCompute(groups(0), groups(0), 1);
    }
    reduce_.use();
    texture_.bind(0);
    for (int level = 1; level < levels_; ++level) {
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
        writeTo(level);
        reduce_.set("below", level - 1);
        glDispatchCompute(groups(level), groups(level), 2);
    }
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

}  // namespace penumbra
