#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "core/scene/scene.hpp"
#include "harness/metrics/penumbra_width.hpp"

namespace penumbra {

/// The pixels that show a shadow edge as one scanline across it: in bins along the edge's segment,
/// about as wide as a pixel's footprint on the receiver.
struct EdgeScan {
    std::vector<double> positionsM;  ///< from the segment's start, of the bins' mean point; rising
    std::vector<std::vector<std::uint32_t>> pixels;  ///< of each bin, never none

    /// What measureEdge finds in `image`, one entry per pixel, averaged over each bin: penumbrae
    /// wider than some ten pixels come out as they are, of others the bins' width is a part.
    std::optional<EdgeProfile> measured(std::span<const float> image) const;
};

/// Takes the scored pixels beside the segment, at most halfWidthM off, whose tangent plane holds it
/// (to a thousandth of its length). Points and edge in the same coordinates. An edge that the frame
/// does not show has no bins.
EdgeScan scanEdge(const ShadowEdge& edge, const GBuffer& gbuffer);

}  // namespace penumbra
