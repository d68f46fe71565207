#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "core/error.hpp"
#include "core/gl/backends.hpp"
#include "core/gl/window.hpp"

namespace penumbra::gl {
namespace {

std::string lastGlfwError() {
    const char* description = nullptr;
    glfwGetError(&description);
    return description ? description : "no reason given";
}

}  // namespace

Window::Window(const WindowOptions& options) {
    if (!glfwInit()) throw InputError("glfw: no display: " + lastGlfwError());
    try {
        glfwWindowHint(GLFW_VISIBLE, options.visible ? GLFW_TRUE : GLFW_FALSE);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_DEPTH_BITS, 0);
        glfwWindowHint(GLFW_STENCIL_BITS, 0);
        window_ = glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr,
                                   nullptr);
        if (!window_) throw InputError("glfw: no OpenGL 4.5 window: " + lastGlfwError());
        glfwMakeContextCurrent(window_);
        glfwSwapInterval(0);
        initialise(glfwGetProcAddress, "glfw");
    } catch (...) {
        glfwTerminate();
        throw;
    }
}

Window::~Window() {
    glfwTerminate();  // destroys the window and its context
}

std::unique_ptr<Context> createGlfw() {
    return std::make_unique<Window>(WindowOptions{});
}

}  // namespace penumbra::gl
