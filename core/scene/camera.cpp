#include "core/scene/camera.hpp"

#include <cmath>

namespace penumbra {

CameraRay cameraRay(const Camera& camera, double x, double y, int width, int height) {
    const double aspect = static_cast<double>(width) / height;
    const double right = (2.0 * x / width - 1.0) * aspect;
    const double up = 1.0 - 2.0 * y / height;
    if (camera.kind == Camera::Kind::orthographic) {
        const glm::dvec3 offset = camera.magY * (right * camera.right + up * camera.up);
        return {camera.position + offset, -camera.back, camera.nearM, camera.farM};
    }
    const double extent = std::tan(0.5 * camera.fovYRad);
    const glm::dvec3 direction = extent * (right * camera.right + up * camera.up) - camera.back;
    // One metre along the view axis is `length` metres along this ray.
    const double length = glm::length(direction);
    return {camera.position, direction / length, camera.nearM * length, camera.farM * length};
}

}  // namespace penumbra
