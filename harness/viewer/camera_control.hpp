#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "core/scene/camera.hpp"

namespace penumbra {

/// How a hand moves a camera. Each returns the moved camera, its axes orthonormal, without clip
/// distances, which no scene script could say again. World up is +Y; a tilted camera stays tilted.

/// Around `pivot`: by `yawRad` about +Y and by `pitchRad` about the camera's right, up to half a
/// degree from straight up or down.
Camera orbited(const Camera& camera, const glm::dvec3& pivot, double yawRad, double pitchRad);
/// The same turn on the spot.
Camera turned(const Camera& camera, double yawRad, double pitchRad);
/// By metres along its own right, up and forward.
Camera moved(const Camera& camera, const glm::dvec3& rightUpForwardM);
/// Towards `pivot` to `factor` of the distance; an orthographic view shrinks with it.
Camera dollied(const Camera& camera, const glm::dvec3& pivot, double factor);
/// Back along its view until the sphere is in an image of `aspect` (width / height).
Camera backedOff(const Camera& camera, const glm::dvec3& centre, double radiusM, double aspect);

/// Where a point appears, in pixels as of cameraRay(); nothing behind the camera.
std::optional<glm::dvec2> projected(const Camera& camera, const glm::dvec3& point, int width,
                                    int height);
/// Metres that one pixel covers at the point's depth; 0 behind the camera.
double metresPerPixel(const Camera& camera, const glm::dvec3& point, int height);

}  // namespace penumbra
