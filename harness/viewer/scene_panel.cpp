#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "harness/viewer/camera_control.hpp"
#include "harness/viewer/gui_widgets.hpp"
#include "harness/viewer/light_handles.hpp"
#include "harness/viewer/panels.hpp"
#include "harness/viewer/save_view.hpp"

namespace penumbra {
namespace {

constexpr std::array<int, 4> kSizes = {128, 256, 512, 1024};

void drawScenePicker(ViewerState& state) {
    ViewSession& session = state.session;
    ImGui::SetNextItemWidth(-1.0f);
    if (ImGui::BeginCombo("##scene",
                          gui::shortened(session.sceneName(), 280.0f * state.scale).c_str(),
                          ImGuiComboFlags_HeightLarge)) {
        for (const std::string& id : SceneLibrary::standard().ids())
            if (ImGui::Selectable(id.c_str(), id == session.sceneName())) state.open(id);
        ImGui::EndCombo();
    }
    gui::tooltip(session.sceneName() +
                 "\n\nA .toml script, .glb or .gltf dropped on the window is opened, too.");
    const Scene& scene = session.scene();
    ImGui::PushTextWrapPos(0.0f);
    if (!scene.shows.empty()) gui::coloured(gui::kFaint, scene.shows);
    for (const std::string& note : scene.chosen) gui::coloured(gui::kWarning, note);
    ImGui::PopTextWrapPos();
    gui::coloured(gui::kFaint,
                  fmt::format("{} triangles, radius {:.3g} m",
                              session.state().geometry->triangleCount(), scene.radiusM));
}

void drawSize(ViewerState& state) {
    ViewSession& session = state.session;
    ImGui::AlignTextToFramePadding();
    gui::text("Image");
    ImGui::SameLine(70.0f * state.scale);
    ImGui::SetNextItemWidth(-1.0f);
    const std::string now =
        fmt::format("{} x {}{}", session.width(), session.height(), state.fit ? ", as shown" : "");
    if (!ImGui::BeginCombo("##size", now.c_str())) return;
    for (const int size : kSizes) {
        const bool chosen = !state.fit && size == session.width() && size == session.height();
        if (ImGui::Selectable(fmt::format("{0} x {0}", size).c_str(), chosen)) {
            state.fit = false;
            session.resize(size, size);
        }
    }
    if (ImGui::Selectable("as large as it is shown", state.fit)) state.fit = true;
    ImGui::EndCombo();
}

void drawCamera(ViewerState& state) {
    ViewSession& session = state.session;
    Camera camera = session.camera();
    ImGui::AlignTextToFramePadding();
    gui::text("Camera");
    gui::tooltip(
        "In the image: drag to orbit about its middle, right button to look around, middle button "
        "or shift to move sideways, wheel to come closer. W A S D Q E fly, with shift faster.");
    ImGui::SameLine(70.0f * state.scale);
    if (ImGui::Button("Reset##camera")) session.resetCamera();
    ImGui::SameLine();
    if (ImGui::Button("See scene and light")) {
        Bounds bounds = boundsOf(session.state().geometry->positions);
        for (const glm::dvec3& corner : session.light().corners()) bounds.add(corner);
        session.setCamera(backedOff(camera, bounds.centre(), 1.05 * bounds.radius(),
                                    static_cast<double>(session.width()) / session.height()));
    }
    gui::tooltip("Backs off until all of the scene and the light are in view");
    if (camera.kind != Camera::Kind::perspective) return;
    double degrees = glm::degrees(camera.fovYRad);
    const double lo = 5.0, hi = 120.0;
    ImGui::SetNextItemWidth(-1.0f);
    if (ImGui::SliderScalar("##fov", ImGuiDataType_Double, &degrees, &lo, &hi,
                            "%.1f° field of view", ImGuiSliderFlags_AlwaysClamp)) {
        camera = moved(camera, glm::dvec3(0.0));
        camera.fovYRad = glm::radians(degrees);
        session.setCamera(camera);
    }
}

/// Three coordinates to drag; whether they were.
bool dragPoint(const char* id, glm::dvec3& point, double speed, const char* format) {
    ImGui::SetNextItemWidth(-1.0f);
    return ImGui::DragScalarN(id, ImGuiDataType_Double, &point[0], 3, static_cast<float>(speed),
                              nullptr, nullptr, format);
}

void drawLight(ViewerState& state) {
    ViewSession& session = state.session;
    const double radius = session.scene().radiusM;
    const glm::dvec3 origin = session.scene().origin;
    AreaLight light = session.light();
    ImGui::AlignTextToFramePadding();
    gui::text("Light");
    ImGui::SameLine(70.0f * state.scale);
    if (ImGui::Button("Reset##light")) session.resetLight();
    ImGui::SameLine();
    ImGui::Checkbox("handles", &state.handles);
    gui::tooltip(
        "Arrows move the light, the yellow tip aims it, the ring turns it about its "
        "normal, the squares on its edges resize it");
    bool changed = false;
    glm::dvec3 position = light.centre + origin;
    if (dragPoint("##position", position, 0.005 * radius, "%.3f m")) {
        light.centre = position - origin;
        changed = true;
    }
    gui::tooltip("position of the light's centre, world x, y, z");
    glm::dvec3 normal = light.normal();
    if (dragPoint("##normal", normal, 0.005, "%.3f") && glm::length(normal) > 1e-6) {
        light = facing(light, glm::normalize(normal));
        changed = true;
    }
    gui::tooltip("direction that it shines in");
    double sides[2] = {2.0 * light.halfU, 2.0 * light.halfV};
    const double least = 0.0, most = 4.0 * radius;
    ImGui::SetNextItemWidth(-1.0f);
    if (ImGui::DragScalarN("##sides", ImGuiDataType_Double, sides, 2,
                           static_cast<float>(0.003 * radius), &least, &most, "%.4g m",
                           ImGuiSliderFlags_AlwaysClamp)) {
        // One side alone of no length is no light that a script can say.
        const bool point = sides[0] <= 0.0 && sides[1] <= 0.0;
        light.halfU = point ? 0.0 : std::max(0.5 * sides[0], 1e-6 * radius);
        light.halfV = point ? 0.0 : std::max(0.5 * sides[1], 1e-6 * radius);
        changed = true;
    }
    gui::tooltip("its sides; both 0: a point light");
    if (changed) session.setLight(light);
}

}  // namespace

void drawScenePanel(ViewerState& state) {
    if (!gui::section("Scene")) return;
    drawScenePicker(state);
    drawSize(state);
    ImGui::Separator();
    drawCamera(state);
    ImGui::Separator();
    drawLight(state);
}

void drawSavePanel(ViewerState& state) {
    if (!gui::section("Save")) return;
    ViewSession& session = state.session;
    ImGui::SetNextItemWidth(-1.0f);
    ImGui::InputText("##path", &state.savePath);
    gui::tooltip("where the scene script goes; its folder must exist");
    if (ImGui::Button("Save as scene script"))
        state.attempt([&] {
            std::string files;
            for (const auto& file : saveView(session, state.savePath))
                files += (files.empty() ? "" : " and ") + file.string();
            state.say("saved " + files);
        });
    gui::tooltip("Camera, light and time as they are now, for penumbra compare --scene FILE");
    ImGui::SameLine();
    if (ImGui::Button("Screenshot"))
        state.screenshot = std::filesystem::path(state.savePath).replace_extension(".png").string();
    gui::tooltip("F12: the window's content as PNG beside the script");
    ImGui::SetNextItemWidth(140.0f * state.scale);
    ImGui::InputText("##suite", &state.suite);
    gui::tooltip("a suite's name; one that does not exist is made");
    ImGui::SameLine();
    if (ImGui::Button("Add to suite"))
        state.attempt([&] {
            const SceneLibrary library = SceneLibrary::standard();
            const std::string id = std::filesystem::path(state.savePath).stem().string();
            const auto script = library.scripts / (id + ".toml");
            if (std::filesystem::exists(script))
                throw InputError("scene '" + id + "' exists already; choose another name");
            const auto files = saveView(session, script);
            try {
                addToSuite(library, state.suite, id);
            } catch (...) {
                for (const auto& file : files) std::filesystem::remove(file);
                throw;
            }
            state.say(fmt::format("added '{}' to suite '{}'", id, state.suite));
        });
    gui::tooltip(
        "Saves the view among the scenes under the script's name and adds it to this "
        "suite, for penumbra compare --suite NAME");
}

}  // namespace penumbra
