#pragma once

#include <cstdint>
#include <span>

#include "core/scene/geometry.hpp"

namespace penumbra {

/// Whether a line meets these triangles of a geometry as one caster at most: they lie in one plane,
/// or they bound a convex solid, which is entered and left once. False where that is not certain;
/// rounding of positions to float is allowed for. O(n log n).
bool isOneCaster(const Geometry& geometry, std::span<const std::uint32_t> triangles);

}  // namespace penumbra
