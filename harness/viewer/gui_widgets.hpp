#pragma once

#include <imgui.h>

#include <string>

/// Small pieces that the window's panels share.
namespace penumbra::gui {

inline constexpr ImU32 kBuildColour = IM_COL32(86, 140, 214, 255);
inline constexpr ImU32 kShadeColour = IM_COL32(235, 160, 66, 255);
inline const ImVec4 kFaint{0.60f, 0.62f, 0.66f, 1.0f};
inline const ImVec4 kGood{0.55f, 0.80f, 0.50f, 1.0f};
inline const ImVec4 kWarning{0.95f, 0.72f, 0.35f, 1.0f};
inline const ImVec4 kAlarm{1.0f, 0.45f, 0.40f, 1.0f};

/// The project's dark look and font, `scale` times as large; call once per ImGui context, before
/// the font atlas is uploaded. `pixelsPerUnit` of the framebuffer keep the font sharp.
void setStyle(float scale, float pixelsPerUnit);

void text(const std::string& text);
void coloured(const ImVec4& colour, const std::string& text);
/// Text under the last item while the mouse is on it.
void tooltip(const std::string& text);
/// A header that folds what follows away; open at first.
bool section(const char* title);
/// One of several buttons of which one is down.
bool option(const char* label, bool chosen);
/// "1.23 ms", four significant digits at most.
std::string milliseconds(double ms);
/// A count with k, M, G beyond four digits.
std::string amount(double value);
/// `text` cut with "..." to `width` units.
std::string shortened(const std::string& text, float width);

}  // namespace penumbra::gui
