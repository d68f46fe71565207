#pragma once

#include <tiny_gltf.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/asset.hpp"
#include "core/scene/gltf_accessor.hpp"
#include "core/scene/gltf_material.hpp"

namespace penumbra::scene_detail {

/// Reads the attributes of one glTF primitive for the vertices that were selected. Every attribute
/// must have as many elements as POSITION. Errors are InputError naming the attribute.
class VertexReader {
  public:
    /// `integers`: which positions and normals are taken besides floats.
    VertexReader(const tinygltf::Primitive& primitive, AccessorReader& reader,
                 const std::filesystem::path& file, std::string pointer, Integers integers);

    /// Number of elements of POSITION.
    std::size_t count() const { return count_; }
    /// Must precede all that follows.
    void select(std::vector<std::uint32_t> vertices) { vertices_ = std::move(vertices); }

    std::vector<glm::vec3> positions();
    std::vector<glm::vec3> normals();  ///< empty where there are none; may be no unit vectors
    std::vector<glm::vec2> uvs(const TextureMapping& mapping);
    void readTargets(AssetPrimitive& out);
    /// JOINTS_n and WEIGHTS_n. Weights are made to sum to 1; a vertex without any follows its
    /// first joint.
    void readInfluences(AssetPrimitive& out);
    /// Refuses COLOR_0 with an alpha other than 1, which is not part of a mask here.
    void requireOpaqueColours();

  private:
    bool has(const std::string& name) const { return primitive_.attributes.contains(name); }
    int accessor(const std::string& name);
    void requireCount(int accessor, const std::string& user);
    template <class Vector>
    std::vector<Vector> read(const std::string& name, const AccessorReader::Wanted& wanted);
    [[noreturn]] void fail(const std::string& pointer, const std::string& what) const;

    const tinygltf::Primitive& primitive_;
    AccessorReader& reader_;
    const std::filesystem::path& file_;
    std::string pointer_;
    Integers integers_;
    std::size_t count_ = 0;
    std::vector<std::uint32_t> vertices_;
};

}  // namespace penumbra::scene_detail
