#include "core/passes/lit_tiles.hpp"

#include <algorithm>
#include <cmath>

namespace penumbra {

LitTiles::LitTiles(bool alphaMask)
    : depth_(alphaMask),
      pyramid_(MinMaxPyramid::create()),
      classes_(PixelClasses::create(PixelClasses::Dark::no)) {}

void LitTiles::classify(const Frame& frame, int mapSize, float biasTexels) {
    constexpr double kMostWidening = 2.0;
    usable_ = false;
    const SideBounds& bounds = frame.lightBounds.whole;
    if (bounds.empty()) return;
    // A ray from a receiver at depth z to a point of the light is off the receiver's tangents by
    // the point's place times (1 / depth - 1 / z): most at the nearest vertex for the farthest
    // receiver.
    const double reach = std::max(0.0, 1.0 / bounds.casterNearM - 1.0 / bounds.receiverFarM);
    const glm::dvec2 guard = reach * glm::dvec2(frame.light.halfU, frame.light.halfV);
    const LightView fitted = LightView::fit(frame, {}, mapSize);
    if (fitted.tiles.size() > 1) return;
    const glm::dvec2 widening = 1.0 + 2.0 * guard / fitted.tiles[0].tangentSize();
    const double most = std::max(widening.x, widening.y);
    if (most > kMostWidening || std::max(guard.x, guard.y) > LightView::kMaxTangent) return;
    const int size = std::min(static_cast<int>(std::ceil(mapSize * most)), 16384);
    depth_.render(frame, LightView::fit(frame, guard * bounds.receiverNearM, size), size);
    pyramid_.build(depth_);
    classes_.classify(frame, depth_, pyramid_, biasTexels, PixelClasses::Kernel{});
    usable_ = true;
}

double LitTiles::mebibytes() const {
    return usable_
               ? depth_.map().mebibytes() + pyramid_.texture().mebibytes() + classes_.mebibytes()
               : 0.0;
}

}  // namespace penumbra
