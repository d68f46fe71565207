#pragma once

#include <tbb/parallel_for.h>

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/gl/handles.hpp"
#include "core/scene/edge_adjacency.hpp"

namespace penumbra {

/// The edges of penumbra quads on the GPU, as shaders/penumbra_quads.glsl reads them, room for a
/// list of those that are silhouettes, and the triangles of as many pairs of quads.
class QuadOutline {
  public:
    QuadOutline() = default;
    /// For the current context, without edges.
    static QuadOutline create() {
        QuadOutline outline;
        GLuint id = 0;
        glCreateVertexArrays(1, &id);
        outline.quads_ = gl::VertexArray(id);
        return outline;
    }

    void upload(const std::vector<OutlineEdge>& outline) {
        edges_ = filled<GpuEdge>(outline.size(), [&](std::size_t i) {
            const OutlineEdge& e = outline[i];
            return GpuEdge{glm::vec4(e.a, static_cast<float>(e.forward[0] + 2 * e.forward[1])),
                           glm::vec4(e.b, std::bit_cast<float>(e.piece)),
                           glm::vec4(e.stretchA, 0.0f),
                           glm::vec4(e.stretchB, 0.0f),
                           {e.planes[0], e.planes[1]}};
        });
        if (count_ == static_cast<int>(outline.size())) return;
        count_ = static_cast<int>(outline.size());
        silhouettes_ = gl::Buffer::create(outline.size() * sizeof(GpuSilhouette), nullptr);
        using Quad = std::array<std::uint32_t, kQuadIndices.size()>;
        indices_ = filled<Quad>(outline.size(), [](std::size_t i) {
            Quad quad = kQuadIndices;
            for (std::uint32_t& point : quad) point += 6 * static_cast<std::uint32_t>(i);
            return quad;
        });
        glVertexArrayElementBuffer(quads_.id(), indices_.id());
    }

    int count() const { return count_; }  ///< edges
    /// Edges and silhouettes to the shader's storage blocks 0 and 1.
    void bind() const {
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, edges_.id());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, silhouettes_.id());
    }
    /// Has the indices of quads, uints; no attributes.
    const gl::VertexArray& quads() const { return quads_; }

  private:
    struct GpuEdge {
        glm::vec4 a, b, stretchA, stretchB, planes[2];
    };
    struct GpuSilhouette {
        std::uint32_t entry;
        float farS[2];
    };
    /// Triangles of the six points of an edge, b's the other way round.
    static constexpr std::array<std::uint32_t, 12> kQuadIndices = {0, 2, 1, 0, 1, 4,
                                                                   0, 4, 5, 5, 4, 3};

    /// Of `count` elements, written where they stay: of ten million triangles a copy is a gigabyte.
    template <class Element, class Make>
    static gl::Buffer filled(std::size_t count, const Make& make) {
        const std::size_t bytes = count * sizeof(Element);
        gl::Buffer buffer = gl::Buffer::create(bytes, nullptr, GL_MAP_WRITE_BIT);
        if (count == 0) return buffer;
        auto* const out = static_cast<Element*>(glMapNamedBufferRange(
            buffer.id(), 0, static_cast<GLsizeiptr>(bytes), GL_MAP_WRITE_BIT));
        tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { out[i] = make(i); });
        glUnmapNamedBuffer(buffer.id());
        return buffer;
    }

    gl::VertexArray quads_;
    gl::Buffer edges_, silhouettes_, indices_;
    int count_ = 0;
};

}  // namespace penumbra
