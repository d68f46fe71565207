#pragma once

#include <optional>
#include <span>

namespace penumbra {

/// The light's shape gives the profile of visibility across a straight edge: linear for a rectangle
/// with a side along the edge, a circle's segment area for a disc.
enum class EdgeShape { rectangle, disc };

/// A straight shadow edge along one scanline normal to it.
struct EdgeProfile {
    double widthM = 0.0;   ///< of the whole penumbra, umbra to lit
    double centreM = 0.0;  ///< position midway between the crossings
};

/// Fits the crossings of visibility 0.1 and 0.9 by linear interpolation; the whole width follows
/// from the shape (their distance over 0.8 for a rectangle, over 0.687 for a disc). Positions in
/// metres along the scanline, strictly rising, one visibility each, shadow on either side. Where
/// noise crosses more than once, the crossings nearest each other count. Absent where visibility
/// does not go from below 0.1 at one end to above 0.9 at the other (without umbra a width is not
/// defined) or is not finite. Throws std::invalid_argument for positions that do not rise.
std::optional<EdgeProfile> measureEdge(std::span<const double> positionsM,
                                       std::span<const double> visibility,
                                       EdgeShape shape = EdgeShape::rectangle);

struct EdgeError {
    double width = 0.0;        ///< (W - Wref) / Wref: above 0 the penumbra is too wide
    double centreShift = 0.0;  ///< in units of Wref, along the scanline
};
EdgeError compareEdges(const EdgeProfile& measured, const EdgeProfile& reference);

}  // namespace penumbra
