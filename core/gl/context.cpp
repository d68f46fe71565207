#include "core/gl/context.hpp"

#include <glad/gl.h>

#include "core/error.hpp"
#include "core/gl/backends.hpp"

namespace penumbra::gl {
namespace {

std::string glText(GLenum name) {
    const GLubyte* text = glGetString(name);
    return text ? reinterpret_cast<const char*>(text) : "unknown";
}

std::unique_ptr<Context> createAutomatic() {
    try {
        return createEgl(/*hardwareOnly=*/true);
    } catch (const InputError&) {
        return createOsmesa();
    }
}

}  // namespace

ContextKind parseContextKind(const std::string& text) {
    if (text == "osmesa") return ContextKind::osmesa;
    if (text == "egl") return ContextKind::egl;
    if (text == "glfw") return ContextKind::glfw;
    if (text == "auto") return ContextKind::automatic;
    throw InputError("unknown context '" + text + "'; the contexts are osmesa, egl, glfw, auto");
}

std::unique_ptr<Context> Context::create(ContextKind kind) {
    switch (kind) {
        case ContextKind::osmesa:
            return createOsmesa();
        case ContextKind::egl:
            return createEgl(/*hardwareOnly=*/false);
        case ContextKind::glfw:
            return createGlfw();
        case ContextKind::automatic:
            return createAutomatic();
    }
    throw std::logic_error("Context::create: not a context kind");
}

std::string Context::renderer() const {
    return glText(GL_RENDERER);
}

std::string Context::version() const {
    return glText(GL_VERSION);
}

bool isSoftwareRenderer(const std::string& renderer) {
    for (const char* name : {"llvmpipe", "softpipe", "swrast", "Software Rasterizer"})
        if (renderer.find(name) != std::string::npos) return true;
    return false;
}

void initialise(GetEntryPoint getEntryPoint, const std::string& what) {
    const int version = gladLoadGL(getEntryPoint);
    if (version == 0) throw InputError(what + ": the OpenGL entry points could not be loaded");
    if (version < GLAD_MAKE_VERSION(4, 5))
        throw InputError(what + ": OpenGL 4.5 is needed, " + glText(GL_RENDERER) + " offers " +
                         glText(GL_VERSION));
    collectDebugMessages();
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
}

}  // namespace penumbra::gl
