#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/scene/memory_budget.hpp"

namespace penumbra::scene_detail {

/// Which stored types a reader of vectors takes besides FLOAT.
enum class Integers {
    none,
    normalised,  ///< 8 and 16 bits, mapped to [0, 1] or [-1, 1]
    any          ///< the same, or, not normalised, their value (KHR_mesh_quantization)
};

/// Reads accessors of a model whose buffer views have been checked (readGltf): any stride, sparse
/// ones, and ones without a buffer view, which are zeros. `user` is the JSON pointer of what refers
/// to the accessor; errors name it. Everything is checked before it is read, and what is returned
/// is charged to `budget` before it is allocated.
class AccessorReader {
  public:
    AccessorReader(const tinygltf::Model& model, std::filesystem::path file, MemoryBudget& budget)
        : model_(model), file_(std::move(file)), budget_(budget) {}

    /// Number of elements, after the accessor has been checked.
    std::size_t count(int accessor, const std::string& user);
    /// 1 to 4, or those of a matrix.
    int components(int accessor, const std::string& user);
    /// Whether it has data of its own, in a buffer view or sparse.
    bool hasData(int accessor, const std::string& user);

    struct Wanted {
        int components;  ///< 1 to 4
        Integers integers = Integers::none;
        bool nonFiniteToo = false;  ///< else they are refused with their index
    };
    /// All elements, or those of `elements` in that order, which must be in range. Missing
    /// components are 0.
    std::vector<glm::vec4> vectors(int accessor, const Wanted& wanted, const std::string& user);
    std::vector<glm::vec4> vectors(int accessor, const Wanted& wanted, const std::string& user,
                                   std::span<const std::uint32_t> elements);

    /// All elements of MAT4 of FLOAT, finite.
    std::vector<glm::dmat4> matrices(int accessor, const std::string& user);

    /// Unsigned 8-, 16- or 32-bit scalars, all less than `vertexCount`.
    std::vector<std::uint32_t> indices(int accessor, std::size_t vertexCount,
                                       const std::string& user);

    /// VEC4 of UNSIGNED_BYTE or UNSIGNED_SHORT of the vertices `elements`.
    std::vector<glm::uvec4> joints(int accessor, const std::string& user,
                                   std::span<const std::uint32_t> elements);

    /// The encoded bytes of a buffer view.
    std::span<const unsigned char> bufferView(int view, const std::string& user) const;

  private:
    /// A checked accessor.
    struct Source {
        const unsigned char* data = nullptr;  ///< null: zeros
        std::size_t count = 0, strideBytes = 0, elementBytes = 0;
        int componentType = 0, componentBytes = 0, components = 0;
        bool normalised = false;
        std::vector<std::uint32_t> replaced;  ///< elements that `values` overrides, increasing
        const unsigned char* values = nullptr;

        /// Null: zeros.
        const unsigned char* element(std::size_t index) const;
    };
    const Source& source(int accessor, const std::string& user);
    Source opened(int accessor) const;
    void openSparse(const tinygltf::Accessor& accessor, const std::string& pointer, Source& out);
    const unsigned char* inView(int view, std::size_t byteOffset, std::size_t count,
                                std::size_t elementBytes, std::size_t strideBytes,
                                const std::string& pointer) const;
    const tinygltf::BufferView& viewAt(int view, const std::string& pointer) const;
    void requireInRange(const Source& in, std::span<const std::uint32_t> elements, int accessor,
                        const std::string& user) const;
    [[noreturn]] void fail(const std::string& pointer, const std::string& what) const;

    const tinygltf::Model& model_;
    std::filesystem::path file_;
    MemoryBudget& budget_;
    std::map<int, Source> sources_;
};

}  // namespace penumbra::scene_detail
