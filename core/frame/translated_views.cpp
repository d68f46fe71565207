#include "core/frame/translated_views.hpp"

#include <algorithm>

namespace penumbra {
namespace {

/// All that may be in front of a point of the light, by tiles: the whole half cube.
void widenToHalfCube(LightBounds& bounds, const AreaLight& light) {
    double farM = 0.0;
    for (const SideBounds& side : bounds.sides) farM = std::max(farM, side.receiverFarM);
    for (std::size_t i = 0; i < bounds.sides.size(); ++i) {
        SideBounds& side = bounds.sides[i];
        side.receiverFarM = farM + light.halfU + light.halfV;
        side.receiverNearM = 1e-4 * side.receiverFarM;  // LightView's least nearM
        const std::array<glm::dvec3, 3> axes = lightSideAxes(light, i);
        for (int axis = 0; axis < 2; ++axis) {
            // Side tiles end at the light's plane.
            const bool alongNormal =
                glm::dot(axes[static_cast<std::size_t>(axis)], light.normal()) > 0.5;
            side.tangentLo[axis] = alongNormal ? 0.0 : -1.0;
            side.tangentHi[axis] = 1.0;
        }
    }
}

}  // namespace

TranslatedViews::TranslatedViews(const Frame& frame, int mapSize, bool wholeLight)
    : axisU_(frame.light.axisU),
      axisV_(frame.light.axisV),
      halfM_(frame.light.halfU, frame.light.halfV) {
    if (!wholeLight) {
        centre_ = LightView::fit(frame, glm::dvec2(0.0), mapSize);
        return;
    }
    Frame widened = frame;
    SideBounds& whole = widened.lightBounds.whole;
    if (!whole.empty()) {
        const auto& [low, high] = frame.lightBounds.fromCorners;
        const glm::dvec2 extent = glm::max(glm::max(low.hi - low.lo, high.hi - high.lo),
                                           whole.tangentHi - whole.tangentLo);
        middles_ = {0.5 * (low.lo + low.hi), 0.5 * (whole.tangentLo + whole.tangentHi),
                    0.5 * (high.lo + high.hi)};
        whole.tangentLo = middles_[1] - 0.5 * extent;
        whole.tangentHi = middles_[1] + 0.5 * extent;
    }
    widenToHalfCube(widened.lightBounds, frame.light);
    centre_ = LightView::fit(widened, glm::dvec2(0.0), mapSize);
}

LightView TranslatedViews::from(glm::dvec2 offsetM) const {
    LightView view = centre_;
    view.centre += offsetM.x * axisU_ + offsetM.y * axisV_;
    if (view.tiles.size() > 1) return view;
    for (int axis = 0; axis < 2; ++axis) {
        if (offsetM[axis] == 0.0) continue;
        const glm::dvec2& end = middles_[offsetM[axis] < 0.0 ? 0 : 2];
        const double shift =
            std::abs(offsetM[axis]) / halfM_[axis] * (end[axis] - middles_[1][axis]);
        view.tiles[0].tangentLo[axis] += shift;
        view.tiles[0].tangentHi[axis] += shift;
    }
    return view;
}

}  // namespace penumbra
