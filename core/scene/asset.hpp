#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/scene/animation.hpp"
#include "core/scene/camera.hpp"
#include "core/scene/load_options.hpp"
#include "core/scene/material.hpp"
#include "core/scene/memory_budget.hpp"

namespace penumbra::scene_detail {

/// A node of the chosen glTF scene. Parents come before their children.
struct AssetNode {
    std::string name;
    int parent = -1;
    bool hasMatrix = false;  ///< then `matrix` holds and nothing may animate the node
    glm::dmat4 matrix{1.0};
    Transform transform;
    std::vector<double> weights;  ///< of its mesh's morph targets at rest
};

/// What is added to every vertex, times the target's weight; empty where the target leaves it.
struct MorphTarget {
    std::vector<glm::vec3> positions, normals;
};

/// Triangles in object space. Unused vertices are gone; so are zero-area triangles, unless the
/// primitive deforms and they may get an area: then only those that name a vertex twice.
struct AssetPrimitive {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec2> uvs;
    std::vector<std::uint32_t> indices;
    int material = 0;
    bool flat = false;  ///< each triangle has vertices and a geometric normal of its own
    std::vector<MorphTarget> targets;
    int influences = 0;                 ///< joints per vertex; 0: not skinned
    std::vector<std::uint16_t> joints;  ///< `influences` per vertex, indices into AssetSkin::joints
    std::vector<float> jointWeights;    ///< as many, each vertex's summing to 1

    bool deforms() const { return influences > 0 || !targets.empty(); }
};

struct AssetSkin {
    std::vector<int> joints;  ///< nodes
    std::vector<glm::dmat4> inverseBind;
};

/// One primitive as one node places it: a part of the frame's geometry, or the light.
struct Placement {
    std::string name;
    int node = 0;
    int primitive = 0;
    int skin = -1;       ///< index into Asset::skins; the node's own matrix then has no effect
    int instances = -1;  ///< index into Asset::instances: one copy each, below the node
};

/// A camera at rest: its position and axes follow from the node.
struct AssetCamera {
    int node = -1;
    Camera lens;
    std::string name;  ///< of the node, else of the lens
};

/// A light without extent (KHR_lights_punctual). It shines along -Z of its node.
struct AssetLight {
    enum class Kind { point, spot, directional };
    int node = -1;
    Kind kind = Kind::point;
    double intensity = 0.0;  ///< times the greatest component of its colour; above 0
    std::string name;
};

/// A checked glTF file, in plain data: every index in it is in range.
struct Asset {
    std::filesystem::path file;
    std::vector<AssetNode> nodes;
    std::vector<AssetPrimitive> primitives;
    std::vector<Placement> placements;
    std::vector<AssetSkin> skins;
    std::vector<std::vector<glm::dmat4>> instances;  ///< matrices below the node that has them
    std::vector<AssetCamera> cameras;                ///< in the order of the node hierarchy
    std::vector<AssetLight> lights;                  ///< likewise
    std::vector<NodeTrack> tracks;                   ///< all animations of the file at once
    std::vector<Material> materials;
    std::vector<double> emissions;  ///< per material: greatest emissive component times strength
    std::vector<TextureImage> images;
    std::vector<std::string> notes;  ///< what was read differently from what the file says
    std::string pointer;             ///< JSON pointer of the chosen scene
    MemoryBudget memory;             ///< what is left of LoadOptions::maxMemoryBytes
};

/// Reads a .gltf or .glb, or makes what ProceduralAsset does. Throws InputError naming the file and
/// the JSON pointer.
Asset loadAsset(const std::filesystem::path& file, const LoadOptions& options);

}  // namespace penumbra::scene_detail
