#pragma once

#include <tiny_gltf.h>

#include <optional>

#include "core/scene/asset.hpp"
#include "core/scene/gltf_accessor.hpp"

namespace penumbra::scene_detail {

/// Reads the primitives of a model's meshes. Only vertices that an index names are read, so that
/// many primitives may share one large accessor. The asset's materials must have been read.
class MeshReader {
  public:
    MeshReader(const tinygltf::Model& model, AccessorReader& reader, Asset& asset);

    /// Nothing where it has no triangles of an area: those are counted. With `skinned` its joints
    /// and weights are read too, which it then must have.
    std::optional<AssetPrimitive> read(int mesh, int primitive, bool skinned);

    /// What was left out, in words for the scene's notes.
    std::vector<std::string> notes() const;
    /// JSON pointer of the first primitive that has no triangles by its mode, and its mode's name.
    const std::string& firstSkipped() const { return firstSkipped_; }

  private:
    std::vector<std::uint32_t> corners(const tinygltf::Primitive& in, std::size_t vertexCount,
                                       const std::string& pointer);
    std::vector<std::uint32_t> takeVertices(std::vector<std::uint32_t>& indices,
                                            std::size_t vertexCount, const std::string& pointer);
    void dropDegenerate(AssetPrimitive& out);

    const tinygltf::Model& model_;
    AccessorReader& reader_;
    Asset& asset_;
    Integers geometryIntegers_;            ///< of positions and normals
    std::vector<std::uint32_t> newIndex_;  ///< per vertex of an accessor, all unused between reads
    std::size_t dropped_ = 0, skipped_ = 0, triangles_ = 0;
    std::string firstSkipped_;
};

}  // namespace penumbra::scene_detail
