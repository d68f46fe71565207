#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "harness/viewer/gui_widgets.hpp"
#include "harness/viewer/panels.hpp"

namespace penumbra {
namespace {

const char* slotName(std::size_t slot) {
    return slot == 0 ? "A" : "B";
}

/// A label and a value side by side in a table of two columns.
void line(const char* label, const std::string& value) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    gui::coloured(gui::kFaint, label);
    ImGui::TableNextColumn();
    gui::text(value);
}

void drawReference(const ViewSession& session) {
    const ProgressiveReference& tracing = session.tracing();
    const ProgressiveReference::Estimate* const estimate = session.reference();
    const std::string error = tracing.error();
    if (!error.empty()) {
        ImGui::PushTextWrapPos(0.0f);
        gui::coloured(gui::kAlarm, "reference: " + error);
        ImGui::PopTextWrapPos();
        return;
    }
    if (ImGui::BeginTable("reference", 2, ImGuiTableFlags_SizingStretchProp)) {
        line("Reference", estimate ? estimate->how : "waiting for the first rays");
        std::string known = "-";
        if (estimate)
            known = estimate->standardError ? fmt::format("{:.2g}", *estimate->standardError)
                                            : "no penumbra";
        line("Standard error", known);
        ImGui::EndTable();
    }
    gui::tooltip(
        "rms standard error over the penumbra pixels, of visibility in 0..1. It falls "
        "while nothing moves.");
    const auto progress = static_cast<float>(tracing.progress());
    if (progress < 1.0f)
        ImGui::ProgressBar(progress, {-1.0f, 4.0f}, "");
    else
        ImGui::Dummy({1.0f, 4.0f});
}

}  // namespace

void drawScorePanel(ViewerState& state) {
    if (!gui::section("Reference and error")) return;
    const ViewSession& session = state.session;
    drawReference(session);
    if (!ImGui::BeginTable("scores", 4, ImGuiTableFlags_SizingStretchProp)) return;
    ImGui::TableSetupColumn("");
    ImGui::TableSetupColumn("rmse");
    ImGui::TableSetupColumn("less noise");
    ImGui::TableSetupColumn("bias");
    ImGui::TableHeadersRow();
    for (std::size_t slot = 0; slot < 2; ++slot) {
        if (!session.method(slot)) continue;
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        gui::text(slotName(slot));
        const std::optional<LiveScore>& score = session.score(slot);
        for (const double LiveScore::*member :
             {&LiveScore::rmse, &LiveScore::rmseCorrected, &LiveScore::bias}) {
            ImGui::TableNextColumn();
            if (score)
                gui::text(fmt::format("{:.4f}", (*score).*member));
            else
                gui::coloured(gui::kFaint, "-");
        }
    }
    ImGui::EndTable();
    gui::tooltip(
        "Over the scored pixels, against the reference as it is now. Less noise: without "
        "what the reference's own standard error adds.");
}

namespace {

/// Bars of build under shade, newest at the right.
void drawTimes(const LiveMethod& method, float height, double mostMs) {
    const ImVec2 lo = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::Dummy({width, height});
    ImDrawList* const draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled(lo, {lo.x + width, lo.y + height}, IM_COL32(24, 25, 28, 255), 3.0f);
    const float bar = width / static_cast<float>(LiveMethod::kHistory);
    const float perMs = (height - 4.0f) / static_cast<float>(std::max(mostMs, 1e-6));
    float x = lo.x + width - bar * static_cast<float>(method.times().size());
    for (const SettingRun::Sample& sample : method.times()) {
        const float base = lo.y + height;
        const float built = base - static_cast<float>(sample.buildMs) * perMs;
        const float shaded = built - static_cast<float>(sample.shadeMs) * perMs;
        draw->AddRectFilled({x, built}, {x + bar, base}, gui::kBuildColour);
        draw->AddRectFilled({x, shaded}, {x + bar, built}, gui::kShadeColour);
        x += bar;
    }
    draw->AddText({lo.x + 5.0f, lo.y + 2.0f}, IM_COL32(255, 255, 255, 130),
                  gui::milliseconds(mostMs).c_str());
}

void drawSlotTimes(const ViewSession& session, std::size_t slot, float height) {
    const LiveMethod* const method = session.method(slot);
    if (!method || method->times().empty()) return;
    const SettingRun::Sample& last = method->times().back();
    gui::text(
        fmt::format("{} {}", slotName(slot), gui::shortened(method->setting().method, 130.0f)));
    ImGui::SameLine();
    ImGui::PushStyleColor(ImGuiCol_Text, gui::kBuildColour);
    gui::text(method->keptMaps() ? "maps kept" : "build " + gui::milliseconds(last.buildMs));
    ImGui::PopStyleColor();
    ImGui::SameLine();
    ImGui::PushStyleColor(ImGuiCol_Text, gui::kShadeColour);
    gui::text("shade " + gui::milliseconds(last.shadeMs));
    ImGui::PopStyleColor();
    double most = 0.0;
    for (const SettingRun::Sample& sample : method->times())
        most = std::max(most, sample.buildMs + sample.shadeMs);
    drawTimes(*method, height, most);
}

}  // namespace

