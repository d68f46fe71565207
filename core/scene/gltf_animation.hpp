#pragma once

#include <tiny_gltf.h>

#include <vector>

#include "core/scene/asset.hpp"
#include "core/scene/gltf_accessor.hpp"

namespace penumbra::scene_detail {

/// Adds the tracks of all animations to `asset`, whose nodes have been read. `newIndex` leads from
/// the file's nodes to the asset's, -1 for those of other scenes. Morph weights become one track
/// for each target of the node's mesh.
void readAnimations(const tinygltf::Model& model, AccessorReader& reader,
                    const std::vector<int>& newIndex, Asset& asset);

/// Throws InputError unless `quaternion` can be normalised.
void requireRotation(const glm::dvec4& quaternion, const std::filesystem::path& file,
                     const std::string& pointer);

}  // namespace penumbra::scene_detail
