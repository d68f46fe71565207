#pragma once

#include <vector>

#include "core/gl/handles.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {

/// The harness's R32F texture that a method shades into.
class TextureTarget : public VisibilityTarget {
  public:
    TextureTarget(int width, int height);
    int width() const override { return texture_.width(); }
    int height() const override { return texture_.height(); }
    void draw(const gl::Program& program, const GBufferTextures& gbuffer) const override;
    void upload(std::span<const float> visibility) const override;
    /// Fills with NaN, so that a pixel that nobody wrote is noticed.
    void poison() const;
    std::vector<float> read() const;

  private:
    gl::Texture texture_;
    gl::Framebuffer framebuffer_;
    gl::VertexArray empty_;
};

}  // namespace penumbra
