#pragma once

#include <tiny_gltf.h>

#include <string>
#include <vector>

#include "core/scene/asset.hpp"
#include "core/scene/gltf_accessor.hpp"

namespace penumbra::scene_detail {

/// The matrices of EXT_mesh_gpu_instancing, below its node: TRANSLATION, ROTATION and SCALE of
/// `attributes`, of which there must be one, all equally long. Others change no shadow. Throws
/// InputError naming what is below `pointer`.
std::vector<glm::dmat4> readInstances(const tinygltf::Value& attributes, AccessorReader& reader,
                                      Asset& asset, const std::string& pointer);

}  // namespace penumbra::scene_detail
