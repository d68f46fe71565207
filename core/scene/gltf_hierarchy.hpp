#pragma once

#include <tiny_gltf.h>

#include <string>
#include <vector>

#include "core/scene/asset.hpp"

namespace penumbra::scene_detail {

/// The nodes of one scene of a glTF file.
struct NodeHierarchy {
    std::vector<int> fileNodes;  ///< per asset node: the file's
    std::vector<int> newIndex;   ///< per node of the file: the asset's, -1 outside the scene
};

/// Adds the nodes of the scene that `wanted` names (LoadOptions::assetScene) to `asset`, depth
/// first, so that "the first camera" is the first that a reader of the file meets. In all scenes
/// every node has at most one parent and none is its own ancestor. Throws InputError.
NodeHierarchy readHierarchy(const tinygltf::Model& model, const std::string& wanted, Asset& asset);

}  // namespace penumbra::scene_detail
