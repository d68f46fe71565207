#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "harness/viewer/camera_control.hpp"
#include "harness/viewer/image_view.hpp"

namespace penumbra {
namespace {

/// Scene radii a second.
constexpr double kFlySpeed = 0.5, kFastFlySpeed = 2.0;

}  // namespace

void ImageView::handleKeys(ViewerState& state, bool hovered) {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantTextInput || io.KeyCtrl || !(hovered || grip_ == Grip::look)) return;
    const auto held = [](int key) { return ImGui::IsKeyDown(key) ? 1.0 : 0.0; };
    const glm::dvec3 direction(held(GLFW_KEY_D) - held(GLFW_KEY_A),
                               held(GLFW_KEY_E) - held(GLFW_KEY_Q),
                               held(GLFW_KEY_W) - held(GLFW_KEY_S));
    if (direction == glm::dvec3(0.0)) return;
    const double metres = (io.KeyShift ? kFastFlySpeed : kFlySpeed) *
                          state.session.scene().radiusM * static_cast<double>(io.DeltaTime);
    const Camera before = state.session.camera(), after = moved(before, metres * direction);
    state.session.setCamera(after);
    // A drag that goes on starts from where the keys have flown to.
    gripCamera_.position += after.position - before.position;
    pivot_ += after.position - before.position;
}

}  // namespace penumbra
