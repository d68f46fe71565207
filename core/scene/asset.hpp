#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/scene/animation.hpp"
#include "core/scene/camera.hpp"
#include "core/scene/material.hpp"

namespace penumbra::scene_detail {

/// A node of the chosen glTF scene. Parents come before their children.
struct AssetNode {
    std::string name;
    int parent = -1;
    bool hasMatrix = false;  ///< then `matrix` holds and nothing may animate the node
    glm::dmat4 matrix{1.0};
    Transform transform;
};

/// Triangles in object space. Zero-area triangles and unused vertices are gone.
struct AssetPrimitive {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec2> uvs;
    std::vector<std::uint32_t> indices;
    int material = 0;
};

/// One primitive as one node places it: a part of the frame's geometry, or the light.
struct Placement {
    std::string name;
    int node = 0;
    int primitive = 0;
};

/// A camera at rest: its position and axes follow from the node.
struct AssetCamera {
    int node = -1;
    Camera lens;
};

/// A checked glTF file, in plain data: every index in it is in range.
struct Asset {
    std::filesystem::path file;
    std::vector<AssetNode> nodes;
    std::vector<AssetPrimitive> primitives;
    std::vector<Placement> placements;
    std::vector<AssetCamera> cameras;  ///< in the order of the node hierarchy
    std::vector<NodeTrack> tracks;     ///< all animations of the file at once
    std::vector<Material> materials;
    std::vector<double> emissions;  ///< per material: greatest emissive component times strength
    std::vector<TextureImage> images;
    std::vector<std::string> notes;  ///< what was read differently from what the file says
};

/// Reads a .gltf or .glb. Throws InputError naming the file and the JSON pointer.
Asset loadAsset(const std::filesystem::path& file);

}  // namespace penumbra::scene_detail
