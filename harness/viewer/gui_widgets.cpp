#include "harness/viewer/gui_widgets.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

namespace penumbra::gui {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float kFontSize = 14.0f;

}  // namespace

void setStyle(float scale, float pixelsPerUnit) {
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = 0.0f;
    style.FrameRounding = 3.0f;
    style.GrabRounding = 3.0f;
    style.ScrollbarSize = 12.0f;
    style.WindowBorderSize = 0.0f;
    style.FramePadding = {7.0f, 4.0f};
    style.ItemSpacing = {7.0f, 5.0f};
    style.WindowPadding = {10.0f, 9.0f};
    ImVec4* const c = style.Colors;
    c[ImGuiCol_WindowBg] = {0.115f, 0.120f, 0.130f, 1.0f};
    c[ImGuiCol_PopupBg] = {0.145f, 0.150f, 0.165f, 1.0f};
    c[ImGuiCol_FrameBg] = {0.20f, 0.21f, 0.23f, 1.0f};
    c[ImGuiCol_FrameBgHovered] = {0.26f, 0.28f, 0.31f, 1.0f};
    c[ImGuiCol_FrameBgActive] = {0.30f, 0.33f, 0.37f, 1.0f};
    c[ImGuiCol_Header] = {0.18f, 0.20f, 0.235f, 1.0f};
    c[ImGuiCol_HeaderHovered] = {0.24f, 0.28f, 0.34f, 1.0f};
    c[ImGuiCol_HeaderActive] = {0.27f, 0.33f, 0.41f, 1.0f};
    c[ImGuiCol_Button] = {0.22f, 0.24f, 0.275f, 1.0f};
    c[ImGuiCol_ButtonHovered] = {0.28f, 0.34f, 0.43f, 1.0f};
    c[ImGuiCol_ButtonActive] = {0.26f, 0.44f, 0.66f, 1.0f};
    c[ImGuiCol_SliderGrab] = {0.38f, 0.56f, 0.80f, 0.60f};
    c[ImGuiCol_SliderGrabActive] = {0.50f, 0.68f, 0.92f, 0.75f};
    c[ImGuiCol_CheckMark] = {0.55f, 0.74f, 0.98f, 1.0f};
    c[ImGuiCol_PlotHistogram] = {0.38f, 0.56f, 0.80f, 1.0f};
    c[ImGuiCol_Separator] = {0.24f, 0.25f, 0.28f, 1.0f};
    c[ImGuiCol_TableRowBgAlt] = {1.0f, 1.0f, 1.0f, 0.025f};
    style.ScaleAllSizes(scale);

    ImGuiIO& io = ImGui::GetIO();
    const float pixels = std::round(kFontSize * scale * pixelsPerUnit);
    if (std::filesystem::exists(kFont)) {
        io.Fonts->AddFontFromFileTTF(kFont, pixels);
    } else {
        ImFontConfig config;
        config.SizePixels = pixels;
        io.Fonts->AddFontDefault(&config);
    }
    io.FontGlobalScale = 1.0f / pixelsPerUnit;
}

void text(const std::string& text) {
    ImGui::TextUnformatted(text.data(), text.data() + text.size());
}

void coloured(const ImVec4& colour, const std::string& words) {
    ImGui::PushStyleColor(ImGuiCol_Text, colour);
    text(words);
    ImGui::PopStyleColor();
}

void tooltip(const std::string& words) {
    if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 26.0f);
    text(words);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

bool section(const char* title) {
    return ImGui::CollapsingHeader(title, ImGuiTreeNodeFlags_DefaultOpen);
}

bool option(const char* label, bool chosen) {
    if (chosen)
        ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyle().Colors[ImGuiCol_ButtonActive]);
    const bool clicked = ImGui::Button(label);
    if (chosen) ImGui::PopStyleColor();
    return clicked;
}

std::string milliseconds(double ms) {
    return fmt::format("{:.{}f} ms", ms, ms >= 100 ? 0 : ms >= 10 ? 1 : 2);
}

std::string amount(double value) {
    for (const auto& [unit, suffix] :
         {std::pair(1e9, "G"), std::pair(1e6, "M"), std::pair(1e3, "k")})
        if (value >= 10.0 * unit || (unit >= 1e6 && value >= unit))
            return fmt::format("{:.3g} {}", value / unit, suffix);
    return fmt::format("{:.{}g}", value, value < 1e3 ? 3 : 4);
}

std::string shortened(const std::string& text, float width) {
    if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
    std::string cut = text;
    while (!cut.empty() && ImGui::CalcTextSize((cut + "...").c_str()).x > width) {
        while (!cut.empty() && (static_cast<unsigned char>(cut.back()) & 0xc0) == 0x80)
            cut.pop_back();  // a whole UTF-8 sequence
        if (!cut.empty()) cut.pop_back();
    }
    return cut + "...";
}

}  // namespace penumbra::gui
