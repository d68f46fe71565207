#pragma once

#include <string>

#include "core/gl/context.hpp"

struct GLFWwindow;

namespace penumbra::gl {

struct WindowOptions {
    std::string title = "Penumbra";
    int width = 16, height = 16;  ///< in screen coordinates, which on HiDPI are not pixels
    bool visible = false;
};

/// A GLFW window whose OpenGL 4.5 core context is current and initialised (Context). One at a time
/// per process; its end ends GLFW.
class Window final : public Context {
  public:
    /// Throws InputError with the reason where there is no display or no OpenGL 4.5.
    explicit Window(const WindowOptions& options);
    ~Window() override;
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    ContextKind kind() const override { return ContextKind::glfw; }
    GLFWwindow* handle() const { return window_; }

  private:
    GLFWwindow* window_ = nullptr;
};

}  // namespace penumbra::gl
