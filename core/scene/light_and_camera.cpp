#include "core/scene/light_and_camera.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/scene/choice.hpp"
#include "core/scene/input_text.hpp"
#include "core/scene/placement.hpp"
#include "core/scene/punctual_light.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

constexpr std::size_t kListedNames = 12;

std::string words(const glm::dvec3& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x, p.y, p.z);
}

}  // namespace

LightAndCamera::LightAndCamera(Asset& asset, const std::optional<Script>& script,
                               const LoadOptions& options)
    : asset_(asset), script_(script) {
    const bool scripted = script_ && script_->camera;
    if (options.camera.empty()) {
        if (!scripted && !asset_.cameras.empty()) assetCamera_ = asset_.cameras.front();
        return;
    }
    std::vector<std::string> names;
    for (const AssetCamera& camera : asset_.cameras) names.push_back(camera.name);
    const auto chosen = chosenByIndexOrName(options.camera, names);
    if (!chosen) {
        fail(fmt::format(
            "--camera {}: {}", oneLine(options.camera, 60),
            names.empty() ? "the scene has no cameras" : "the cameras are " + indexedNames(names)));
    }
    assetCamera_ = asset_.cameras[*chosen];
}

void LightAndCamera::fail(const std::string& what) const {
    failInput(asset_.file, asset_.pointer, what);
}

void LightAndCamera::takeRectangle(const std::vector<glm::dmat4>& world) {
    if (script_ && script_->light) return;
    struct Candidate {
        std::size_t placement;
        LocalRectangle rectangle;
        double flux;
    };
    std::vector<Candidate> candidates;
    bool otherEmission = false;
    for (std::size_t i = 0; i < asset_.placements.size(); ++i) {
        const Placement& placement = asset_.placements[i];
        const AssetPrimitive& primitive = asset_.primitives[placement.primitive];
        const double emission = asset_.emissions[primitive.material];
        if (!(emission > 0.0)) continue;
        const glm::dmat4& matrix = world[placement.node];
        const bool plain = !primitive.deforms() && placement.instances < 0;
        if (const auto rectangle = plain ? rectangleOf(primitive, matrix) : std::nullopt) {
            candidates.push_back({i, *rectangle, rectangle->placedBy(matrix).area() * emission});
        } else {
            otherEmission = true;
        }
    }
    if (otherEmission) {
        notes_.push_back("emissive surfaces that are not one rectangle do not emit");
    }
    if (candidates.empty()) return;
    const auto light =
        std::max_element(candidates.begin(), candidates.end(),
                         [](const auto& a, const auto& b) { return a.flux < b.flux; });
    const Placement chosen = asset_.placements[light->placement];
    if (candidates.size() > 1) {
        std::vector<std::string> others;
        for (const Candidate& c : candidates) {
            if (c.placement != light->placement) {
                others.push_back("'" + asset_.placements[c.placement].name + "'");
            }
        }
        notes_.push_back(oneLine(fmt::format(
            "light: '{}', the emissive rectangle of the greatest flux; {} remain ordinary "
            "surfaces",
            chosen.name, listed(others, kListedNames))));
    }
    rectangle_ = light->rectangle;
    rectangleNode_ = chosen.node;
    asset_.placements.erase(asset_.placements.begin() +
                            static_cast<std::ptrdiff_t>(light->placement));
}

void LightAndCamera::complete(const Bounds& bounds) {
    choosePunctual(bounds);
    placeLight(bounds);
    placeCamera(bounds);
}

void LightAndCamera::choosePunctual(const Bounds& bounds) {
    if (rectangle_ || (script_ && script_->light)) return;
    const auto chosen = brightest(asset_.lights);
    if (!chosen) return;
    punctual_ = asset_.lights[*chosen];
    bounds_ = bounds;
    notes_.push_back(describe(*punctual_, asset_.lights.size()));
}

void LightAndCamera::placeLight(const Bounds& bounds) {
    if (rectangle_ || punctual_ || (script_ && script_->light)) return;
    fixedLight_ = lightForBounds(bounds);
    notes_.push_back(
        fmt::format("light: none given, placed a square of {0:.4g} x {0:.4g} m at {1} facing "
                    "the centre {2} of the asset",
                    2.0 * fixedLight_->halfU, words(fixedLight_->centre), words(bounds.centre())));
}

