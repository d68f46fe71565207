#pragma once

#include <imgui.h>

#include <optional>

#include "harness/viewer/light_handles.hpp"
#include "harness/viewer/picture.hpp"
#include "harness/viewer/viewer_state.hpp"

namespace penumbra {

/// The middle of the window: the images as they are compared, with the light's handles and the
/// split line on them, and the hand that moves camera, light and line.
class ImageView {
  public:
    /// Fills what is left of the current ImGui window.
    void draw(ViewerState& state);

    /// Where an image was drawn last, in ImGui's units; the second is empty but side by side.
    struct Pane {
        ImVec2 lo{0, 0}, hi{0, 0};
        bool holds(ImVec2 p) const {
            return p.x >= lo.x && p.x < hi.x && p.y >= lo.y && p.y < hi.y;
        }
        float width() const { return hi.x - lo.x; }
        float height() const { return hi.y - lo.y; }
    };
    const Pane& pane(std::size_t i) const { return panes_[i]; }

  private:
    void refresh(const ViewerState& state);
    void layOut(const ViewerState& state, ImVec2 lo, ImVec2 size);
    void drawImages(const ViewerState& state) const;
    void drawLabel(const ViewerState& state, const Pane& pane, std::size_t side) const;
    void drawFailure(const ViewerState& state, const Pane& pane, std::size_t slot) const;
    void drawHandles(const ViewerState& state, const Pane& pane) const;
    void drawScale(const ViewerState& state) const;
    void handleMouse(ViewerState& state, bool hovered);
    void handleKeys(ViewerState& state, bool hovered);
    bool onSplit(const ViewerState& state, ImVec2 mouse) const;
    glm::dvec2 imagePosition(const ViewerState& state, const Pane& pane, ImVec2 mouse) const;
    HandleView handleView(const ViewerState& state) const;

    enum class Grip { none, split, light, orbit, look, pan };
    Grip grip_ = Grip::none;
    std::size_t gripPane_ = 0;
    ImVec2 gripAt_{0, 0};
    LightHandle handle_ = LightHandle::none, hovered_ = LightHandle::none;
    AreaLight gripLight_;
    Camera gripCamera_;
    HandleView gripView_;
    glm::dvec3 pivot_{0.0};

    Pane panes_[2];
    Picture left_, right_, difference_;
    struct Shown {
        std::uint64_t frame = 0, left = 0, right = 0;
        float exposure = 0.0f;
        bool difference = false;
        bool operator==(const Shown&) const = default;
    };
    std::optional<Shown> shown_;
};

/// The point that a camera turns about: what the middle of its image shows, or as far away as the
/// scene where it shows nothing.
glm::dvec3 pivotOf(const ViewSession& session);

}  // namespace penumbra
