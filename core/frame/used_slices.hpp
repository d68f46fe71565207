#pragma once

#include <cstdint>

#include "core/frame/slice_view.hpp"

namespace penumbra {

/// Slices of a view, slice k bit k, at most 64.
using SliceSet = std::uint64_t;

/// Slices into which some triangle may be drawn: no texture need hold the others. Triangles count
/// with all of their depths unless the frustum has them all on one outer side. O(n) in triangles.
SliceSet slicesWithCasters(const SliceView& view, const Geometry& geometry);

/// Slices that begin between two depths, metres: those into which a caster goes on that reaches
/// from one to the other.
SliceSet slicesBegunBetween(const SliceView& view, double fromM, double toM);

}  // namespace penumbra
