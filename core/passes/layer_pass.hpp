#pragma once

#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

namespace penumbra {

/// Draws full-screen triangles into single layers of array textures.
class LayerPass {
  public:
    LayerPass() = default;
    /// For the current context.
    static LayerPass create();

    /// Runs `program` (shaders/common/fullscreen.glsl, one colour output) on every texel of level 0
    /// of `layer` of `target`. Sets all GL state it needs.
    void draw(const gl::Program& program, const gl::Texture& target, int layer) const;

  private:
    gl::Framebuffer framebuffer_;
    gl::VertexArray empty_;
};

}  // namespace penumbra
