#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/animation.hpp"
#include "core/scene/scene.hpp"

namespace penumbra::scene_detail {

/// `[camera]` of a scene script, world space.
struct ScriptCamera {
    glm::dvec3 position{0.0}, target{0.0};
    std::optional<glm::dvec3> up;
    double fovYDegrees = 0.0;
    std::string where;  ///< "line:column" of the table
};

/// `[light]` of a scene script, world space.
struct ScriptLight {
    glm::dvec3 position{0.0}, target{0.0};
    std::optional<glm::dvec3> up;
    glm::dvec2 size{0.0};  ///< metres; both 0 for a point light
    std::string where;
};

enum class TrackTarget {
    lightPosition,
    lightTarget,
    lightSize,
    cameraPosition,
    cameraTarget,
    cameraFovY,
    nodeTranslation,
    nodeRotation,
    nodeScale
};

struct ScriptTrack {
    TrackTarget target = TrackTarget::lightPosition;
    std::string node;  ///< of the node targets
    Curve curve;
    std::string where;
};

/// A scene script as written; what it says of the asset is not checked yet.
struct Script {
    std::filesystem::path file;
    std::string shows, figure;
    /// "generated:NAME.glb", "package:/PATH", "procedural:..." (ProceduralAsset) or a path next to
    /// the script.
    std::string asset;
    std::string package;  ///< Debian package that the asset comes from, may be empty
    std::string assetWhere;
    bool ground = false;
    std::optional<ScriptCamera> camera;
    std::optional<ScriptLight> light;
    std::vector<double> timesS = {0.0};
    std::vector<ScriptTrack> tracks;
    std::vector<ShadowEdge> edges;  ///< world space
};

/// Reads a scene script. Throws InputError
/// "file:line:column: what; valid choices".
Script readScript(const std::filesystem::path& file);

/// Throws InputError for `script` at `where` ("line:column").
[[noreturn]] void failScript(const Script& script, const std::string& where,
                             const std::string& what);

}  // namespace penumbra::scene_detail
