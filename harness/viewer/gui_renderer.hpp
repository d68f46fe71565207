#pragma once

#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

struct ImDrawData;

namespace penumbra {

/// Draws what Dear ImGui has gathered in a frame through the project's own OpenGL handles, so that
/// every entry point comes from the context's loader. A texture id of ImGui is an OpenGL texture's
/// name. Needs a context and a current ImGui context, whose font atlas it uploads.
class GuiRenderer {
  public:
    GuiRenderer();
    ~GuiRenderer();
    GuiRenderer(const GuiRenderer&) = delete;
    GuiRenderer& operator=(const GuiRenderer&) = delete;

    /// Onto framebuffer `framebuffer` (0: the window), cleared to dark grey first. Sets all state
    /// that it needs and leaves it.
    void draw(const ImDrawData& data, GLuint framebuffer);

  private:
    gl::Program program_;
    gl::Texture font_;
    gl::VertexArray vertexArray_;
};

}  // namespace penumbra
