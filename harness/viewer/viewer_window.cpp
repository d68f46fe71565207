#include "harness/viewer/viewer_window.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "core/error.hpp"
#include "core/gl/window.hpp"
#include "harness/run/thread_limit.hpp"
#include "harness/viewer/gui_renderer.hpp"
#include "harness/viewer/gui_widgets.hpp"
#include "harness/viewer/viewer_app.hpp"

namespace penumbra {
namespace {

/// How long an idle window sleeps before it looks for a better reference.
constexpr double kIdleS = 0.2;
/// Frames that ImGui needs to settle its layout before a screenshot.
constexpr int kSettlingFrames = 3;

std::unique_ptr<gl::Window> openWindow(const ViewOptions& options) {
    try {
        return std::make_unique<gl::Window>(gl::WindowOptions{
            "Penumbra", options.windowWidth, options.windowHeight, /*visible=*/true});
    } catch (const InputError& e) {
        throw InputError(fmt::format(
            "view: {}; the window needs an X or Wayland display with OpenGL 4.5 (DISPLAY or "
            "WAYLAND_DISPLAY); without one, xvfb-run -a penumbra view --screenshot FILE draws it",
            e.what()));
    }
}

/// ImGui on a window: what its backend and the renderer need around a frame.
class Gui {
  public:
    explicit Gui(GLFWwindow* window) : window_(window) {
        IMGUI_CHECKVERSION();
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr;
        int units = 0, pixels = 0;
        glfwGetWindowSize(window, &units, nullptr);
        glfwGetFramebufferSize(window, &pixels, nullptr);
        float content = 1.0f;
        glfwGetWindowContentScale(window, &content, nullptr);
        const float perUnit =
            units > 0 && pixels > 0 ? static_cast<float>(pixels) / static_cast<float>(units) : 1.0f;
        scale_ = std::max(1.0f, content / perUnit);
        gui::setStyle(scale_, perUnit);
        ImGui_ImplGlfw_InitForOther(window, /*install_callbacks=*/true);
        renderer_ = std::make_unique<GuiRenderer>();
    }
    ~Gui() {
        renderer_.reset();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;

    float scale() const { return scale_; }
    void begin() {
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
    }
    void end() {
        ImGui::Render();
        renderer_->draw(*ImGui::GetDrawData(), 0);
    }

  private:
    GLFWwindow* window_;
    float scale_ = 1.0f;
    std::unique_ptr<GuiRenderer> renderer_;
};

void writeScreenshot(GLFWwindow* window, const std::filesystem::path& path) {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window, &width, &height);
    writePngBytes(path, width, height, readFramebuffer(0, width, height));
}

}  // namespace

int runViewer(const ViewOptions& options) {
    const ThreadLimit limit(options.threadCount());
    const auto window = openWindow(options);
    GLFWwindow* const handle = window->handle();
    std::deque<std::string> dropped;
    glfwSetWindowUserPointer(handle, &dropped);
    glfwSetDropCallback(handle, [](GLFWwindow* w, int count, const char** paths) {
        auto& files = *static_cast<std::deque<std::string>*>(glfwGetWindowUserPointer(w));
        files.insert(files.end(), paths, paths + count);
    });
    Gui gui(handle);
    ViewSession session(options);
    ViewerApp app(session, options, gui.scale());
    const double begunS = glfwGetTime();
    double beforeS = begunS;
    int settled = 0;
    bool busy = true;
    while (!glfwWindowShouldClose(handle)) {
        int width = 0, height = 0;
        glfwGetFramebufferSize(handle, &width, &height);
        if (width <= 0 || height <= 0 || glfwGetWindowAttrib(handle, GLFW_ICONIFIED)) {
            glfwWaitEventsTimeout(kIdleS);
            beforeS = glfwGetTime();
            continue;
        }
        if (busy)
            glfwPollEvents();
        else
            glfwWaitEventsTimeout(kIdleS);
        for (; !dropped.empty(); dropped.pop_front()) app.state().open(dropped.front());
        const double nowS = glfwGetTime();
        gui.begin();
        busy = app.frame(nowS - beforeS);
        beforeS = nowS;
        gui.end();
        app.state().attempt([] { gl::checkErrors("view"); });
        if (!app.state().screenshot.empty()) {
            app.state().attempt([&] {
                writeScreenshot(handle, app.state().screenshot);
                app.state().say("wrote " + app.state().screenshot);
            });
            app.state().screenshot.clear();
        }
        glfwSetWindowTitle(handle, fmt::format("{} - Penumbra", session.scene().id).c_str());
        if (!options.screenshot.empty()) {
            const bool known = options.settleS <= 0.0 || nowS - begunS > options.settleS ||
                               (session.reference() && session.reference()->converged) ||
                               !session.tracing().error().empty();
            settled = !busy && known ? settled + 1 : 0;
            if (settled >= kSettlingFrames) {
                writeScreenshot(handle, options.screenshot);
                break;
            }
        }
        glfwSwapBuffers(handle);
    }
    return 0;
}

}  // namespace penumbra
