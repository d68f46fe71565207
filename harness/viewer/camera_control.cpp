#include "harness/viewer/camera_control.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace penumbra {
namespace {

const glm::dvec3 kUp{0, 1, 0};
constexpr double kPoleRad = 0.0087;  // half a degree

Camera unclipped(Camera camera) {
    camera.nearM = 0.0;
    camera.farM = Camera{}.farM;
    return camera;
}

/// `pitchRad`, less what would bring the view closer to the vertical than kPoleRad.
double boundedPitch(const Camera& camera, double pitchRad) {
    const double elevation = std::asin(std::clamp(-camera.back.y, -1.0, 1.0));
    const double most = 0.5 * glm::pi<double>() - kPoleRad;
    // A camera that already looks closer to the vertical is not forced away from it.
    const double lo = std::min(-most, elevation), hi = std::max(most, elevation);
    return std::clamp(elevation + pitchRad, lo, hi) - elevation;
}

glm::dquat turnOf(const Camera& camera, double yawRad, double pitchRad) {
    return glm::angleAxis(yawRad, kUp) *
           glm::angleAxis(boundedPitch(camera, pitchRad), camera.right);
}

Camera rotated(Camera camera, const glm::dquat& turn) {
    camera.back = glm::normalize(turn * camera.back);
    const glm::dvec3 up = turn * camera.up;
    camera.up = glm::normalize(up - glm::dot(up, camera.back) * camera.back);
    camera.right = glm::cross(camera.up, camera.back);
    return unclipped(camera);
}

}  // namespace

Camera orbited(const Camera& camera, const glm::dvec3& pivot, double yawRad, double pitchRad) {
    const glm::dquat turn = turnOf(camera, yawRad, pitchRad);
    Camera out = rotated(camera, turn);
    out.position = pivot + turn * (camera.position - pivot);
    return out;
}

Camera turned(const Camera& camera, double yawRad, double pitchRad) {
    return rotated(camera, turnOf(camera, yawRad, pitchRad));
}

Camera moved(const Camera& camera, const glm::dvec3& by) {
    Camera out = unclipped(camera);
    out.position += by.x * camera.right + by.y * camera.up - by.z * camera.back;
    return out;
}

Camera dollied(const Camera& camera, const glm::dvec3& pivot, double factor) {
    Camera out = unclipped(camera);
    out.position = pivot + factor * (camera.position - pivot);
    out.magY *= factor;
    return out;
}

Camera backedOff(const Camera& camera, const glm::dvec3& centre, double radiusM, double aspect) {
    Camera out = unclipped(camera);
    const double narrow = std::min(1.0, aspect);
    if (camera.kind == Camera::Kind::orthographic) {
        out.magY = radiusM / narrow;
        out.position = centre + 2.0 * radiusM * camera.back;
        return out;
    }
    const double half = std::atan(std::tan(0.5 * camera.fovYRad) * narrow);
    out.position = centre + radiusM / std::sin(half) * camera.back;
    return out;
}

std::optional<glm::dvec2> projected(const Camera& camera, const glm::dvec3& point, int width,
                                    int height) {
    const glm::dvec3 v = point - camera.position;
    const double depth = -glm::dot(v, camera.back);
    if (!(depth > 0.0)) return {};
    const double extent = camera.kind == Camera::Kind::orthographic
                              ? camera.magY
                              : depth * std::tan(0.5 * camera.fovYRad);
    const double aspect = static_cast<double>(width) / height;
    return glm::dvec2(0.5 * width * (1.0 + glm::dot(v, camera.right) / (extent * aspect)),
                      0.5 * height * (1.0 - glm::dot(v, camera.up) / extent));
}

double metresPerPixel(const Camera& camera, const glm::dvec3& point, int height) {
    if (camera.kind == Camera::Kind::orthographic) return 2.0 * camera.magY / height;
    const double depth = -glm::dot(point - camera.position, camera.back);
    return std::max(0.0, 2.0 * depth * std::tan(0.5 * camera.fovYRad) / height);
}

}  // namespace penumbra
