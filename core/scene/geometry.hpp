#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace penumbra {

/// One (node, primitive) of the asset: a contiguous range of the frame's triangles.
struct Part {
    std::string name;
    std::uint32_t firstVertex = 0, vertexCount = 0;
    std::uint32_t firstIndex = 0, indexCount = 0;
    int material = 0;    ///< index into Scene::materials
    bool moves = false;  ///< some track or animation changes it between frames
};

/// All triangles of one frame in world space, relative to Scene::origin so that float keeps its
/// precision wherever in the world the asset lies. Every surface casts and receives, from both
/// sides. The GPU buffers and the Embree scene are made of these very floats, so that no two
/// renderers disagree about where a triangle is. The light's own rectangle is not among them.
struct Geometry {
    std::vector<glm::vec3> positions;    ///< metres relative to Scene::origin
    std::vector<glm::vec3> normals;      ///< unit shading normals, one per position
    std::vector<glm::vec2> uvs;          ///< base colour texture coordinates, one per position
    std::vector<std::uint32_t> indices;  ///< three per triangle
    std::vector<Part> parts;             ///< in index order, covering all indices

    std::size_t triangleCount() const { return indices.size() / 3; }
    /// Index into `parts` of the part that triangle `t` belongs to; O(log parts).
    std::size_t partOf(std::uint32_t triangle) const;
};

struct Bounds {
    glm::dvec3 lo{1e300}, hi{-1e300};
    bool empty() const { return lo.x > hi.x; }
    void add(const glm::dvec3& p) { lo = glm::min(lo, p), hi = glm::max(hi, p); }
    bool operator==(const Bounds&) const = default;
    glm::dvec3 centre() const { return 0.5 * (lo + hi); }
    double radius() const { return empty() ? 0.0 : 0.5 * glm::length(hi - lo); }
};

Bounds boundsOf(const std::vector<glm::vec3>& points);

}  // namespace penumbra