void LightAndCamera::placeCamera(const Bounds& bounds) {
    if (assetCamera_ || (script_ && script_->camera)) return;
    fixedCamera_ = cameraForBounds(bounds);
    notes_.push_back(
        fmt::format("camera: none given, placed at {} looking at {}, {:.4g} degrees high",
                    words(fixedCamera_->position), words(bounds.centre()),
                    glm::degrees(fixedCamera_->fovYRad)));
}

AreaLight LightAndCamera::lightAt(double timeS, const std::vector<glm::dmat4>& world) const {
    if (fixedLight_) return *fixedLight_;
    if (rectangle_) {
        const AreaLight light = rectangle_->placedBy(world[rectangleNode_]);
        const double reachM = glm::length(light.centre) + light.halfU + light.halfV;
        if (!(light.area() > 0.0 && reachM < kMaxExtentM)) {
            fail(fmt::format("its light is no rectangle at {} s", timeS));
        }
        return light;
    }
    if (punctual_) {
        const auto light = placedPunctual(*punctual_, world[punctual_->node], bounds_);
        if (!light) fail(fmt::format("its light '{}' is nowhere at {} s", punctual_->name, timeS));
        return *light;
    }
    ScriptLight light = *script_->light;
    for (const ScriptTrack& track : script_->tracks) {
        const glm::dvec4 value = track.curve.at(timeS);
        if (track.target == TrackTarget::lightPosition) light.position = glm::dvec3(value);
        if (track.target == TrackTarget::lightTarget) light.target = glm::dvec3(value);
        if (track.target == TrackTarget::lightSize) light.size = glm::dvec2(value);
    }
    const auto placed = lightFacing(light.position, light.target, light.up, light.size);
    if (!placed) failPose(light.where, "light", timeS);
    return *placed;
}

Camera LightAndCamera::cameraAt(double timeS, const std::vector<glm::dmat4>& world) const {
    if (fixedCamera_) return *fixedCamera_;
    if (assetCamera_) {
        const Camera placed = cameraOfNode(assetCamera_->lens, world[assetCamera_->node]);
        const double check = glm::length(placed.position) + glm::length(placed.right) +
                             glm::length(placed.up) + glm::length(placed.back);
        if (!(check < kMaxExtentM)) {
            fail(fmt::format("its camera has no direction at {} s", timeS));
        }
        return placed;
    }
    ScriptCamera camera = *script_->camera;
    for (const ScriptTrack& track : script_->tracks) {
        const glm::dvec4 value = track.curve.at(timeS);
        if (track.target == TrackTarget::cameraPosition) camera.position = glm::dvec3(value);
        if (track.target == TrackTarget::cameraTarget) camera.target = glm::dvec3(value);
        if (track.target == TrackTarget::cameraFovY) camera.fovYDegrees = value.x;
    }
    const auto placed =
        cameraFacing(camera.position, camera.target, camera.up, glm::radians(camera.fovYDegrees));
    if (!placed) failPose(camera.where, "camera", timeS);
    return *placed;
}

void LightAndCamera::failPose(const std::string& where, const char* what, double timeS) const {
    failScript(*script_, where,
               fmt::format("at {} s the {} has no direction: target must differ from position "
                           "and up must not lie along the line between them",
                           timeS, what));
}

bool LightAndCamera::scriptMoves(std::initializer_list<TrackTarget> targets) const {
    return script_ &&
           std::any_of(
               script_->tracks.begin(), script_->tracks.end(), [&](const ScriptTrack& track) {
                   return std::find(targets.begin(), targets.end(), track.target) != targets.end();
               });
}

bool LightAndCamera::lightMoves(const std::vector<bool>& moves, std::size_t frames) const {
    if (frames < 2) return false;
    return (rectangle_ && moves[rectangleNode_]) || (punctual_ && moves[punctual_->node]) ||
           scriptMoves(
               {TrackTarget::lightPosition, TrackTarget::lightTarget, TrackTarget::lightSize});
}

bool LightAndCamera::cameraMoves(const std::vector<bool>& moves, std::size_t frames) const {
    if (frames < 2) return false;
    if (assetCamera_) return moves[assetCamera_->node];
    return scriptMoves(
        {TrackTarget::cameraPosition, TrackTarget::cameraTarget, TrackTarget::cameraFovY});
}

}  // namespace penumbra::scene_detail
