#include "core/frame/light_view.hpp"

#include <algorithm>

namespace penumbra {
namespace {

LightTile fitTile(const std::array<glm::dvec3, 3>& axes, const SideBounds& bounds,
                  glm::dvec2 guardM, int mapSize) {
    LightTile tile{axes[0], axes[1], axes[2]};
    if (bounds.empty()) return tile;
    // The nearest receiver needs the widest guard; far past kMaxTangent a guard only costs texels.
    const glm::dvec2 guard =
        glm::min(guardM / bounds.receiverNearM, glm::dvec2(LightView::kMaxTangent));
    tile.tangentLo = bounds.tangentLo - guard;
    tile.tangentHi = bounds.tangentHi + guard;
    // A single visible receiver still needs a frustum with an inside.
    const glm::dvec2 centre = 0.5 * (tile.tangentLo + tile.tangentHi);
    const glm::dvec2 half = glm::max(0.5 * tile.tangentSize(), glm::dvec2(1e-4)) *
                            (mapSize > 2 ? mapSize / (mapSize - 2.0) : 1.0);
    tile.tangentLo = centre - half;
    tile.tangentHi = centre + half;
    // Nearer casters are clamped to nearM and still block the receivers behind it. A triangle that
    // crosses the light's plane comes nearer than all its vertices, so that no receiver may be near
    // nearM either. The bound keeps s of far receivers well above the depth buffer's smallest
    // steps.
    tile.nearM = std::clamp(std::min(bounds.casterNearM, 0.5 * bounds.receiverNearM),
                            1e-4 * bounds.receiverFarM, bounds.receiverFarM);
    return tile;
}

}  // namespace

LightView LightView::fit(const Frame& frame, glm::dvec2 guardM, int mapSize) {
    LightView view;
    view.centre = frame.light.centre;
    const SideBounds& whole = frame.lightBounds.whole;
    const bool oneFrustum =
        whole.empty() || std::max({-whole.tangentLo.x, -whole.tangentLo.y, whole.tangentHi.x,
                                   whole.tangentHi.y}) <= kMaxTangent;
    if (oneFrustum) {
        view.tiles = {fitTile(lightSideAxes(frame.light, 0), whole, guardM, mapSize)};
        return view;
    }
    const double guard = std::max(guardM.x, guardM.y);
    for (std::size_t side = 0; side < frame.lightBounds.sides.size(); ++side)
        view.tiles.push_back(fitTile(lightSideAxes(frame.light, side),
                                     frame.lightBounds.sides[side], glm::dvec2(guard), mapSize));
    return view;
}

glm::mat4 LightView::clipFromWorld(std::size_t index) const {
    const LightTile& tile = tiles[index];
    const glm::dvec2 scale = 2.0 / tile.tangentSize();
    // clip.x / clip.w = 2 (x/z - lo) / size - 1
    const glm::dvec3 rowX = scale.x * tile.axisX - (scale.x * tile.tangentLo.x + 1.0) * tile.axisZ;
    const glm::dvec3 rowY = scale.y * tile.axisY - (scale.y * tile.tangentLo.y + 1.0) * tile.axisZ;
    const glm::dvec3& rowW = tile.axisZ;
    return glm::mat4(glm::transpose(glm::dmat4(
        glm::dvec4(rowX, -glm::dot(rowX, centre)), glm::dvec4(rowY, -glm::dot(rowY, centre)),
        glm::dvec4(0, 0, 0, tile.nearM), glm::dvec4(rowW, -glm::dot(rowW, centre)))));
}

}  // namespace penumbra
