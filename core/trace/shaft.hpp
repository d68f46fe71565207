#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/scene/area_light.hpp"
#include "core/scene/geometry.hpp"

namespace penumbra {

/// Coordinates in which the light is axis-aligned: x along axisU, y along axisV, z the distance in
/// front of the light's plane, all from the light's centre in metres. Right-handed.
class LightSpace {
  public:
    explicit LightSpace(const AreaLight& light)
        : centre_(light.centre), x_(light.axisU), y_(light.axisV), z_(light.normal()) {}
    glm::dvec3 point(const glm::dvec3& p) const { return direction(p - centre_); }
    glm::dvec3 direction(const glm::dvec3& d) const {
        return {glm::dot(d, x_), glm::dot(d, y_), glm::dot(d, z_)};
    }

  private:
    glm::dvec3 centre_, x_, y_, z_;
};

/// A convex set that holds every segment from a box of points in front of the light to the light,
/// in light space. In the planes x-z and y-z it is the hull of the light's side and the box's
/// (Haines & Wallace 1991, shaft culling; here both bodies are boxes along the same axes).
class Shaft {
  public:
    /// `points.lo.z` > 0; `halfLight` may be zero.
    Shaft(const Bounds& points, const glm::dvec2& halfLight);
    /// Whether the box, or the triangle, is outside for sure.
    bool misses(const Bounds& box) const;
    bool misses(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const;

  private:
    /// Points with slope.x * (x or y) + slope.y * z + offset >= 0 are inside.
    struct Side {
        int axis;
        glm::dvec2 slope;
        double offset;
        double at(const glm::dvec3& p) const { return slope.x * p[axis] + slope.y * p.z + offset; }
    };
    Bounds hull_;
    std::array<Side, 4> sides_;
};

/// The triangles that a shaft may meet: a binary BVH over light space, split at the median.
class ShaftTree {
  public:
    /// Three indices into `vertices` per triangle; both must outlive the tree. So many as `run`
    /// that follow each other stay together: where neighbours in a mesh are neighbours in its list,
    /// a tree of runs is made many times faster and finds the same a little slower.
    ShaftTree(const std::vector<glm::dvec3>& vertices,
              const std::vector<std::array<std::uint32_t, 3>>& triangles, std::uint32_t run = 1);
    /// Replaces `found` by the triangles that `shaft` does not miss.
    void query(const Shaft& shaft, std::vector<std::uint32_t>& found) const;
    /// Some triangle that `shaft` does not miss and for whose vertices `isMeant(a, b, c)` holds;
    /// boxes for which `mayHold` is false are passed over.
    template <class MayHold, class IsMeant>
    std::optional<std::uint32_t> any(const Shaft& shaft, const MayHold& mayHold,
                                     const IsMeant& isMeant) const {
        std::optional<std::uint32_t> found;
        visit(shaft, mayHold, [&](std::uint32_t triangle) {
            const auto& [a, b, c] = triangles_[triangle];
            if (isMeant(vertices_[a], vertices_[b], vertices_[c])) found = triangle;
            return !found;
        });
        return found;
    }
    const std::array<std::uint32_t, 3>& triangle(std::uint32_t index) const {
        return triangles_[index];
    }

  private:
    struct Node {
        Bounds box;
        std::uint32_t first = 0, count = 0;  ///< of `order_` in a leaf
        std::uint32_t right = 0;             ///< the left child comes next; 0 in a leaf
    };
    /// A median split halves the count: more than enough for 2^32 triangles.
    static constexpr int kMaxDepth = 40;

    /// Nodes of a subtree by its runs, for each count there is in the tree but leaves'.
    using NodeCounts = std::unordered_map<std::uint32_t, std::uint32_t>;
    bool isLeaf(std::uint32_t count) const;
    std::uint32_t countNodes(std::uint32_t count, NodeCounts& counts) const;
    /// Fills `nodes_` from `index` on. Where a subtree begins follows from the counts alone, so
    /// that both halves can be built at once and the tree is the same on any number of threads.
    void build(const std::vector<Bounds>& boxes, const NodeCounts& counts, std::uint32_t index,
               std::uint32_t first, std::uint32_t count);
    /// Calls `onTriangle` with all that `shaft` does not miss until it returns false.
    template <class MayHold, class OnTriangle>
    void visit(const Shaft& shaft, const MayHold& mayHold, const OnTriangle& onTriangle) const;

    const std::vector<glm::dvec3>& vertices_;
    const std::vector<std::array<std::uint32_t, 3>>& triangles_;
    std::uint32_t run_;
    std::vector<std::uint32_t> order_;  ///< of runs
    std::vector<Node> nodes_;
};

template <class MayHold, class OnTriangle>
void ShaftTree::visit(const Shaft& shaft, const MayHold& mayHold,
                      const OnTriangle& onTriangle) const {
    if (nodes_.empty()) return;
    const auto triangleCount = static_cast<std::uint32_t>(triangles_.size());
    std::array<std::uint32_t, kMaxDepth> stack;
    std::size_t waiting = 0;
    stack[waiting++] = 0;
    while (waiting > 0) {
        const std::uint32_t index = stack[--waiting];
        const Node& node = nodes_[index];
        if (shaft.misses(node.box) || !mayHold(node.box)) continue;
        if (node.right != 0) {
            stack[waiting++] = node.right;
            stack[waiting++] = index + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const std::uint32_t end = std::min(triangleCount, (order_[i] + 1) * run_);
            for (std::uint32_t t = order_[i] * run_; t < end; ++t) {
                const auto& [a, b, c] = triangles_[t];
                if (!shaft.misses(vertices_[a], vertices_[b], vertices_[c]) && !onTriangle(t))
                    return;
            }
        }
    }
}

}  // namespace penumbra
