#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace penumbra::scene_detail {

/// Reads accessors of a model whose buffer views have been checked (readGltf). `user` is the JSON
/// pointer of what refers to the accessor; errors name it. Everything is checked before it is read.
class AccessorReader {
  public:
    AccessorReader(const tinygltf::Model& model, std::filesystem::path file)
        : model_(model), file_(std::move(file)) {}

    /// Elements of 1 to 4 components, missing ones 0. Integers are allowed when normalised and
    /// `allowNormalised`; they are mapped to [0, 1] or [-1, 1]. Non-finite values are refused with
    /// their index unless `allowNonFinite`.
    std::vector<glm::vec4> vectors(int accessor, int components, bool allowNormalised,
                                   const std::string& user, bool allowNonFinite = false) const;

    /// Unsigned 8-, 16- or 32-bit scalars, all less than `vertexCount`.
    std::vector<std::uint32_t> indices(int accessor, std::size_t vertexCount,
                                       const std::string& user) const;

    /// The encoded bytes of a buffer view.
    std::vector<unsigned char> bufferView(int view, const std::string& user) const;

  private:
    struct View {
        const unsigned char* data;
        std::size_t count, strideBytes;
        int componentType, components;
        bool normalised;
    };
    View view(int accessor, const std::string& user) const;
    [[noreturn]] void fail(const std::string& pointer, const std::string& what) const;

    const tinygltf::Model& model_;
    std::filesystem::path file_;
};

}  // namespace penumbra::scene_detail
