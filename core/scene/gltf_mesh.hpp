#pragma once

#include <tiny_gltf.h>

#include <optional>

#include "core/scene/asset.hpp"
#include "core/scene/gltf_accessor.hpp"

namespace penumbra::scene_detail {

/// Reads primitive `primitive` of mesh `mesh`. Nothing when all its triangles have zero area.
/// Adds the number of zero-area triangles to `droppedTriangles`. The asset's materials are read.
std::optional<AssetPrimitive> readPrimitive(const tinygltf::Model& model,
                                            const AccessorReader& reader, const Asset& asset,
                                            int mesh, int primitive, std::size_t& droppedTriangles);

}  // namespace penumbra::scene_detail
