#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/area_light.hpp"
#include "core/scene/asset.hpp"
#include "core/scene/geometry.hpp"
#include "core/scene/light_rectangle.hpp"
#include "core/scene/script.hpp"

namespace penumbra::scene_detail {

/// The light and the camera of a scene: which of those that script and asset offer, else placed
/// from the bounds; and where they are at any time. What was chosen because the input does not say
/// is told in notes(). `world` is always worldMatrices() of the asset's nodes.
class LightAndCamera {
  public:
    /// Chooses the camera. All references outlive this. Throws InputError for a camera that
    /// `options` names and the asset has not.
    LightAndCamera(Asset& asset, const std::optional<Script>& script, const LoadOptions& options);

    /// Unless the script has a light: takes the emissive rectangle of the greatest flux out of the
    /// asset's placements. Before the asset is measured.
    void takeRectangle(const std::vector<glm::dmat4>& world);
    /// Chooses what is still missing, by the bounds of the asset without its light.
    void complete(const Bounds& bounds);
    /// Whether neither script nor asset have a light or a camera; after complete().
    bool allPlaced() const { return fixedLight_ && fixedCamera_ && !script_; }
    const std::vector<std::string>& notes() const { return notes_; }

    /// Throws InputError where there is none at that time.
    AreaLight lightAt(double timeS, const std::vector<glm::dmat4>& world) const;
    Camera cameraAt(double timeS, const std::vector<glm::dmat4>& world) const;
    /// Whether they do, in `frames` frames; `moves`: which nodes' matrices do.
    bool lightMoves(const std::vector<bool>& moves, std::size_t frames) const;
    bool cameraMoves(const std::vector<bool>& moves, std::size_t frames) const;

  private:
    [[noreturn]] void fail(const std::string& what) const;
    [[noreturn]] void failPose(const std::string& where, const char* what, double timeS) const;
    bool scriptMoves(std::initializer_list<TrackTarget> targets) const;
    void choosePunctual(const Bounds& bounds);
    void placeLight(const Bounds& bounds);
    void placeCamera(const Bounds& bounds);

    Asset& asset_;
    const std::optional<Script>& script_;
    std::vector<std::string> notes_;
    std::optional<LocalRectangle> rectangle_;
    int rectangleNode_ = -1;
    std::optional<AssetLight> punctual_;
    Bounds bounds_;  ///< what a light without extent is placed by
    std::optional<AssetCamera> assetCamera_;
    std::optional<AreaLight> fixedLight_;
    std::optional<Camera> fixedCamera_;
};

}  // namespace penumbra::scene_detail
