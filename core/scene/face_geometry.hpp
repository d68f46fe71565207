#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

#include "core/scene/geometry.hpp"

/// Faces around edges, on vertices of a Geometry: what EdgeAdjacency measures.
namespace penumbra {

/// Half the cross product of two sides: the normal times the area.
inline glm::dvec3 areaVector(const Geometry& geometry, const std::array<std::uint32_t, 3>& v) {
    const glm::dvec3 p(geometry.positions[v[0]]);
    return 0.5 * glm::cross(glm::dvec3(geometry.positions[v[1]]) - p,
                            glm::dvec3(geometry.positions[v[2]]) - p);
}

/// Unit, from the edge a b into the face on `v`.
inline glm::dvec3 intoFace(const Geometry& geometry, std::uint32_t a, std::uint32_t b,
                           const std::array<std::uint32_t, 3>& v) {
    const auto at = [&](std::uint32_t i) { return glm::dvec3(geometry.positions[i]); };
    const glm::dvec3 along = glm::normalize(at(b) - at(a));
    // A piece of a split edge holds vertices that the face does not: the face's own farthest one.
    glm::dvec3 most(0.0);
    for (const std::uint32_t i : v) {
        const glm::dvec3 from = at(i) - at(a), across = from - glm::dot(from, along) * along;
        if (glm::dot(across, across) > glm::dot(most, most)) most = across;
    }
    return glm::normalize(most);
}

/// Between faces whose directions differ from half a turn by less than 1e-5, which is more than
/// rounding of positions does to flat quads and less than any silhouette can show.
inline bool flat(const glm::dvec3& u, const glm::dvec3& w) {
    return glm::dot(u, w) < -1.0 + 0.5e-10;
}

}  // namespace penumbra
