#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "harness/viewer/gui_widgets.hpp"
#include "harness/viewer/panels.hpp"

namespace penumbra {
namespace {

/// The unit as it stands behind a slider's number.
std::string suffixOf(const Parameter& p) {
    std::string suffix = p.unit().empty() ? "" : " " + p.unit();
    for (std::size_t i = 0; (i = suffix.find('%', i)) != std::string::npos; i += 2)
        suffix.insert(i, 1, '%');
    return suffix;
}

/// A widget for one parameter; the new value as text if it was changed.
std::optional<std::string> editParameter(const Parameter& p) {
    const std::string label = "##" + p.id();
    const std::vector<std::string> extremes = p.extremes();
    if (p.type() == "bool") {
        bool on = p.number() != 0.0;
        if (ImGui::Checkbox(label.c_str(), &on)) return on ? "true" : "false";
        return {};
    }
    ImGui::SetNextItemWidth(-1.0f);
    if (p.type() == "choice") {
        std::optional<std::string> chosen;
        if (ImGui::BeginCombo(label.c_str(), p.text().c_str())) {
            for (const std::string& choice : extremes)
                if (ImGui::Selectable(choice.c_str(), choice == p.text())) chosen = choice;
            ImGui::EndCombo();
        }
        return chosen;
    }
    const double lo = std::strtod(extremes.front().c_str(), nullptr);
    const double hi = std::strtod(extremes.back().c_str(), nullptr);
    // Over more than two decades a linear slider has no room for the small values.
    ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp;
    if (lo >= 0.0 && hi > 100.0 * std::max(lo, p.isFloat() ? 1e-3 * hi : 1.0))
        flags |= ImGuiSliderFlags_Logarithmic;
    if (p.isFloat()) {
        double value = p.number();
        if (!ImGui::SliderScalar(label.c_str(), ImGuiDataType_Double, &value, &lo, &hi,
                                 ("%.4g" + suffixOf(p)).c_str(), flags))
            return {};
        const double rounded = std::strtod(fmt::format("{:.4g}", value).c_str(), nullptr);
        return fmt::format("{}", std::clamp(rounded, lo, hi));
    }
    int value = static_cast<int>(p.number());
    if (!ImGui::SliderInt(label.c_str(), &value, static_cast<int>(lo), static_cast<int>(hi),
                          ("%d" + suffixOf(p)).c_str(), flags))
        return {};
    return std::to_string(value);
}

void drawParameters(ViewerState& state, LiveMethod& method) {
    if (method.parameters().empty()) {
        gui::coloured(gui::kFaint, "no parameters");
        return;
    }
    if (!ImGui::BeginTable("parameters", 3, ImGuiTableFlags_SizingStretchProp)) return;
    ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthStretch, 0.9f);
    ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthStretch, 1.0f);
    ImGui::TableSetupColumn("reset", ImGuiTableColumnFlags_WidthFixed, 22.0f * state.scale);
    for (const Parameter* p : method.parameters()) {
        ImGui::PushID(p->id().c_str());
        const bool changed = p->text() != p->defaultText();
        const std::string unit = p->unit().empty() ? "" : " " + p->unit();
        const std::string help =
            fmt::format("{}\n\n{}{}; default {}", p->doc(), p->range(), unit, p->defaultText());
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::AlignTextToFramePadding();
        gui::coloured(
            changed ? ImVec4(0.75f, 0.86f, 1.0f, 1.0f) : ImGui::GetStyle().Colors[ImGuiCol_Text],
            gui::shortened(p->id(), ImGui::GetContentRegionAvail().x));
        gui::tooltip(p->id() + ": " + help);
        ImGui::TableNextColumn();
        const std::optional<std::string> value = editParameter(*p);
        gui::tooltip(help);
        ImGui::TableNextColumn();
        const bool reset = changed && ImGui::Button("x");
        if (changed) gui::tooltip("back to " + p->defaultText());
        if (value) state.attempt([&] { method.setParameter(p->id(), *value); });
        if (reset) state.attempt([&] { method.setParameter(p->id(), p->defaultText()); });
        ImGui::PopID();
    }
    ImGui::EndTable();
}

