#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "core/frame/slice_view.hpp"

namespace penumbra {

/// Slices of a view, slice k bit k, at most 64.
using SliceSet = std::uint64_t;

/// What triangles may be drawn into.
struct DrawnSlices {
    SliceSet slices = 0;  ///< no texture need hold the others
    /// Of the texture, in [0, 1]^2: what they may cover of it in all slices together. Empty, lo
    /// above hi, where there are none.
    glm::dvec2 uvLo{1.0}, uvHi{0.0};
};

/// Triangles count with all of their depths and the box of all of their places, unless the frustum
/// has them all on one outer side. O(n) in triangles.
DrawnSlices slicesWithCasters(const SliceView& view, const Geometry& geometry);

/// Slices that begin between two depths, metres: those into which a caster goes on that reaches
/// from one to the other.
SliceSet slicesBegunBetween(const SliceView& view, double fromM, double toM);

}  // namespace penumbra
