#include "core/scene/geometry.hpp"

#include <algorithm>

namespace penumbra {

std::size_t Geometry::partOf(std::uint32_t triangle) const {
    const auto firstAfter = std::upper_bound(
        parts.begin(), parts.end(), std::uint64_t{3} * triangle,
        [](std::uint64_t index, const Part& part) { return index < part.firstIndex; });
    return static_cast<std::size_t>(firstAfter - parts.begin()) - 1;
}

Bounds boundsOf(const std::vector<glm::vec3>& points) {
    Bounds bounds;
    for (const glm::vec3& p : points) bounds.add(glm::dvec3(p));
    return bounds;
}

}  // namespace penumbra
