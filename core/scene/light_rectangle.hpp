#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "core/scene/area_light.hpp"
#include "core/scene/asset.hpp"

namespace penumbra::scene_detail {

/// A rectangle in the space of the node that places it.
struct LocalRectangle {
    glm::dvec3 corner;        ///< where both edges start
    glm::dvec3 edgeU, edgeV;  ///< full edges; cross(edgeU, edgeV) is the front, counter-clockwise

    /// The light this rectangle is under `world`. A mirroring matrix keeps the front (glTF 2.0,
    /// section 3.7.4: a negative determinant makes clockwise the front).
    AreaLight placedBy(const glm::dmat4& world) const;
};

/// The rectangle that `primitive`, placed by `world`, forms: exactly two triangles, equally wound,
/// with four distinct corners, parallel sides and right angles up to 1e-4 of its size.
std::optional<LocalRectangle> rectangleOf(const AssetPrimitive& primitive, const glm::dmat4& world);

}  // namespace penumbra::scene_detail