void drawTimesPanel(ViewerState& state) {
    if (!gui::section("Time and work")) return;
    const ViewSession& session = state.session;
    for (std::size_t slot = 0; slot < 2; ++slot) drawSlotTimes(session, slot, 46.0f * state.scale);
    ImGui::Checkbox("time again while nothing changes", &state.measure);
    gui::tooltip(
        "Off, a method runs when something changes. On, it runs all the time, and the "
        "reference is slower for it.");
    if (!ImGui::BeginTable("work", 3, ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_RowBg))
        return;
    ImGui::TableSetupColumn("", 0, 1.3f);
    ImGui::TableSetupColumn("A");
    ImGui::TableSetupColumn("B");
    ImGui::TableHeadersRow();
    using Value = std::optional<double> Row::*;
    const std::pair<const char*, Value> counters[] = {
        {"draw calls", &Row::drawCalls},     {"triangles", &Row::triangles},
        {"fragments", &Row::fragments},      {"shadow maps", &Row::maps},
        {"light texels", &Row::lightTexels}, {"textures, MiB", &Row::textureMib},
        {"prepare, ms", &Row::prepareMs}};
    for (const auto& [label, member] : counters) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        gui::coloured(gui::kFaint, label);
        for (std::size_t slot = 0; slot < 2; ++slot) {
            ImGui::TableNextColumn();
            const LiveMethod* const method = session.method(slot);
            if (!method) continue;
            const auto value = method->work() ? (*method->work()).*member : std::nullopt;
            if (value)
                gui::text(gui::amount(*value));
            else
                gui::coloured(gui::kFaint, "-");
        }
    }
    ImGui::EndTable();
    gui::tooltip(
        "One whole frame's work: maps and shading, whether or not the maps are kept. "
        "Counted once nothing changes.");
}

namespace {

/// Why an effect is in the plan or not: the one place where the window says so.
std::string reasonFor(const ViewSession& session, const EffectInfo& info) {
    const EffectFinding& finding = session.findings()[info.effect];
    const bool wanted = session.wanted().has(info.effect);
    std::string reason(info.doc);
    reason += finding.calledFor ? "\n\nCalled for: " : "\n\nNot called for: ";
    reason += finding.evidence + '.';
    if (wanted != finding.calledFor)
        reason += wanted ? " Switched on by hand." : " Switched off by hand.";
    return reason;
}

void drawPlanned(const LiveMethod* method, Effect effect) {
    if (!method) return;
    const Plan& plan = method->plan();
    if (plan.simulated.has(effect))
        gui::coloured(gui::kGood, "simulated");
    else if (plan.missing.has(effect))
        gui::coloured(gui::kAlarm, "missing");
    else if (plan.skipped.has(effect))
        gui::coloured(gui::kFaint, "skipped");
    else
        gui::coloured(gui::kFaint, "-");
}

}  // namespace

void drawEffectsPanel(ViewerState& state) {
    if (!gui::section("Effects")) return;
    ViewSession& session = state.session;
    for (const char* const choice : {"auto", "all", "none"}) {
        if (gui::option(choice, session.effects() == choice)) session.setEffects(choice);
        gui::tooltip(choice == std::string("auto")  ? "what the scene calls for"
                     : choice == std::string("all") ? "every effect, at every pixel"
                                                    : "no effect at all");
        ImGui::SameLine();
    }
    const bool byHand =
        session.effects() != "auto" && session.effects() != "all" && session.effects() != "none";
    gui::coloured(gui::kFaint, byHand ? "switched by hand" : "or switch by hand");
    if (!ImGui::BeginTable("effects", 3, ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_RowBg))
        return;
    ImGui::TableSetupColumn("wanted", 0, 1.5f);
    ImGui::TableSetupColumn("A");
    ImGui::TableSetupColumn("B");
    ImGui::TableHeadersRow();
    for (const EffectInfo& info : allEffects()) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        bool on = session.wanted().has(info.effect);
        if (ImGui::Checkbox(std::string(info.id).c_str(), &on))
            session.switchEffect(info.effect, on);
        gui::tooltip(reasonFor(session, info));
        for (std::size_t slot = 0; slot < 2; ++slot) {
            ImGui::TableNextColumn();
            drawPlanned(session.method(slot), info.effect);
        }
    }
    ImGui::EndTable();
}

}  // namespace penumbra
