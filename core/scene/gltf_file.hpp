#pragma once

#include <tiny_gltf.h>

#include <filesystem>

#include "core/scene/memory_budget.hpp"

namespace penumbra::scene_detail {

/// Parses a .gltf or .glb into tinygltf's model. tinygltf forgives what would then be drawn wrong
/// (an index of the wrong type reads as absent), trusts sizes and reads any file; so it is given
/// the JSON only, checked by parseGltfJson() and without buffers, images and skins, which are read
/// here:
/// - buffers are read from the file itself, data URIs, and the asset's own folder and below;
/// - images keep their URI or buffer view and are read when something needs them (gltf_material);
/// - skins may lack inverse bind matrices, which tinygltf takes for an error.
/// Every buffer holds the bytes it promises and every buffer view lies inside its buffer. Whatever
/// is wrong is an InputError of one line.
tinygltf::Model readGltf(const std::filesystem::path& file, MemoryBudget& budget);

}  // namespace penumbra::scene_detail
