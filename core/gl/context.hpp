#pragma once

#include <memory>
#include <string>

namespace penumbra::gl {

enum class ContextKind { osmesa, egl, glfw, automatic };

/// Parses osmesa | egl | glfw | auto; throws InputError naming them.
ContextKind parseContextKind(const std::string& text);

/// An OpenGL 4.5 core context without a visible window, current on the thread that made it, with
/// every entry point loaded through the context's own getProcAddress and a KHR_debug callback that
/// collects messages of severity high or medium and errors. One at a time per process.
///
/// osmesa: Mesa's software renderer, needs neither display nor GPU. egl: an EGL device (the first
/// that gives 4.5 core, hardware before software) or the surfaceless platform. glfw: a hidden
/// window, needs a display. auto: egl on a hardware renderer where there is one, else osmesa.
///
/// Clip space is set once here and by nobody else: glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE), so
/// that reversed depth keeps its precision. All other state is set by the pass that needs it, pixel
/// pack and unpack alignment by whoever transfers.
class Context {
  public:
    virtual ~Context() = default;
    /// Throws InputError with the reason when the kind is not to be had here.
    static std::unique_ptr<Context> create(ContextKind kind);

    virtual ContextKind kind() const = 0;
    std::string renderer() const;  ///< GL_RENDERER
    std::string version() const;   ///< GL_VERSION
};

/// Debug messages (severity high or medium, or type error) since the last call, joined with "; ".
/// Empty when there were none. Also drains glGetError.
std::string takeErrors();

/// Throws std::runtime_error with `where` and takeErrors() if there were any.
void checkErrors(const std::string& where);

/// Fenced wall time: glFinish before and after, monotonic clock. Milliseconds.
class FencedTimer {
  public:
    FencedTimer();        ///< glFinish, then starts
    double stop() const;  ///< glFinish, then milliseconds since the start

  private:
    double startMs_;
};

/// The start-up self-test of timer queries: draws known work under GL_TIME_ELAPSED and the fenced
/// clock. Queries are trusted only if both agree within 10 %; under llvmpipe they do not.
struct ClockSelfTest {
    double fencedMs = 0.0;
    double queryMs = 0.0;
    bool timerQueriesTrusted = false;
};
ClockSelfTest runClockSelfTest();

}  // namespace penumbra::gl