/// The picker of one slot. Slot 1 may be empty.
void drawPicker(ViewerState& state, std::size_t slot) {
    ViewSession& session = state.session;
    LiveMethod* const method = session.method(slot);
    ImGui::AlignTextToFramePadding();
    gui::text(slot == 0 ? "A" : "B");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1.0f);
    if (ImGui::BeginCombo("##method", method ? method->setting().method.c_str() : "none",
                          ImGuiComboFlags_HeightLarge)) {
        if (slot == 1 && ImGui::Selectable("none", !method)) session.dropSecondMethod();
        for (const MethodInfo& info : methodRegistry()) {
            const bool chosen = method && method->setting().method == info.id;
            if (ImGui::Selectable(info.id.c_str(), chosen) && !chosen)
                state.attempt([&] {
                    session.setMethod(slot, info.id);
                    if (slot == 1 && state.display == Display::single) {
                        state.display = Display::split;
                        state.against = Against::method;
                    }
                });
            gui::tooltip(info.title + "\n" + info.source);
        }
        ImGui::EndCombo();
    }
    if (const LiveMethod* shown = session.method(slot)) {
        const MethodInfo& info = findMethod(shown->setting().method);
        gui::tooltip(info.title + "\n" + info.source);
    }
}

void drawMethod(ViewerState& state, std::size_t slot) {
    drawPicker(state, slot);
    LiveMethod* const method = state.session.method(slot);
    if (!method) return;
    if (method->status() != "ok") {
        ImGui::PushTextWrapPos(0.0f);
        gui::coloured(gui::kAlarm, method->status() + ": " + method->message());
        ImGui::PopTextWrapPos();
    } else if (method->work() && !method->work()->message.empty()) {
        ImGui::PushTextWrapPos(0.0f);
        gui::coloured(gui::kFaint, method->work()->message);
        ImGui::PopTextWrapPos();
    }
    drawParameters(state, *method);
    if (!method->atDefaults() && ImGui::Button("Reset all parameters"))
        state.attempt([&] { method->resetParameters(); });
}

void drawCommandLines(ViewerState& state) {
    ViewSession& session = state.session;
    const auto copy = [&](const std::string& line) {
        ImGui::SetClipboardText(line.c_str());
        state.say("copied: " + line);
    };
    if (ImGui::Button("Copy view line"))
        copy(viewLine(session.described(state.display, state.against)));
    gui::tooltip("The command line that opens this window with the same scene and settings");
    ImGui::SameLine();
    if (ImGui::Button("Copy compare line"))
        copy(compareLine(session.described(state.display, state.against)));
    gui::tooltip("The command line that scores and times these settings");
    ImGui::SameLine();
    if (ImGui::Button("Paste")) {
        const char* const line = ImGui::GetClipboardText();
        state.attempt([&] {
            const PastedLine pasted = parseCommandLine(line ? line : "");
            const std::string note = session.take(pasted);
            if (pasted.hasDisplay) {
                state.display = pasted.options.display;
                state.against = pasted.options.against;
            }
            state.say(note.empty() ? "pasted" : "pasted; " + note);
        });
    }
    gui::tooltip("Takes over what a command line of penumbra view or penumbra compare says");
}

}  // namespace

void drawMethodPanel(ViewerState& state) {
    if (!gui::section("Methods")) return;
    for (std::size_t slot = 0; slot < 2; ++slot) {
        ImGui::PushID(static_cast<int>(slot));
        drawMethod(state, slot);
        ImGui::PopID();
        if (slot == 0) ImGui::Separator();
    }
    ImGui::Separator();
    drawCommandLines(state);
}

}  // namespace penumbra
