#pragma once

#include "core/frame/frame.hpp"

namespace penumbra {

/// Which triangles of a frame decide what is seen of its light. Left out are those that no map from
/// a point of the light shows at a receiver and without which no ray to the light gets through:
/// - faces of closed bodies that are turned away from all of the light. Whatever comes from a point
///   outside of a body meets a face turned towards that point first. A part counts where its bodies
///   are closed and oriented alike (PartFacts::outward) and the light is outside of their box;
/// - what is beside or behind the hull of the light and the receivers that the camera sees;
/// - with `onlyCasting`, parts that cast no shadow (PartFacts::casts), with `onlyInTheWay` those
///   that no comparison finds (PartFacts::inTheWay).
struct CasterChoice {
    bool wholeLight = true;  ///< false: from the light's centre alone
    bool onlyCasting = false, onlyInTheWay = false;
    /// How far beside a receiver lookups and rays may pass, metres.
    double marginM = 0.0;
};

/// The frame's geometry reduced to those: the same parts in the same order, so that `casterFacts`
/// holds for them, of fewer triangles and only the vertices these have. O(n), parallel but for the
/// copying.
Geometry shadowCasters(const Frame& frame, const CasterChoice& choice);

}  // namespace penumbra
