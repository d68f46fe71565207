#pragma once

#include "harness/viewer/image_view.hpp"
#include "harness/viewer/panels.hpp"
#include "harness/viewer/viewer_state.hpp"

namespace penumbra {

/// The window's content: lays out the panels around the image, for whatever ImGui's display is.
class ViewerApp {
  public:
    ViewerApp(ViewSession& session, const ViewOptions& options, float scale);

    /// Between ImGui::NewFrame() and ImGui::Render(): draws everything, acts on the input, and
    /// brings the session up to date. Returns whether there is more to do without further input.
    bool frame(double elapsedS);

    ViewerState& state() { return state_; }
    const ImageView& image() const { return image_; }

  private:
    void handleShortcuts();

    ViewerState state_;
    ImageView image_;
    TexturePanel textures_;
};

/// The content of a framebuffer, top row first, three bytes a pixel, for writePngBytes().
std::vector<std::uint8_t> readFramebuffer(GLuint framebuffer, int width, int height);

}  // namespace penumbra
