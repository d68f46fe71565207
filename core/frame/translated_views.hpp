#pragma once

#include <array>
#include <glm/glm.hpp>

#include "core/frame/light_view.hpp"

namespace penumbra {

/// Light views of one frame from any number of points of its light, all of one shape: same axes,
/// parallel image planes, same nearM and same extent in tangents, so that a point has the same
/// depth z and the same stored s in all of them and a plane's slope differs by one factor only.
/// Each off-centre frustum is shifted to hold the receivers that the camera sees as its own point
/// of the light sees them.
///
/// Seen from a point q of the light, a receiver at depth z moves by -q/z; the least and the
/// greatest over all receivers are concave and convex in q, so that interpolating them between the
/// light's ends and its centre (LightBounds::fromCorners) never cuts a receiver off. Where one
/// frustum would be wider than 140 degrees the views have the five tiles of a half cube, unfitted,
/// because which tile a receiver is in then depends on q.
class TranslatedViews {
  public:
    TranslatedViews() = default;
    /// For maps of `mapSize` texels across; every view has a margin of one texel. With `wholeLight`
    /// false only the centre is seen from, by the very view of LightView::fit.
    TranslatedViews(const Frame& frame, int mapSize, bool wholeLight = true);

    /// The view from light.centre + offsetM.x axisU + offsetM.y axisV, a point of the light.
    LightView from(glm::dvec2 offsetM) const;
    std::size_t tileCount() const { return centre_.tiles.size(); }

  private:
    LightView centre_;
    glm::dvec3 axisU_{1, 0, 0}, axisV_{0, 1, 0};
    glm::dvec2 halfM_{0.0};
    /// Of the receivers' tangents as seen from the light's corner -u -v, centre, corner +u +v.
    std::array<glm::dvec2, 3> middles_{};
};

}  // namespace penumbra
