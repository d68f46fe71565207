#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/scene/geometry.hpp"

namespace penumbra {

/// Finds the vertices that lie inside edges, by cells of a grid that are about as wide as an edge
/// is long.
class VertexGrid {
  public:
    /// Of the vertices `which`. `lengthM`: of an edge; `extentM`: no coordinate is greater.
    VertexGrid(const Geometry& geometry, const std::vector<std::uint32_t>& which, double lengthM,
               double extentM)
        : geometry_(geometry),
          // Twenty bits hold each coordinate of a cell.
          cellM_(std::max(lengthM, extentM * 0x1p-19)),
          // Rounding of float positions, thrice over.
          toleranceM_(3.0 * 0x1p-24 * extentM) {
        for (const std::uint32_t v : which) vertices_[key(cell(at(v)))].push_back(v);
    }

    /// Those strictly inside the edge, in order from `from`, with where they are on it.
    std::vector<std::pair<double, std::uint32_t>> inside(std::uint32_t from,
                                                         std::uint32_t to) const {
        const glm::dvec3 a = at(from), along = at(to) - a;
        const double lengthM = glm::length(along);
        std::vector<std::pair<double, std::uint32_t>> found;
        const auto consider = [&](std::uint32_t v) {
            if (v == from || v == to) return;
            const glm::dvec3 offset = at(v) - a;
            const double t = glm::dot(offset, along) / (lengthM * lengthM);
            if (t * lengthM > toleranceM_ && (1.0 - t) * lengthM > toleranceM_ &&
                glm::length(offset - t * along) <= toleranceM_)
                found.emplace_back(t, v);
        };
        // Bit by bit, no longer than a cell: each touches eight cells at most.
        const int bits = static_cast<int>(std::ceil(lengthM / cellM_));
        for (int i = 0; i < bits; ++i) {
            const glm::dvec3 p = a + along * (static_cast<double>(i) / bits),
                             q = a + along * ((i + 1.0) / bits);
            const glm::ivec3 lo = cell(glm::min(p, q) - toleranceM_),
                             hi = cell(glm::max(p, q) + toleranceM_);
            for (int z = lo.z; z <= hi.z; ++z)
                for (int y = lo.y; y <= hi.y; ++y)
                    for (int x = lo.x; x <= hi.x; ++x)
                        if (const auto here = vertices_.find(key({x, y, z}));
                            here != vertices_.end())
                            std::ranges::for_each(here->second, consider);
        }
        std::ranges::sort(found);
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    }

  private:
    static std::uint64_t key(const glm::ivec3& c) {
        const auto bits = [](int v) { return static_cast<std::uint64_t>(v) & 0x1fffffu; };
        return bits(c.x) << 42 | bits(c.y) << 21 | bits(c.z);
    }
    glm::ivec3 cell(const glm::dvec3& p) const { return {glm::floor(p / cellM_)}; }
    glm::dvec3 at(std::uint32_t v) const { return glm::dvec3(geometry_.positions[v]); }

    const Geometry& geometry_;
    double cellM_, toleranceM_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> vertices_;
};

}  // namespace penumbra
