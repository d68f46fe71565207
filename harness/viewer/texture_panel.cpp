#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "core/sampling/sampling.hpp"
#include "harness/viewer/gui_widgets.hpp"
#include "harness/viewer/panels.hpp"
#include "harness/viewer/texture_preview.hpp"

namespace penumbra {

void TexturePanel::draw(ViewerState& state) {
    if (!gui::section("Intermediate textures")) return;
    const ViewSession& session = state.session;
    if (!session.method(slot_)) slot_ = 0;
    if (session.method(1)) {
        if (gui::option("of A", slot_ == 0)) slot_ = 0;
        ImGui::SameLine();
        if (gui::option("of B", slot_ == 1)) slot_ = 1;
        ImGui::SameLine();
    }
    const LiveMethod& method = *session.method(slot_);
    const std::vector<NamedTexture> textures = method.textures();
    if (textures.empty()) {
        gui::coloured(gui::kFaint, method.setting().method + " has none");
        picture_.clear();
        shown_ = 0;
        return;
    }
    auto chosen = std::ranges::find(textures, name_, &NamedTexture::name);
    if (chosen == textures.end()) chosen = textures.begin();
    ImGui::SetNextItemWidth(-1.0f);
    if (ImGui::BeginCombo("##texture", chosen->name.c_str())) {
        for (const NamedTexture& texture : textures)
            if (ImGui::Selectable(texture.name.c_str(), texture.name == chosen->name))
                name_ = texture.name;
        ImGui::EndCombo();
    }
    const int layers = chosen->texture ? std::max(1, chosen->texture->layers()) : 1;
    layer_ = std::clamp(layer_, 0, layers - 1);
    if (layers > 1) {
        ImGui::SetNextItemWidth(-1.0f);
        ImGui::SliderInt("##layer", &layer_, 0, layers - 1, "layer %d",
                         ImGuiSliderFlags_AlwaysClamp);
    }
    const std::uint64_t now =
        std::hash<std::string>()(chosen->name + method.setting().name) ^
        (method.imageVersion() << 20) ^
        hash(static_cast<std::uint32_t>(layer_), static_cast<std::uint32_t>(channel_),
             static_cast<std::uint32_t>(slot_ * 2 + ownRange_));
    int channels = 1;
    if (now != shown_) {
        shown_ = now;
        error_.clear();
        try {
            const TextureLayer layer = readLayer(*chosen, layer_, channel_);
            const bool given = chosen->lo < chosen->hi && !ownRange_;
            const float lo = given ? chosen->lo : layer.lo, hi = given ? chosen->hi : layer.hi;
            picture_.upload(greyPicture(layer, channel_, lo, hi, !chosen->texture));
            caption_ = fmt::format("{} x {}{}, {}; black {:.4g}, white {:.4g}", layer.fullWidth,
                                   layer.fullHeight,
                                   layer.layers > 1 ? fmt::format(" x {}", layer.layers) : "",
                                   formatName(*chosen), lo, hi);
        } catch (const std::exception& e) {
            picture_.clear();
            error_ = e.what();
        }
    }
    if (chosen->texture) channels = channelsOf(*chosen->texture);
    if (channels > 1) {
        for (int c = 0; c < channels; ++c) {
            if (c > 0) ImGui::SameLine();
            const char name[2] = {"RGBA"[c], '\0'};
            if (gui::option(name, channel_ == c)) channel_ = c;
        }
    } else {
        channel_ = 0;
    }
    if (chosen->lo < chosen->hi) {
        if (channels > 1) ImGui::SameLine();
        ImGui::Checkbox("own range", &ownRange_);
        gui::tooltip(
            fmt::format("black and white are its least and greatest value; else {:.4g} "
                        "and {:.4g}",
                        chosen->lo, chosen->hi));
    }
    if (!error_.empty()) gui::coloured(gui::kAlarm, error_);
    if (picture_.empty()) return;
    const float width = ImGui::GetContentRegionAvail().x;
    const float height = width * static_cast<float>(picture_.height()) /
                         static_cast<float>(std::max(1, picture_.width()));
    ImGui::Image(reinterpret_cast<ImTextureID>(std::uintptr_t{picture_.id()}), {width, height});
    ImGui::PushTextWrapPos(0.0f);
    gui::coloured(gui::kFaint, caption_);
    ImGui::PopTextWrapPos();
}

}  // namespace penumbra
