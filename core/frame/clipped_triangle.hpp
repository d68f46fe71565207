#pragma once

#include <algorithm>
#include <array>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace penumbra {

/// Which depths a triangle takes, and how its area lies in them.
struct DepthExtent {
    double nearM, farM, areaM2;
    double middleM;  ///< depth of the corner between the nearest and the farthest

    /// How much of a triangle's area is nearer than `zM`: its width is linear in depth on both
    /// sides of the middle corner, so that cutting it in parts changes nothing.
    double areaNearer(double zM) const {
        if (zM <= nearM) return 0.0;
        if (zM >= farM) return areaM2;
        const double depthM = farM - nearM, before = zM - nearM, behind = farM - zM;
        return zM < middleM ? areaM2 * before * before / ((middleM - nearM) * depthM)
                            : areaM2 - areaM2 * behind * behind / ((farM - middleM) * depthM);
    }
};

/// A triangle clipped to a convex volume by Sutherland and Hodgman: a polygon of at most
/// kMostPoints points, which nobody checks.
class ClippedTriangle {
  public:
    /// Every plane may add one to the three corners.
    static constexpr std::size_t kMostPlanes = 20, kMostPoints = 3 + kMostPlanes;

    ClippedTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
        : points_{a, b, c} {}

    /// Keeps the part with dot(plane, (p, 1)) >= 0.
    void clip(const glm::dvec4& plane) {
        const auto height = [&](const glm::dvec3& p) {
            return glm::dot(glm::dvec3(plane), p) + plane.w;
        };
        // Most triangles are, and need no copy.
        if (std::ranges::all_of(points(), [&](const glm::dvec3& p) { return height(p) >= 0.0; }))
            return;
        std::array<glm::dvec3, kMostPoints> kept;
        int count = 0;
        for (int i = 0; i < count_; ++i) {
            const glm::dvec3 &from = at(i), &to = at((i + 1) % count_);
            const double h0 = height(from), h1 = height(to);
            if (h0 >= 0.0) kept[static_cast<std::size_t>(count++)] = from;
            if ((h0 > 0.0 && h1 < 0.0) || (h0 < 0.0 && h1 > 0.0))
                kept[static_cast<std::size_t>(count++)] = from + h0 / (h0 - h1) * (to - from);
        }
        std::copy_n(kept.begin(), count, points_.begin());
        count_ = count;
    }
    bool empty() const { return count_ == 0; }
    std::span<const glm::dvec3> points() const {
        return {points_.data(), static_cast<std::size_t>(count_)};
    }
    double nearM() const {
        return std::ranges::min(points(), {}, [](const glm::dvec3& p) { return p.z; }).z;
    }
    double farM() const {
        return std::ranges::max(points(), {}, [](const glm::dvec3& p) { return p.z; }).z;
    }
    /// Adds the triangles that it consists of; none without an area, for that is drawn nowhere and
    /// must not draw planes to its depth.
    void addTo(std::vector<DepthExtent>& extents) const {
        for (int i = 1; i + 1 < count_; ++i) {
            std::array<double, 3> z = {at(0).z, at(i).z, at(i + 1).z};
            std::ranges::sort(z);
            const double areaM2 = 0.5 * glm::length(glm::cross(at(i) - at(0), at(i + 1) - at(0)));
            if (areaM2 > 0.0) extents.push_back({z[0], z[2], areaM2, z[1]});
        }
    }

  private:
    const glm::dvec3& at(int i) const { return points_[static_cast<std::size_t>(i)]; }
    std::array<glm::dvec3, kMostPoints> points_;
    int count_ = 3;
};

}  // namespace penumbra
