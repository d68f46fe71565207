#include "core/passes/slice_pass.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace penumbra {
namespace {

/// Mip levels down to one texel.
int allLevels(int size) {
    return 1 + static_cast<int>(std::floor(std::log2(size)));
}

}  // namespace

SlicePass::SlicePass(int slices, SliceTargets targets, bool alphaMask)
    : slices_(slices),
      targets_(slices > kMostChannels ? SliceTargets::bits : targets),
      alphaMask_(alphaMask) {
    std::vector<std::string> defines = {"SLICES " + std::to_string(slices)};
    if (targets_ == SliceTargets::bits) {
        unpack_ = gl::Program::compute("common/slice_pass.glsl", defines);
        defines.emplace_back("SLICES_AS_BITS");
    }
    if (alphaMask) defines.emplace_back("ALPHA_MASK");
    program_ = gl::Program::graphics("common/slice_pass.glsl", defines);
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    framebuffer_ = gl::Framebuffer(id);
}

void SlicePass::allocateChannels(int size) {
    if (channels_.width() == size) return;
    channels_ = gl::Texture::createArray(GL_RGBA8, size, size, layers(), allLevels(size));
}

void SlicePass::attach(int size) {
    if (size_ == size) return;
    size_ = size;
    std::vector<GLenum> targets;
    if (targets_ == SliceTargets::bits) {
        bits_ = gl::Texture::create2D(slices_ > 32 ? GL_RG32UI : GL_R32UI, size, size);
        glNamedFramebufferTexture(framebuffer_.id(), GL_COLOR_ATTACHMENT0, bits_.id(), 0);
        targets.push_back(GL_COLOR_ATTACHMENT0);
    } else {
        allocateChannels(size);
        for (int i = 0; i < layers(); ++i) {
            const GLenum target = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i);
            glNamedFramebufferTextureLayer(framebuffer_.id(), target, channels_.id(), 0, i);
            targets.push_back(target);
        }
    }
    glNamedFramebufferDrawBuffers(framebuffer_.id(), static_cast<GLsizei>(targets.size()),
                                  targets.data());
}

void SlicePass::render(const Frame& frame, const SliceView& view, const SliceFill& fill, int size,
                       SliceSet used) {
    const gl::DebugGroup group("slice pass");
    attach(size);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
    glDisable(GL_POLYGON_OFFSET_FILL);
    glDisable(GL_SCISSOR_TEST);
    glViewport(0, 0, size, size);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    if (targets_ == SliceTargets::bits) {
        constexpr std::array<GLuint, 4> kNothing = {};
        glClearNamedFramebufferuiv(framebuffer_.id(), GL_COLOR, 0, kNothing.data());
        glDisable(GL_BLEND);
        glEnable(GL_COLOR_LOGIC_OP);
        glLogicOp(GL_OR);
    } else {
        constexpr std::array<float, 4> kNothing = {};
        for (int i = 0; i < layers(); ++i)
            glClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, i, kNothing.data());
        glEnable(GL_BLEND);
        glBlendEquation(GL_MAX);
    }
    program_.use();
    program_.set("clipFromWorld", view.clipFromWorld());
    program_.set("depthRow", glm::vec4(glm::dvec4(view.axisZ, -glm::dot(view.axisZ, view.centre))));
    for (int i = 0; i <= slices_; ++i) {
        // What is nearer than the first boundary by rounding belongs to the first slice.
        const double boundary = i == 0 ? 0.0 : view.boundariesM[static_cast<std::size_t>(i)];
        program_.set(("boundariesM[" + std::to_string(i) + "]").c_str(),
                     static_cast<float>(boundary));
    }
    // Floors, which lie below the last slice, would cover the whole texture for nothing.
    const std::size_t end = std::min<std::size_t>(std::bit_width(used), view.planesM.size());
    program_.set("deepestM", static_cast<float>(view.boundariesM[end]));
    used_ = 0;
    for (int i = 0; i < slices_; ++i)
        program_.set(("place[" + std::to_string(i) + "]").c_str(), used >> i & 1 ? used_++ : -1);
    program_.set("fill", fill.always ? 2 : fill.depthM ? 1 : 0);
    if (fill.depthM) fill.depthM->bind(1);
    glEnable(GL_CLIP_DISTANCE0);
    frame.gpuGeometry.draw(program_.id(), alphaMask_);
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_COLOR_LOGIC_OP);
}

void SlicePass::unpack() {
    if (targets_ == SliceTargets::channels) return;
    const gl::DebugGroup group("slice pass: unpack");
    allocateChannels(size_);
    unpack_.use();
    bits_.bind(0);
    glBindImageTexture(0, channels_.id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
    constexpr int kSide = 8;  // of a work group
    const auto groups = static_cast<GLuint>((size_ + kSide - 1) / kSide);
    glDispatchCompute(groups, groups, static_cast<GLuint>(layers()));
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_TEXTURE_UPDATE_BARRIER_BIT);
}

}  // namespace penumbra
