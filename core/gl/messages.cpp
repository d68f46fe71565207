#include "core/gl/backends.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glad/gl.h>

#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/gl/context.hpp"

namespace penumbra::gl {
namespace {

/// More than this many between two calls of takeErrors say nothing new.
constexpr std::size_t kMaxMessages = 16;

/// The callback is C and may come from a driver's own thread.
struct Messages {
    std::mutex mutex;
    std::vector<std::string> texts;

    void add(std::string text) {
        const std::scoped_lock lock(mutex);
        if (texts.size() < kMaxMessages) texts.push_back(std::move(text));
    }
    std::vector<std::string> take() {
        const std::scoped_lock lock(mutex);
        return std::exchange(texts, {});
    }
};

Messages& messages() {
    static Messages collected;
    return collected;
}

/// Shader logs are left out because Program reports them itself with files and lines, advice about
/// performance because it says nothing about correctness.
bool isError(GLenum source, GLenum type, GLenum severity) {
    if (source == GL_DEBUG_SOURCE_SHADER_COMPILER || type == GL_DEBUG_TYPE_PERFORMANCE)
        return false;
    return type == GL_DEBUG_TYPE_ERROR || severity == GL_DEBUG_SEVERITY_HIGH ||
           severity == GL_DEBUG_SEVERITY_MEDIUM;
}

void GLAD_API_PTR onDebugMessage(GLenum source, GLenum type, GLuint, GLenum severity,
                                 GLsizei length, const GLchar* text, const void*) {
    if (!isError(source, type, severity)) return;
    std::string message = length >= 0 ? std::string(text, static_cast<std::size_t>(length)) : text;
    while (!message.empty() && (message.back() == '\n' || message.back() == ' '))
        message.pop_back();
    messages().add(std::move(message));
}

std::string errorName(GLenum error) {
    switch (error) {
        case GL_INVALID_ENUM:
            return "GL_INVALID_ENUM";
        case GL_INVALID_VALUE:
            return "GL_INVALID_VALUE";
        case GL_INVALID_OPERATION:
            return "GL_INVALID_OPERATION";
        case GL_INVALID_FRAMEBUFFER_OPERATION:
            return "GL_INVALID_FRAMEBUFFER_OPERATION";
        case GL_OUT_OF_MEMORY:
            return "GL_OUT_OF_MEMORY";
        case GL_CONTEXT_LOST:
            return "GL_CONTEXT_LOST";
        default:
            return fmt::format("GL error {:#x}", error);
    }
}

}  // namespace

void collectDebugMessages() {
    messages().take();
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(onDebugMessage, nullptr);
}

std::string takeErrors() {
    std::vector<std::string> names;
    // Bounded, because a lost context may answer GL_CONTEXT_LOST for ever.
    for (std::size_t i = 0; i < kMaxMessages; ++i) {
        const GLenum error = glGetError();
        if (error == GL_NO_ERROR) break;
        names.push_back(errorName(error));
    }
    // A message says what glGetError says, and where; names are for drivers that sent none.
    const std::vector<std::string> texts = messages().take();
    return fmt::format("{}", fmt::join(texts.empty() ? names : texts, "; "));
}

void checkErrors(const std::string& where) {
    const std::string errors = takeErrors();
    if (!errors.empty()) throw std::runtime_error(where + ": " + errors);
}

}  // namespace penumbra::gl
