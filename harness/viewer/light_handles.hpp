#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/scene/area_light.hpp"
#include "core/scene/camera.hpp"

namespace penumbra {

/// What of the light a hand can take hold of.
enum class LightHandle {
    none,
    centre,  ///< moves it parallel to the image
    alongX,  ///< moves it along a world axis
    alongY,
    alongZ,
    aim,     ///< turns it to face elsewhere
    twist,   ///< turns it about its normal
    widerU,  ///< resizes it about its centre
    widerV,
};

/// Where a handle is. Several may be the same one: an edge on either side.
struct HandlePoint {
    LightHandle handle = LightHandle::none;
    glm::dvec3 at{0.0};
};

/// The picture that the handles are seen in.
struct HandleView {
    Camera camera;
    int width = 1, height = 1;  ///< of the picture, pixels
    double armPixels = 90.0;    ///< how long the handles' arms are in it
};

/// All handles of a light. None behind the camera.
std::vector<HandlePoint> lightHandles(const AreaLight& light, const HandleView& view);

/// The handle nearest to an image position (pixels) within `reachPixels`.
LightHandle pickHandle(const std::vector<HandlePoint>& handles, const HandleView& view,
                       const glm::dvec2& at, double reachPixels);

/// The light that was `start` when the hand took `handle` at image position `from`, with the hand
/// at `to`: a function of nothing else, so that a long drag gathers no error.
AreaLight draggedLight(const AreaLight& start, LightHandle handle, const HandleView& view,
                       const glm::dvec2& from, const glm::dvec2& to);

/// `light` turned to face along unit `normal` by the least turn.
AreaLight facing(const AreaLight& light, const glm::dvec3& normal);

/// The shortest side that a drag leaves a light, as a share of what it had.
inline constexpr double kLeastShrink = 1e-3;

}  // namespace penumbra
