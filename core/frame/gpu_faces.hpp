#pragma once

#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"
#include "core/scene/edge_adjacency.hpp"

namespace penumbra {

/// The faces of an EdgeAdjacency on the GPU, for passes that tell front faces from back ones as a
/// light sees them. Vertex attribute 0 is the position; gl_PrimitiveID counts from `firstFace`.
class GpuFaces {
  public:
    GpuFaces() = default;
    explicit GpuFaces(const EdgeAdjacency& adjacency);

    /// Where the vertices are from now on: of the geometry that the adjacency describes.
    void place(const Geometry& geometry);
    /// Draws, with `program` in use, solids' faces but for those that `culled` (GL_FRONT, GL_BACK)
    /// says, and all sheets: seen by a light, which looks along +z of right-handed axes. Sets the
    /// uniform `firstFace`. Leaves culling off and no vertex array bound.
    void draw(const gl::Program& program, GLenum culled) const;
    /// EdgeAdjacency::Face::piece of each face, as uints.
    const gl::Buffer& pieces() const { return pieces_; }

  private:
    gl::VertexArray array_;
    gl::Buffer positions_, indices_, pieces_;
    int solids_ = 0, count_ = 0;
};

}  // namespace penumbra
