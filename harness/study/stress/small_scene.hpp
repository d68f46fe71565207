#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/scene/script.hpp"
#include "harness/study/stress/bodies.hpp"

namespace penumbra::stress {

/// How a small scene is put into the world: first scaled, then turned, mirrored and moved.
struct Placement {
    double scale = 1.0;
    glm::dvec3 rotateDeg{0.0};  ///< about X, then Y, then Z
    bool mirror = false;        ///< x becomes -x; the image is mirrored, too
    glm::dvec3 offset{0.0};     ///< metres, after all else
    bool operator==(const Placement&) const = default;
};

/// What is done to the triangles of a small scene without changing where there is a surface.
struct Mesh {
    bool shuffled = false;    ///< triangles within each body, and bodies, in another order
    bool duplicated = false;  ///< every triangle a second time, wound the other way round
    bool split = false;  ///< every other triangle in four: its neighbours meet its edges' middles
    bool operator==(const Mesh&) const = default;
};

/// One value that changes linearly over the frames, as scene scripts name it ("light.position",
/// "light.size", "camera.position", "node:body0.translation"), from where the scene has it.
struct Motion {
    std::string target;
    std::vector<double> from, to;
    int frames = 2;
    bool operator==(const Motion&) const = default;
};

/// A scene of few bodies, a light and a camera, as scene scripts have them; Y is up.
struct SmallScene {
    std::vector<Body> bodies;
    glm::dvec3 lightPosition{0, 2, 0}, lightTarget{0, 0, 0};
    std::optional<glm::dvec3> lightUp;
    glm::dvec2 lightSize{0.5, 0.5};
    glm::dvec3 cameraPosition{1, 2, 2}, cameraTarget{0, 0, 0};
    double fovYDeg = 40.0;
    std::optional<Motion> motion;
    Placement placement;
    Mesh mesh;
    bool operator==(const SmallScene&) const = default;

    /// As loadScene() would have it. Body i is the node "body<i>". Throws InputError for what no
    /// scene may be: no extent, a light or camera without direction, coordinates beyond bounds.
    std::shared_ptr<const Scene> build() const;

    /// Writes the scene's first frame as `stem`.glb and a scene script `stem`.toml that loads it;
    /// `comment` lines stand above the script. Throws InputError or std::runtime_error.
    void write(const std::filesystem::path& stem, const std::vector<std::string>& comment) const;
};

}  // namespace penumbra::stress
