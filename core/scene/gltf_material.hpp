#pragma once

#include <tiny_gltf.h>

#include <map>
#include <tuple>

#include "core/scene/asset.hpp"
#include "core/scene/gltf_accessor.hpp"

namespace penumbra::scene_detail {

/// Where a material's base colour texture takes its coordinates from.
struct TextureMapping {
    int set = 0;             ///< TEXCOORD_<set>
    glm::dmat3 matrix{1.0};  ///< of (u, v, 1), KHR_texture_transform
};
TextureMapping baseColorMapping(const tinygltf::Material& material);

/// Adds a glTF file's materials and their base colour textures to `asset`, the default material of
/// primitives without one last. What a shadow does not depend on is left out; `doubleSided` is,
/// because every surface casts and receives on both sides (geometry.hpp).
class MaterialLoader {
  public:
    MaterialLoader(const tinygltf::Model& model, const AccessorReader& reader, Asset& asset)
        : model_(model), reader_(reader), asset_(asset) {}

    void load();

  private:
    void add(std::size_t index);
    int textureFor(const tinygltf::TextureInfo& info, const std::string& pointer);
    TextureImage decoded(int image);

    const tinygltf::Model& model_;
    const AccessorReader& reader_;
    Asset& asset_;
    std::map<std::tuple<int, Wrap, Wrap, bool>, int> loaded_;  ///< image and sampling -> index
};

}  // namespace penumbra::scene_detail
