#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "harness/viewer/gui_widgets.hpp"
#include "harness/viewer/panels.hpp"

namespace penumbra {
namespace {

/// Ticks over the slider at the frames that the script lists.
void drawListedFrames(const Timeline& timeline, ImVec2 lo, ImVec2 hi) {
    const double span = timeline.endS() - timeline.beginS();
    const float grab = 0.5f * ImGui::GetStyle().GrabMinSize + 2.0f;
    for (const int frame : timeline.listed) {
        const double share =
            (timeline.timesS[static_cast<std::size_t>(frame)] - timeline.beginS()) / span;
        const float x = lo.x + grab + static_cast<float>(share) * (hi.x - lo.x - 2.0f * grab);
        ImGui::GetWindowDrawList()->AddLine({x, hi.y - 5.0f}, {x, hi.y},
                                            IM_COL32(255, 255, 255, 150), 1.5f);
    }
}

}  // namespace

void drawTimelineBar(ViewerState& state, double elapsedS) {
    ViewSession& session = state.session;
    const Timeline& timeline = session.timeline();
    if (!timeline.moves()) {
        ImGui::AlignTextToFramePadding();
        gui::coloured(gui::kFaint, "nothing in this scene moves");
        return;
    }
    const double begin = timeline.beginS(), end = timeline.endS();
    if (state.playing) {
        state.playS += state.speed * elapsedS;
        if (state.playS > end) state.playS = begin + std::fmod(state.playS - begin, end - begin);
        session.showFrame(timeline.frameAt(state.playS));
    }
    if (ImGui::Button(state.playing ? "Pause" : "Play", {64.0f * state.scale, 0.0f})) {
        state.playing = !state.playing;
        state.playS = session.timeS() >= end ? begin : session.timeS();
    }
    gui::tooltip("space bar");
    ImGui::SameLine();
    const auto showAt = [&](int frame) {
        state.playing = false;
        session.showFrame(frame);
    };
    if (ImGui::Button("|<")) showAt(0);
    ImGui::SameLine();
    if (ImGui::Button("<")) showAt(session.frameIndex() - 1);
    ImGui::SameLine();
    if (ImGui::Button(">")) showAt(session.frameIndex() + 1);
    ImGui::SameLine();
    double time = session.timeS();
    ImGui::SetNextItemWidth(
        std::max(60.0f, ImGui::GetContentRegionAvail().x - 210.0f * state.scale));
    if (ImGui::SliderScalar("##time", ImGuiDataType_Double, &time, &begin, &end, "%.3f s",
                            ImGuiSliderFlags_AlwaysClamp))
        showAt(timeline.frameAt(time));
    gui::tooltip("Ticks are the frames that the scene's script lists: those that compare renders.");
    drawListedFrames(timeline, ImGui::GetItemRectMin(), ImGui::GetItemRectMax());
    ImGui::SameLine();
    const auto listed = std::ranges::find(timeline.listed, session.frameIndex());
    gui::coloured(gui::kFaint, listed == timeline.listed.end()
                                   ? "in between"
                                   : fmt::format("frame {}", listed - timeline.listed.begin()));
    ImGui::SameLine();
    ImGui::SetNextItemWidth(std::max(40.0f, ImGui::GetContentRegionAvail().x));
    const double slowest = 0.1, fastest = 4.0;
    ImGui::SliderScalar("##speed", ImGuiDataType_Double, &state.speed, &slowest, &fastest, "%.2f x",
                        ImGuiSliderFlags_Logarithmic);
    gui::tooltip("how fast the tracks play");
}

}  // namespace penumbra
