#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/scene/area_light.hpp"
#include "core/scene/camera.hpp"
#include "core/scene/geometry.hpp"
#include "core/scene/load_options.hpp"
#include "core/scene/material.hpp"

namespace penumbra {

/// What a scene is at the time of one frame.
struct SceneFrame {
    double timeS = 0.0;
    std::shared_ptr<const Geometry> geometry;  ///< shared between frames in which nothing moves
    AreaLight light;
    Camera camera;
};

/// Where a scene throws a straight shadow edge whose penumbra is measured: a segment on the
/// receiver, normal to the edge.
struct ShadowEdge {
    glm::dvec3 from{0.0}, to{0.0};  ///< in the umbra and in full light, apart from each other
    double halfWidthM = 0.0;  ///< how far it looks alike along the edge, to both sides; above 0
};

/// A scene: an asset, a light, a camera and tracks, evaluated per frame. Immutable once loaded.
class Scene {
  public:
    virtual ~Scene() = default;

    std::string id;           ///< the script's or the asset's file stem
    std::string shows;        ///< what the scene is there to show
    std::string figure;       ///< the paper figure it follows, may be empty
    std::filesystem::path source;  ///< the script or asset it was read from
    std::filesystem::path asset;   ///< the .gltf or .glb
    std::vector<Material> materials;
    std::vector<TextureImage> images;
    glm::dvec3 origin{0.0};  ///< world position of (0,0,0) of all that the frames hold: the centre of
                             ///< the asset's bounds at frame 0
    double radiusM = 1.0;    ///< half the diagonal of the geometry's bounds at frame 0
    std::vector<std::string> chosen;  ///< what was placed because the input did not say, in words
    std::vector<ShadowEdge> edges;    ///< relative to `origin`; in frames that do not show one it
                                      ///< measures nothing
    bool movingLight = false, movingCasters = false, movingCamera = false;  ///< tracks present

    virtual int frameCount() const = 0;
    /// The scene at frame `index` in [0, frameCount()). Thread-safe.
    virtual SceneFrame frame(int index) const = 0;
};

/// Where scene ids are looked up and assets were generated.
struct SceneLibrary {
    std::filesystem::path scripts;  ///< scenes/*.toml
    std::filesystem::path assets;   ///< generated .glb files, `asset = "generated:NAME.glb"`
    /// Ids of all scripts, sorted.
    std::vector<std::string> ids() const;
    /// The library of this build: the source tree's scenes/ and the build tree's assets, or
    /// $PENUMBRA_SCENES and $PENUMBRA_ASSETS where they are set.
    static SceneLibrary standard();
};

/// Thrown for a scene whose asset comes from a package that is not installed: the scene is skipped
/// with this message and the run goes on.
class AssetAbsent : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Loads a scene by id ("fence"), script path (.toml) or asset path (.glb, .gltf).
/// Throws InputError (one line: file, place, valid choices) or AssetAbsent.
std::shared_ptr<const Scene> loadScene(const std::string& idOrPath, const SceneLibrary& library,
                                       const LoadOptions& options = {});

}  // namespace penumbra
