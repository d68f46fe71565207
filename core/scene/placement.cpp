#include "core/scene/placement.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace penumbra::scene_detail {
namespace {

const glm::dvec3 kLightDirection = glm::normalize(glm::dvec3(0.45, 1.0, 0.35));
const glm::dvec3 kCameraDirection = glm::normalize(glm::dvec3(0.6, 0.55, 1.0));
constexpr double kParallel = 1e-9;  // sine below which `up` gives no direction

/// The part of `up` across unit `axis`, normalised.
std::optional<glm::dvec3> across(const glm::dvec3& up, const glm::dvec3& axis) {
    const glm::dvec3 part = up - glm::dot(up, axis) * axis;
    if (!(glm::length(part) > kParallel * glm::length(up))) return std::nullopt;
    return glm::normalize(part);
}

std::optional<glm::dvec3> directionTo(const glm::dvec3& from, const glm::dvec3& to) {
    const double distance = glm::distance(from, to);
    if (!(distance > 0.0)) return std::nullopt;
    return (to - from) / distance;
}

}  // namespace

std::optional<AreaLight> lightFacing(const glm::dvec3& position, const glm::dvec3& target,
                                     const std::optional<glm::dvec3>& up, const glm::dvec2& size) {
    const std::optional<glm::dvec3> normal = directionTo(position, target);
    if (!normal) return std::nullopt;
    const bool vertical = std::abs(normal->y) >= 0.5;  // cos 60 degrees
    const std::optional<glm::dvec3> axisV =
        across(up.value_or(vertical ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0)), *normal);
    if (!axisV) return std::nullopt;
    return AreaLight{position, glm::cross(*axisV, *normal), *axisV, 0.5 * size.x, 0.5 * size.y};
}

std::optional<Camera> cameraFacing(const glm::dvec3& position, const glm::dvec3& target,
                                   const std::optional<glm::dvec3>& up, double fovYRad) {
    const std::optional<glm::dvec3> back = directionTo(target, position);
    if (!back) return std::nullopt;
    std::optional<glm::dvec3> upright = across(up.value_or(glm::dvec3(0, 1, 0)), *back);
    if (!upright && !up) upright = across(glm::dvec3(0, 0, -1), *back);
    if (!upright) return std::nullopt;
    Camera camera;
    camera.position = position;
    camera.back = *back;
    camera.up = *upright;
    camera.right = glm::cross(camera.up, camera.back);
    camera.fovYRad = fovYRad;
    return camera;
}

Camera cameraOfNode(const Camera& lens, const glm::dmat4& world) {
    Camera camera = lens;
    camera.position = glm::dvec3(world[3]);
    camera.back = glm::normalize(glm::dvec3(world[2]));
    camera.up = across(glm::dvec3(world[1]), camera.back).value_or(glm::dvec3(0, 1, 0));
    camera.right = glm::cross(camera.up, camera.back);
    return camera;
}

AreaLight lightForBounds(const Bounds& bounds) {
    const double radius = bounds.radius();
    return *lightFacing(bounds.centre() + 3.0 * radius * kLightDirection, bounds.centre(),
                        std::nullopt, glm::dvec2(0.5 * radius));
}

Camera cameraForBounds(const Bounds& bounds) {
    const double fovYRad = glm::radians(40.0);
    const double margin = 1.15;
    const double distance = margin * bounds.radius() / std::sin(0.5 * fovYRad);
    return *cameraFacing(bounds.centre() + distance * kCameraDirection, bounds.centre(),
                         std::nullopt, fovYRad);
}

GroundPlate groundFor(const Bounds& bounds, const AreaLight& light) {
    const double radius = bounds.radius();
    GroundPlate plate{bounds.centre(), 6.0 * radius};
    // Far enough below that a flat underside of the asset does not fight with it for depth.
    plate.centre.y = bounds.lo.y - 1e-3 * radius;
    const auto seenWell = [&](double x, double z) {
        const glm::dvec3 corner = plate.centre + 0.5 * plate.widthM * glm::dvec3(x, 0, z);
        const glm::dvec3 ray = glm::normalize(corner - light.centre);
        return glm::dot(ray, light.normal()) >= 0.5;  // cos 60 degrees
    };
    const double leastWidth = 2.0 * radius;  // never smaller than the asset itself
    while (plate.widthM > leastWidth &&
           !(seenWell(-1, -1) && seenWell(-1, 1) && seenWell(1, -1) && seenWell(1, 1))) {
        plate.widthM = std::max(leastWidth, 0.98 * plate.widthM);
    }
    return plate;
}

AssetPrimitive GroundPlate::primitive(int material) const {
    const float h = static_cast<float>(0.5 * widthM);
    AssetPrimitive plate;
    plate.positions = {{-h, 0, h}, {h, 0, h}, {h, 0, -h}, {-h, 0, -h}};
    plate.normals.assign(4, {0, 1, 0});
    plate.uvs.assign(4, {0, 0});
    plate.indices = {0, 1, 2, 0, 2, 3};
    plate.material = material;
    return plate;
}

void FloorMeter::add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double height = bounds_.hi.y - bounds_.lo.y;
    const double nearBottom = bounds_.lo.y + std::max(0.05 * height, 1e-3 * bounds_.radius());
    if (std::max({a.y, b.y, c.y}) > nearBottom) return;
    const glm::dvec3 doubledArea = glm::cross(b - a, c - a);
    // Within about 18 degrees of horizontal; its footprint is the vertical component.
    if (doubledArea.y > 0.95 * glm::length(doubledArea)) coveredM2_ += 0.5 * doubledArea.y;
}

bool FloorMeter::hasFloor() const {
    const glm::dvec3 extent = bounds_.hi - bounds_.lo;
    return coveredM2_ > 0.0 && coveredM2_ >= 0.5 * extent.x * extent.z;
}

}  // namespace penumbra::scene_detail
