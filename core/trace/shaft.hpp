#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
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
    /// Three indices into `vertices` per triangle; both must outlive the tree.
    ShaftTree(const std::vector<glm::dvec3>& vertices,
              const std::vector<std::array<std::uint32_t, 3>>& triangles);
    /// Replaces `found` by the triangles that `shaft` does not miss.
    void query(const Shaft& shaft, std::vector<std::uint32_t>& found) const;

  private:
    struct Node {
        Bounds box;
        std::uint32_t first = 0, count = 0;  ///< of `order_` in a leaf
        std::uint32_t right = 0;             ///< the left child comes next; 0 in a leaf
    };
    std::uint32_t build(std::uint32_t first, std::uint32_t count);
    Bounds boxOf(std::uint32_t triangle) const;

    const std::vector<glm::dvec3>& vertices_;
    const std::vector<std::array<std::uint32_t, 3>>& triangles_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace penumbra
