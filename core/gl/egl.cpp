#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/gl/backends.hpp"

namespace penumbra::gl {
namespace {

template <class Function>
Function entryPoint(const char* name) {
    return reinterpret_cast<Function>(eglGetProcAddress(name));
}

bool lists(const char* extensions, std::string_view name) {
    std::string_view rest = extensions ? extensions : "";
    while (!rest.empty()) {
        const std::size_t end = rest.find(' ');
        if (rest.substr(0, end) == name) return true;
        rest = end == std::string_view::npos ? "" : rest.substr(end + 1);
    }
    return false;
}

/// One way to a display: a device, or Mesa's surfaceless platform.
struct Candidate {
    std::string name;
    EGLenum platform = 0;
    void* nativeDisplay = nullptr;
    bool software = false;  ///< known to be, before it is opened
};

std::vector<Candidate> candidates() {
    const char* clientExtensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    std::vector<Candidate> found;
    if (lists(clientExtensions, "EGL_EXT_platform_device")) {
        const auto queryDevices = entryPoint<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
        const auto queryDeviceString =
            entryPoint<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
        std::array<EGLDeviceEXT, 32> devices{};
        EGLint count = 0;
        if (!queryDevices ||
            !queryDevices(static_cast<EGLint>(devices.size()), devices.data(), &count))
            count = 0;
        for (EGLint i = 0; i < count; ++i) {
            EGLDeviceEXT device = devices[static_cast<std::size_t>(i)];
            const char* extensions =
                queryDeviceString ? queryDeviceString(device, EGL_EXTENSIONS) : nullptr;
            found.push_back({fmt::format("device {}", i), EGL_PLATFORM_DEVICE_EXT, device,
                             lists(extensions, "EGL_MESA_device_software")});
        }
    }
    if (lists(clientExtensions, "EGL_MESA_platform_surfaceless"))
        found.push_back({"surfaceless platform", EGL_PLATFORM_SURFACELESS_MESA, nullptr, false});
    return found;
}

class EglContext final : public Context {
  public:
    explicit EglContext(const Candidate& candidate) : name_("egl, " + candidate.name) {
        display_ = eglGetPlatformDisplay(candidate.platform, candidate.nativeDisplay, nullptr);
        EGLint major = 0, minor = 0;
        if (display_ == EGL_NO_DISPLAY || !eglInitialize(display_, &major, &minor))
            throw failure("cannot be opened");
        try {
            open();
        } catch (...) {
            close();
            throw;
        }
    }
    ~EglContext() override { close(); }
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    ContextKind kind() const override { return ContextKind::egl; }

  private:
    InputError failure(const char* what) const {
        return InputError(fmt::format("{} {} (EGL error {:#x})", name_, what, eglGetError()));
    }

    void open() {
        if (!lists(eglQueryString(display_, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context"))
            throw failure("cannot render without a surface");
        if (!eglBindAPI(EGL_OPENGL_API)) throw failure("has no desktop OpenGL");
        // A debug context is not asked for: drivers slow down under it, and times are what is
        // measured here. Messages that come without it, and glGetError, are collected.
        const std::array<EGLint, 7> contextAttributes = {EGL_CONTEXT_MAJOR_VERSION,
                                                         4,
                                                         EGL_CONTEXT_MINOR_VERSION,
                                                         5,
                                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                                         EGL_NONE};
        context_ =
            eglCreateContext(display_, chooseConfig(), EGL_NO_CONTEXT, contextAttributes.data());
        if (context_ == EGL_NO_CONTEXT) throw failure("has no OpenGL 4.5 core context");
        if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
            throw failure("cannot make its context current");
        initialise(eglGetProcAddress, name_);
    }

    EGLConfig chooseConfig() const {
        if (lists(eglQueryString(display_, EGL_EXTENSIONS), "EGL_KHR_no_config_context"))
            return EGL_NO_CONFIG_KHR;
        const std::array<EGLint, 5> attributes = {EGL_SURFACE_TYPE, EGL_DONT_CARE,
                                                  EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
        EGLConfig config = nullptr;
        EGLint count = 0;
        if (!eglChooseConfig(display_, attributes.data(), &config, 1, &count) || count == 0)
            throw failure("has no configuration for OpenGL");
        return config;
    }

    void close() {
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
        eglTerminate(display_);
    }

    std::string name_;
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
};

/// The first candidate that opens and is, or is not, rendered in software; null if none does.
/// Reasons of those that failed are added to `reasons`.
std::unique_ptr<Context> openFirst(const std::vector<Candidate>& all, bool software,
                                   std::string& reasons) {
    for (const Candidate& candidate : all) {
        if (candidate.software && !software) continue;
        try {
            auto context = std::make_unique<EglContext>(candidate);
            if (isSoftwareRenderer(context->renderer()) == software) return context;
        } catch (const InputError& e) {
            reasons += std::string(reasons.empty() ? "" : "; ") + e.what();
        }
    }
    return nullptr;
}

}  // namespace

std::unique_ptr<Context> createEgl(bool hardwareOnly) {
    // Mesa's loader talks about devices that it cannot open; what matters of that is in our
    // reasons.
    setenv("EGL_LOG_LEVEL", "fatal", /*overwrite=*/0);
    const std::vector<Candidate> all = candidates();
    if (all.empty()) throw InputError("egl: neither the device nor the surfaceless platform here");
    std::string reasons;
    if (auto context = openFirst(all, /*software=*/false, reasons)) return context;
    if (hardwareOnly) throw InputError("egl: no hardware renderer here");
    reasons.clear();  // the same candidates are tried again
    if (auto context = openFirst(all, /*software=*/true, reasons)) return context;
    throw InputError(reasons.empty() ? "egl: no renderer here" : reasons);
}

}  // namespace penumbra::gl
