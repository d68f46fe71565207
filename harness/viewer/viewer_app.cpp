#include "harness/viewer/viewer_app.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>

#include "harness/viewer/gui_widgets.hpp"

namespace penumbra {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus;

/// A panel at a fixed place; nothing where it has no room.
template <class Draw>
void panel(const char* name, ImVec2 at, ImVec2 size, ImGuiWindowFlags flags, const Draw& draw) {
    if (size.x < 1.0f || size.y < 1.0f) return;
    ImGui::SetNextWindowPos(at);
    ImGui::SetNextWindowSize(size);
    if (ImGui::Begin(name, nullptr, flags)) draw();
    ImGui::End();
}

void drawNotice(ViewerState& state) {
    ImGui::AlignTextToFramePadding();
    if (!state.notice.empty()) {
        gui::coloured(state.noticeIsError ? gui::kAlarm : gui::kGood,
                      gui::shortened(state.notice, ImGui::GetContentRegionAvail().x));
        gui::tooltip(state.notice);
        return;
    }
    gui::coloured(gui::kFaint,
                  "drag: orbit    right button: look    shift or middle button: move    wheel: "
                  "closer    W A S D Q E: fly    F12: screenshot");
}

}  // namespace

void drawTopBar(ViewerState& state) {
    for (const DisplayName& name : kDisplays) {
        if (gui::option(name.title, state.display == name.display)) state.display = name.display;
        ImGui::SameLine();
    }
    ImGui::SameLine(0.0f, 18.0f * state.scale);
    gui::coloured(gui::kFaint, "A against");
    ImGui::SameLine();
    if (gui::option("B", state.against == Against::method)) state.against = Against::method;
    ImGui::SameLine();
    if (gui::option("Reference", state.against == Against::reference)) {
        state.against = Against::reference;
        if (state.display == Display::single) state.display = Display::split;
    }
    ImGui::SameLine(0.0f, 18.0f * state.scale);
    ImGui::SetNextItemWidth(170.0f * state.scale);
    ImGui::SliderFloat("##exposure", &state.exposure, -4.0f, 4.0f, "exposure %+.1f stops",
                       ImGuiSliderFlags_AlwaysClamp);
    ImGui::SameLine();
    if (ImGui::Button("0")) state.exposure = 0.0f;
    gui::tooltip("back to the pictures' own exposure");
}

ViewerApp::ViewerApp(ViewSession& session, const ViewOptions& options, float scale)
    : state_(session) {
    state_.display = options.display;
    state_.against = options.against;
    state_.scale = scale;
    state_.savePath = session.scene().id + "_view.toml";
    state_.playS = session.timeS();
}

void ViewerApp::handleShortcuts() {
    if (ImGui::GetIO().WantTextInput) return;
    if (ImGui::IsKeyPressed(GLFW_KEY_SPACE, false) && !ImGui::IsAnyItemActive()) {
        state_.playing = !state_.playing && state_.session.timeline().moves();
        state_.playS = state_.session.timeS();
    }
    if (ImGui::IsKeyPressed(GLFW_KEY_F12, false))
        state_.screenshot =
            std::filesystem::path(state_.savePath).replace_extension(".png").string();
}

bool ViewerApp::frame(double elapsedS) {
    const ImGuiIO& io = ImGui::GetIO();
    const float scale = state_.scale;
    const ImVec2 size = io.DisplaySize;
    const float bar = 46.0f * scale;
    const float left = std::min(330.0f * scale, 0.3f * size.x);
    const float right = std::min(350.0f * scale, 0.3f * size.x);
    const float middle = size.x - left - right, height = size.y - 3.0f * bar;
    // An image that the session cannot make is no reason to end: it says so and the next is tried.
    bool more = false;
    state_.attempt([&] { more = state_.session.update(state_.measure); });

    handleShortcuts();
    panel("left", {0, 0}, {left, size.y}, kFixed & ~ImGuiWindowFlags_NoScrollbar, [&] {
        drawScenePanel(state_);
        drawMethodPanel(state_);
        drawSavePanel(state_);
    });
    panel("right", {size.x - right, 0}, {right, size.y}, kFixed & ~ImGuiWindowFlags_NoScrollbar,
          [&] {
              drawScorePanel(state_);
              drawTimesPanel(state_);
              drawEffectsPanel(state_);
              textures_.draw(state_);
          });
    panel("top", {left, 0}, {middle, bar}, kFixed, [&] { drawTopBar(state_); });
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {4.0f, 4.0f});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, {0.07f, 0.07f, 0.08f, 1.0f});
    panel("image", {left, bar}, {middle, height}, kFixed | ImGuiWindowFlags_NoScrollWithMouse, [&] {
        if (state_.session.shown()) image_.draw(state_);
    });
    ImGui::PopStyleColor();
    ImGui::PopStyleVar();
    panel("time", {left, bar + height}, {middle, bar}, kFixed,
          [&] { drawTimelineBar(state_, elapsedS); });
    panel("notice", {left, 2.0f * bar + height}, {middle, bar}, kFixed,
          [&] { drawNotice(state_); });
    return more || state_.playing || state_.measure || !state_.session.still();
}

std::vector<std::uint8_t> readFramebuffer(GLuint framebuffer, int width, int height) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
    const std::size_t stride = 3 * static_cast<std::size_t>(width);
    std::vector<std::uint8_t> bytes(stride * static_cast<std::size_t>(height));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
    for (int y = 0; y < height / 2; ++y)
        std::swap_ranges(bytes.begin() + static_cast<std::ptrdiff_t>(stride * y),
                         bytes.begin() + static_cast<std::ptrdiff_t>(stride * (y + 1)),
                         bytes.begin() + static_cast<std::ptrdiff_t>(stride * (height - 1 - y)));
    return bytes;
}

}  // namespace penumbra
