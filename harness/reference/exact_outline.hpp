#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "core/scene/area_light.hpp"
#include "core/scene/geometry.hpp"
#include "core/trace/shaft.hpp"
#include "harness/reference/exact_union.hpp"

namespace penumbra {

/// All triangles in light space, with vertices at one place merged and every edge known once.
struct CasterMesh {
    using Triangle = std::array<std::uint32_t, 3>;
    /// A triangle's k-th edge runs from its k-th vertex to the next.
    struct TriangleEdge {
        std::uint32_t edge;
        int direction;  ///< +1 along the edge as `edges` has it, -1 against it
    };

    CasterMesh(const Geometry& geometry, const AreaLight& light);

    std::vector<glm::dvec3> vertices;
    std::vector<Triangle> triangles;  ///< no degenerate ones
    std::vector<std::array<TriangleEdge, 3>> edgesOf;
    std::vector<std::array<std::uint32_t, 2>> edges;  ///< from the lower to the higher vertex

    /// The volume, times 6, of the triangle and `p`: positive where `p` sees its front.
    double side(std::uint32_t triangle, const glm::dvec3& p) const;
};

/// The outlines of triangles as a point sees them on the light.
///
/// Turned so that it runs counter-clockwise, each triangle adds one to the count of triangles over
/// the light's points within, and its edges say so. Two neighbours that face the point alike run
/// along their common edge in opposite directions: the edge cancels, and of a closed surface
/// only the silhouette is left. For a group of nearby points this is done once, for all triangles
/// that face all of them alike.
class Outline {
  public:
    /// Of a segment's length, what next to the light does not count: what Tracer::Stream leaves.
    static constexpr double kLightMargin = 1e-4;
    /// The same next to the point, to keep divisions finite.
    static constexpr double kPointMargin = 1e-9;

    Outline(const CasterMesh& mesh, const glm::dvec2& halfLight);

    /// Prepares for points within `points`, in light space, where nothing but `triangles` may come
    /// between them and the light.
    void prepare(const Bounds& points, std::span<const std::uint32_t> triangles);
    /// What project() costs, in edges looked at.
    std::size_t cost() const { return base_ + kUndecidedCost * undecided_.size(); }
    /// Replaces the content of `sweep` by the outlines seen from `point`, on the light as the unit
    /// square.
    void project(const glm::dvec3& point, UnionSweep& sweep);

  private:
    static constexpr std::size_t kUndecidedCost = 16;

    /// (X, Y, W): seen through this the light has the coordinates (X/W, Y/W), and W is the height
    /// above the point towards the light. Cut before the division no coordinate is ever great.
    using Projected = glm::dvec3;
    Projected projected(const glm::dvec3& vertex) const;
    void touch(std::uint32_t edge, int count);
    void addTriangle(std::uint32_t triangle, int count);
    void addCuts(std::uint32_t triangle, int count, UnionSweep& sweep) const;
    void addEdge(std::uint32_t edge, int count, UnionSweep& sweep) const;
    void addCut(std::uint32_t triangle, int count, double height, UnionSweep& sweep) const;
    void addSegment(Projected a, Projected b, int count, UnionSweep& sweep) const;

    const CasterMesh& mesh_;
    glm::dvec2 halfLight_;
    std::vector<int> counts_;      ///< per edge, 0 between calls for those not in touched_
    std::vector<char> isTouched_;  ///< per edge
    std::vector<std::uint32_t> touched_;
    std::size_t base_ = 0;  ///< how many of touched_ are the group's
    std::vector<std::uint32_t> undecided_;
    std::vector<int> turns_;  ///< of undecided_ for one point: 1 front, -1 back, 0 edge-on
    glm::dvec3 point_{0.0};
    double lowest_ = 0.0, highest_ = 0.0;  ///< W that count
};

}  // namespace penumbra
