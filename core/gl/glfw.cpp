#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "core/error.hpp"
#include "core/gl/backends.hpp"

namespace penumbra::gl {
namespace {

std::string lastGlfwError() {
    const char* description = nullptr;
    glfwGetError(&description);
    return description ? description : "no reason given";
}

class GlfwContext final : public Context {
  public:
    GlfwContext() {
        if (!glfwInit()) throw InputError("glfw: no display: " + lastGlfwError());
        try {
            glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
            glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
            glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
            glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
            glfwWindowHint(GLFW_DEPTH_BITS, 0);
            glfwWindowHint(GLFW_STENCIL_BITS, 0);
            GLFWwindow* window = glfwCreateWindow(16, 16, "Penumbra", nullptr, nullptr);
            if (!window) throw InputError("glfw: no OpenGL 4.5 window: " + lastGlfwError());
            glfwMakeContextCurrent(window);
            glfwSwapInterval(0);
            initialise(glfwGetProcAddress, "glfw");
        } catch (...) {
            glfwTerminate();
            throw;
        }
    }
    ~GlfwContext() override { glfwTerminate(); }  // destroys the window and its context

    ContextKind kind() const override { return ContextKind::glfw; }
};

}  // namespace

std::unique_ptr<Context> createGlfw() {
    return std::make_unique<GlfwContext>();
}

}  // namespace penumbra::gl
