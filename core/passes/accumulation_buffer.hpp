#pragma once

#include "core/frame/frame.hpp"
#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

namespace penumbra {

/// One float per pixel, to which full-screen passes add. 32 bits: sums of less than 2^24 equal
/// steps are exact in any order.
class AccumulationBuffer {
  public:
    AccumulationBuffer() = default;
    AccumulationBuffer(int width, int height);

    int width() const { return sum_.width(); }
    int height() const { return sum_.height(); }
    void clear() const;
    /// Adds what `program` writes, drawn as VisibilityTarget::draw draws: the program is in use,
    /// its G-buffer gets bound. Sets all GL state it needs.
    void add(const gl::Program& program, const GBufferTextures& gbuffer) const;
    const gl::Texture& sum() const { return sum_; }
    double mebibytes() const { return sum_.mebibytes(); }

  private:
    gl::Texture sum_;  ///< R32F
    gl::Framebuffer framebuffer_;
    gl::VertexArray empty_;
};

}  // namespace penumbra
