#include "core/frame/gpu_faces.hpp"

#include <cstdint>
#include <vector>

namespace penumbra {

GpuFaces::GpuFaces(const EdgeAdjacency& adjacency) {
    std::vector<std::uint32_t> indices, pieces;
    for (const bool solid : {true, false}) {
        for (const EdgeAdjacency::Face& face : adjacency.faces())
            if (face.solid == solid) {
                indices.insert(indices.end(), face.vertices.begin(), face.vertices.end());
                pieces.push_back(face.piece);
            }
        if (solid) solids_ = static_cast<int>(pieces.size());
    }
    count_ = static_cast<int>(pieces.size());
    indices_ = gl::Buffer::create(indices.size() * sizeof(std::uint32_t), indices.data());
    pieces_ = gl::Buffer::create(pieces.size() * sizeof(std::uint32_t), pieces.data());
    GLuint id = 0;
    glCreateVertexArrays(1, &id);
    array_ = gl::VertexArray(id);
    glVertexArrayElementBuffer(id, indices_.id());
    glVertexArrayAttribFormat(id, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(id, 0, 0);
    glEnableVertexArrayAttrib(id, 0);
}

void GpuFaces::place(const Geometry& geometry) {
    positions_ = gl::Buffer::create(geometry.positions.size() * sizeof(glm::vec3),
                                    geometry.positions.data());
    glVertexArrayVertexBuffer(array_.id(), 0, positions_.id(), 0, sizeof(glm::vec3));
}

void GpuFaces::draw(const gl::Program& program, GLenum culled) const {
    glBindVertexArray(array_.id());
    const auto draw = [&](int first, int end) {
        program.set("firstFace", first);
        const auto offset = static_cast<std::uintptr_t>(first) * 3 * sizeof(std::uint32_t);
        if (end > first)
            glDrawElements(GL_TRIANGLES, 3 * (end - first), GL_UNSIGNED_INT,
                           reinterpret_cast<const void*>(offset));
    };
    // What runs counterclockwise for the light runs clockwise in its map.
    glFrontFace(GL_CW);
    glCullFace(culled);
    glEnable(GL_CULL_FACE);
    draw(0, solids_);
    glDisable(GL_CULL_FACE);
    glFrontFace(GL_CCW);
    draw(solids_, count_);
    glBindVertexArray(0);
}

}  // namespace penumbra
