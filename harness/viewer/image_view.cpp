#include "harness/viewer/image_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/gtc/constants.hpp>

#include "harness/viewer/camera_control.hpp"
#include "harness/viewer/gui_widgets.hpp"

namespace penumbra {
namespace {

constexpr float kGap = 6.0f;
constexpr ImU32 kLine = IM_COL32(255, 255, 255, 230);

ImTextureID textureOf(const Picture& picture) {
    return reinterpret_cast<ImTextureID>(std::uintptr_t{picture.id()});
}

/// The largest rectangle of `aspect` amid a region.
ImageView::Pane fitted(ImVec2 lo, ImVec2 size, float aspect) {
    const float width = std::max(1.0f, std::min(size.x, size.y * aspect));
    const float height = std::max(1.0f, std::min(size.y, size.x / aspect));
    const ImVec2 at(std::floor(lo.x + 0.5f * (size.x - width)),
                    std::floor(lo.y + 0.5f * (size.y - height)));
    return {at, {at.x + width, at.y + height}};
}

}  // namespace

glm::dvec3 pivotOf(const ViewSession& session) {
    const Camera& camera = session.camera();
    const GBuffer& gbuffer = session.frame().gbuffer;
    const std::size_t middle =
        static_cast<std::size_t>(gbuffer.height / 2) * gbuffer.width + gbuffer.width / 2;
    if (gbuffer.mask[middle] != PixelClass::background) return glm::dvec3(gbuffer.position[middle]);
    return camera.position -
           std::max(session.scene().radiusM, -glm::dot(camera.back, -camera.position)) *
               camera.back;
}

HandleView ImageView::handleView(const ViewerState& state) const {
    const double imagePerUnit = state.session.height() / std::max(1.0f, panes_[0].height());
    return {state.session.camera(), state.session.width(), state.session.height(),
            90.0 * state.scale * imagePerUnit};
}

glm::dvec2 ImageView::imagePosition(const ViewerState& state, const Pane& pane,
                                    ImVec2 mouse) const {
    return {(mouse.x - pane.lo.x) / pane.width() * state.session.width(),
            (mouse.y - pane.lo.y) / pane.height() * state.session.height()};
}

void ImageView::refresh(const ViewerState& state) {
    const ViewSession& session = state.session;
    const LiveMethod& first = *session.method(0);
    const bool againstReference = state.against == Against::reference;
    const LiveMethod* const second = session.method(1);
    const Shown now{session.frameVersion(), first.imageVersion(),
                    againstReference ? session.referenceVersion() + (1ull << 63)
                    : second         ? second->imageVersion()
                                     : 0,
                    state.exposure, state.display == Display::difference};
    if (shown_ == now) return;
    const bool sameLight = shown_ && shown_->frame == now.frame && shown_->exposure == now.exposure;
    const GBuffer& gbuffer = session.frame().gbuffer;
    const PictureLight light = exposed(pictureLight(gbuffer), state.exposure);
    const auto shade = [&](Picture& picture, const std::vector<float>& visibility) {
        if (visibility.size() == gbuffer.size())
            picture.upload(shadeVisibility(gbuffer, visibility, light));
        else
            picture.clear();
    };
    if (!sameLight || shown_->left != now.left) shade(left_, first.visibility());
    if (!sameLight || shown_->right != now.right) shade(right_, state.other());
    if (now.difference)
        difference_.upload(differenceMap(gbuffer, first.visibility(), state.other()));
    shown_ = now;
}

void ImageView::layOut(const ViewerState& state, ImVec2 lo, ImVec2 size) {
    const float aspect =
        static_cast<float>(state.session.width()) / static_cast<float>(state.session.height());
    panes_[1] = {};
    if (state.display != Display::side) {
        panes_[0] = fitted(lo, size, aspect);
        return;
    }
    const ImVec2 half(0.5f * (size.x - kGap), size.y);
    panes_[0] = fitted(lo, half, aspect);
    panes_[1] = fitted({lo.x + half.x + kGap, lo.y}, half, aspect);
}

void ImageView::drawImages(const ViewerState& state) const {
    ImDrawList* const draw = ImGui::GetWindowDrawList();
    const auto image = [&](const Picture& picture, const Pane& pane, float from, float to) {
        const float x0 = pane.lo.x + from * pane.width(), x1 = pane.lo.x + to * pane.width();
        if (picture.empty())
            draw->AddRectFilled({x0, pane.lo.y}, {x1, pane.hi.y}, IM_COL32(34, 35, 39, 255));
        else
            draw->AddImage(textureOf(picture), {x0, pane.lo.y}, {x1, pane.hi.y}, {from, 0.0f},
                           {to, 1.0f});
    };
    switch (state.display) {
        case Display::single:
            image(left_, panes_[0], 0.0f, 1.0f);
            break;
        case Display::side:
            image(left_, panes_[0], 0.0f, 1.0f);
            image(right_, panes_[1], 0.0f, 1.0f);
            break;
        case Display::split:
            image(left_, panes_[0], 0.0f, state.split);
            image(right_, panes_[0], state.split, 1.0f);
            break;
        case Display::difference:
            image(difference_, panes_[0], 0.0f, 1.0f);
            break;
    }
}

void ImageView::drawFailure(const ViewerState& state, const Pane& pane, std::size_t slot) const {
    const LiveMethod* const method = state.session.method(slot);
    if (!method || method->status() == "ok") return;
    const std::string words = method->status() + ": " + method->message();
    const float width = std::max(20.0f, pane.width() - 40.0f * state.scale);
    const ImVec2 size = ImGui::CalcTextSize(words.c_str(), nullptr, false, width);
    const ImVec2 at(pane.lo.x + 0.5f * (pane.width() - size.x),
                    pane.lo.y + 0.5f * (pane.height() - size.y));
    ImGui::GetWindowDrawList()->AddText(ImGui::GetFont(), ImGui::GetFontSize(), at,
                                        ImGui::GetColorU32(gui::kAlarm), words.c_str(), nullptr,
                                        width);
}

void ImageView::drawLabel(const ViewerState& state, const Pane& pane, std::size_t side) const {
    const ViewSession& session = state.session;
    std::string words;
    if (side == 1 && state.against == Against::reference) {
        words = "reference";
        if (const auto* estimate = session.reference()) words += ": " + estimate->how;
    } else if (const LiveMethod* method = session.method(side)) {
        words = fmt::format("{} {}", side == 0 ? "A" : "B", method->setting().method);
        if (!method->times().empty()) {
            const SettingRun::Sample& last = method->times().back();
            words += "   " + gui::milliseconds(last.buildMs + last.shadeMs);
        }
        if (const auto& score = session.score(side))
            words += fmt::format("   rmse {:.4f}", score->rmse);
    } else {
        words = "no method B: choose one on the left";
    }
    if (state.display == Display::difference && side == 0)
        words += state.against == Against::reference ? "   less the reference" : "   less B";
    const ImVec2 size = ImGui::CalcTextSize(words.c_str());
    const float pad = 6.0f * state.scale;
    const bool right = side == 1 && state.display == Display::split;
    const ImVec2 at(right ? pane.hi.x - size.x - 2.0f * pad : pane.lo.x + 2.0f * pad,
                    pane.lo.y + 2.0f * pad);
    ImDrawList* const draw = ImGui::GetWindowDrawList();
    draw->PushClipRect(pane.lo, pane.hi, true);
    draw->AddRectFilled({at.x - pad, at.y - 0.6f * pad},
                        {at.x + size.x + pad, at.y + size.y + 0.6f * pad},
                        IM_COL32(12, 13, 15, 190), 3.0f);
    draw->AddText(at, IM_COL32(255, 255, 255, 235), words.c_str());
    draw->PopClipRect();
}

void ImageView::drawScale(const ViewerState& state) const {
    const Pane& pane = panes_[0];
    const float width = 220.0f * state.scale, height = 10.0f * state.scale;
    const ImVec2 lo(pane.lo.x + 12.0f * state.scale, pane.hi.y - 40.0f * state.scale);
    ImDrawList* const draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled({lo.x - 8.0f, lo.y - 8.0f},
                        {lo.x + width + 8.0f, lo.y + height + 24.0f * state.scale},
                        IM_COL32(12, 13, 15, 200), 3.0f);
    constexpr int kSteps = 44;
    for (int i = 0; i < kSteps; ++i) {
        const float error = kErrorScale * (2.0f * (static_cast<float>(i) + 0.5f) / kSteps - 1.0f);
        const glm::vec3 c = errorColour(error);
        const float x0 = lo.x + width * static_cast<float>(i) / kSteps;
        draw->AddRectFilled({x0, lo.y}, {x0 + width / kSteps + 1.0f, lo.y + height},
                            IM_COL32(srgb8(c.r), srgb8(c.g), srgb8(c.b), 255));
    }
    const auto label = [&](float share, const std::string& words) {
        const float textWidth = ImGui::CalcTextSize(words.c_str()).x;
        draw->AddText({lo.x + share * (width - textWidth), lo.y + height + 3.0f},
                      IM_COL32(255, 255, 255, 220), words.c_str());
    };
    label(0.0f, fmt::format("{} too dark", -kErrorScale));
    label(0.5f, "0");
    label(1.0f, fmt::format("+{} too light", kErrorScale));
}

void ImageView::drawHandles(const ViewerState& state, const Pane& pane) const {
    const HandleView view = handleView(state);
    const AreaLight& light = state.session.light();
    const auto seen = [&](const glm::dvec3& p) -> std::optional<ImVec2> {
        const auto at = projected(view.camera, p, view.width, view.height);
        if (!at || glm::length(*at) > 1e6) return {};
        return ImVec2(pane.lo.x + static_cast<float>(at->x) / view.width * pane.width(),
                      pane.lo.y + static_cast<float>(at->y) / view.height * pane.height());
    };
    ImDrawList* const draw = ImGui::GetWindowDrawList();
    draw->PushClipRect(pane.lo, pane.hi, true);
    const auto corners = light.corners();
    for (std::size_t i = 0; i < 4; ++i) {
        const auto a = seen(corners[i]), b = seen(corners[(i + 1) % 4]);
        if (a && b) draw->AddLine(*a, *b, IM_COL32(255, 236, 150, 255), 2.0f * state.scale);
    }
    const auto centre = seen(light.centre);
    for (const HandlePoint& handle : lightHandles(light, view)) {
        const auto at = seen(handle.at);
        if (!at || !centre) continue;
        const bool hot = handle.handle == (grip_ == Grip::light ? handle_ : hovered_);
        const float r = (hot ? 7.0f : 5.0f) * state.scale;
        ImU32 colour = IM_COL32(255, 236, 150, 255);
        if (handle.handle == LightHandle::alongX) colour = IM_COL32(232, 84, 84, 255);
        if (handle.handle == LightHandle::alongY) colour = IM_COL32(110, 200, 96, 255);
        if (handle.handle == LightHandle::alongZ) colour = IM_COL32(92, 140, 240, 255);
        if (hot) colour = IM_COL32(255, 255, 255, 255);
        switch (handle.handle) {
            case LightHandle::alongX:
            case LightHandle::alongY:
            case LightHandle::alongZ:
            case LightHandle::aim:
                draw->AddLine(*centre, *at, colour, 1.6f * state.scale);
                draw->AddCircleFilled(*at, r, colour);
                break;
            case LightHandle::twist:
                draw->AddCircle(*at, r, colour, 0, 2.0f * state.scale);
                break;
            case LightHandle::widerU:
            case LightHandle::widerV:
                draw->AddRectFilled({at->x - 0.8f * r, at->y - 0.8f * r},
                                    {at->x + 0.8f * r, at->y + 0.8f * r}, colour);
                break;
            default:
                draw->AddCircleFilled(*at, r, colour);
        }
    }
    draw->PopClipRect();
}

bool ImageView::onSplit(const ViewerState& state, ImVec2 mouse) const {
    const Pane& pane = panes_[0];
    return state.display == Display::split && mouse.y >= pane.lo.y && mouse.y < pane.hi.y &&
           std::abs(mouse.x - (pane.lo.x + state.split * pane.width())) < 7.0f * state.scale;
}

void ImageView::handleMouse(ViewerState& state, bool hovered) {
    ImGuiIO& io = ImGui::GetIO();
    ViewSession& session = state.session;
    const std::size_t under = panes_[1].holds(io.MousePos) ? 1 : 0;
    const Pane& pane = panes_[grip_ == Grip::none ? under : gripPane_];
    const glm::dvec2 at = imagePosition(state, pane, io.MousePos);
    const double reach = 10.0 * state.scale * session.height() / std::max(1.0f, pane.height());

    if (grip_ == Grip::none) {
        hovered_ = LightHandle::none;
        if (!hovered) return;
        const bool overLine = onSplit(state, io.MousePos);
        if (state.handles && !overLine && state.display != Display::difference)
            hovered_ = pickHandle(lightHandles(session.light(), handleView(state)),
                                  handleView(state), at, reach);
        if (overLine) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
        if (hovered_ != LightHandle::none) ImGui::SetMouseCursor(ImGuiMouseCursor_Hand);
        if (io.MouseWheel != 0.0f)
            session.setCamera(dollied(session.camera(), pivotOf(session),
                                      std::pow(0.9, static_cast<double>(io.MouseWheel))));
        const bool left = ImGui::IsMouseClicked(ImGuiMouseButton_Left);
        const bool right = ImGui::IsMouseClicked(ImGuiMouseButton_Right);
        const bool middle = ImGui::IsMouseClicked(ImGuiMouseButton_Middle);
        if (!left && !right && !middle) return;
        gripPane_ = under;
        gripAt_ = io.MousePos;
        gripLight_ = session.light();
        gripCamera_ = session.camera();
        gripView_ = handleView(state);
        pivot_ = pivotOf(session);
        handle_ = hovered_;
        grip_ = left && overLine                       ? Grip::split
                : left && handle_ != LightHandle::none ? Grip::light
                : middle || (left && io.KeyShift)      ? Grip::pan
                : left                                 ? Grip::orbit
                                                       : Grip::look;
        return;
    }
    if (!io.MouseDown[0] && !io.MouseDown[1] && !io.MouseDown[2]) {
        grip_ = Grip::none;
        return;
    }
    const ImVec2 by(io.MousePos.x - gripAt_.x, io.MousePos.y - gripAt_.y);
    if (by.x == 0.0f && by.y == 0.0f) return;
    const double perPane = glm::pi<double>() / std::max(1.0f, pane.height());
    switch (grip_) {
        case Grip::split:
            state.split = std::clamp((io.MousePos.x - pane.lo.x) / pane.width(), 0.0f, 1.0f);
            break;
        case Grip::light:
            session.setLight(draggedLight(gripLight_, handle_, gripView_,
                                          imagePosition(state, pane, gripAt_), at));
            break;
        case Grip::orbit:
            session.setCamera(orbited(gripCamera_, pivot_, -by.x * perPane, -by.y * perPane));
            break;
        case Grip::look:
            session.setCamera(turned(gripCamera_, -0.5 * by.x * perPane, -0.5 * by.y * perPane));
            break;
        case Grip::pan: {
            const double metres = metresPerPixel(gripCamera_, pivot_, session.height()) *
                                  session.height() / std::max(1.0f, pane.height());
            session.setCamera(moved(gripCamera_, {-by.x * metres, by.y * metres, 0.0}));
            break;
        }
        case Grip::none:
            break;
    }
}

void ImageView::draw(ViewerState& state) {
    const ImVec2 lo = ImGui::GetCursorScreenPos(), size = ImGui::GetContentRegionAvail();
    if (size.x < 1.0f || size.y < 1.0f) return;
    layOut(state, lo, size);
    ImGui::InvisibleButton("image", size,
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                               ImGuiButtonFlags_MouseButtonMiddle);
    const bool hovered = ImGui::IsItemHovered();
    handleMouse(state, hovered);
    handleKeys(state, hovered);
    if (state.fit) {
        const float pixels = ImGui::GetIO().DisplayFramebufferScale.x;
        const float each = state.display == Display::side ? 0.5f * (size.x - kGap) : size.x;
        state.session.resize(std::clamp(static_cast<int>(each * pixels), 16, 4096),
                             std::clamp(static_cast<int>(size.y * pixels), 16, 4096));
    }
    refresh(state);
    drawImages(state);
    const std::size_t slots = state.display == Display::single ? 1 : 2;
    for (std::size_t side = 0; side < slots; ++side) {
        const Pane& pane = panes_[state.display == Display::side ? side : 0];
        if (side == 0 || state.display != Display::difference) drawLabel(state, pane, side);
        if (side == 0 || state.against == Against::method) drawFailure(state, pane, side);
        if (state.handles && state.display != Display::difference &&
            (side == 0 || state.display == Display::side))
            drawHandles(state, pane);
    }
    if (state.display == Display::split) {
        const Pane& pane = panes_[0];
        const float x = pane.lo.x + state.split * pane.width();
        const float y = 0.5f * (pane.lo.y + pane.hi.y);
        ImDrawList* const draw = ImGui::GetWindowDrawList();
        draw->AddLine({x, pane.lo.y}, {x, pane.hi.y}, kLine, 1.5f * state.scale);
        draw->AddCircleFilled({x, y}, 8.0f * state.scale, kLine);
        draw->AddCircleFilled({x, y}, 5.0f * state.scale, IM_COL32(70, 74, 82, 255));
    }
    if (state.display == Display::difference) drawScale(state);
}

}  // namespace penumbra
