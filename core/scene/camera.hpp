#pragma once

#include <glm/glm.hpp>

namespace penumbra {

/// A glTF camera: looks down -Z of its frame, +Y up. Positions are relative to Scene::origin.
struct Camera {
    enum class Kind { perspective, orthographic };
    Kind kind = Kind::perspective;
    glm::dvec3 position{0.0};
    glm::dvec3 right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};  ///< orthonormal; the view is along -back
    double fovYRad = 0.8;                                   ///< perspective: full vertical angle
    double magY = 1.0;   ///< orthographic: half the height of the view in metres
    double nearM = 0.0;  ///< clip distances along the view direction
    double farM = 1e30;
    bool operator==(const Camera&) const = default;
};

struct CameraRay {
    glm::dvec3 origin;
    glm::dvec3 direction;  ///< unit
    double tNear, tFar;    ///< metres along direction, from the camera's clip planes
};

/// The ray through image position (x, y) in pixels, (0, 0) the top left corner of the image, pixel
/// centres at +0.5. The horizontal extent follows from width / height.
CameraRay cameraRay(const Camera& camera, double x, double y, int width, int height);

}  // namespace penumbra
