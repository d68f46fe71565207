#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/gl/handles.hpp"
#include "core/scene/geometry.hpp"
#include "core/scene/material.hpp"

namespace penumbra {

/// Materials' textures on the GPU, once per scene.
class GpuMaterials {
  public:
    GpuMaterials(const std::vector<Material>& materials, const std::vector<TextureImage>& images);
    const std::vector<Material>& materials() const { return materials_; }
    /// Binds the base colour texture of `material` (white where it has none) to `unit`.
    void bind(int material, GLuint unit) const;

  private:
    const std::vector<Material>& materials_;
    std::vector<gl::Texture> textures_;
    gl::Texture white_;
};

/// How a Part is drawn.
struct PartDraw {
    bool drawn = true;
    GLenum culled = GL_NONE;  ///< GL_FRONT or GL_BACK: faces left out; front runs counterclockwise
    /// Across the viewport: vertices are put where rasterisation puts them anyway, so that a
    /// triangle's depths are those of the corners that it is covered with. Else they are off by a
    /// part of a step, which is much where it is seen edge-on, and averted sides of a closed body
    /// come out in front of its others at its outline. For parts that are ahead of the viewer with
    /// all of their vertices; 0: they stay as they are. A uniform of the program's, if it has it.
    float rasterSteps = 0.0f;
    bool operator==(const PartDraw&) const = default;
};

/// One frame's triangles on the GPU: attribute 0 position (vec3), 1 texture coordinates (vec2),
/// 2 shading normal (vec3); 32-bit indices.
class GpuGeometry {
  public:
    GpuGeometry(std::shared_ptr<const Geometry> geometry, const GpuMaterials& materials);

    const Geometry& geometry() const { return *geometry_; }
    const GpuMaterials& materials() const { return *materials_; }
    /// Draws every triangle with the program in use, `instances` times: all opaque parts in one
    /// call, then one call per alpha-masked material with its texture on unit 0 and the uniforms
    /// `alphaMasked`, `alphaCutoff` and `alphaFactor` of shaders/common/alpha.glsl set. With
    /// `alphaMask` false every part is drawn as opaque. With `how`, of each Part of the geometry,
    /// neighbours that are drawn alike are in one call.
    void draw(GLuint program, bool alphaMask, int instances = 1,
              std::span<const PartDraw> how = {}) const;

  private:
    struct Batch {
        int material = -1;                       ///< -1: opaque
        std::size_t firstPart = 0, endPart = 0;  ///< of parts_
    };
    struct DrawnPart {
        std::size_t part;  ///< in Geometry::parts
        std::uint32_t firstIndex, indexCount;
    };
    void drawParts(GLuint program, std::size_t first, std::size_t end, int instances,
                   std::span<const PartDraw> how) const;

    std::shared_ptr<const Geometry> geometry_;
    const GpuMaterials* materials_;
    gl::Buffer positions_, uvs_, normals_, indices_;
    gl::VertexArray vertexArray_;
    std::vector<Batch> batches_;
    std::vector<DrawnPart> parts_;  ///< in the order of their indices, batch by batch
};

}  // namespace penumbra
