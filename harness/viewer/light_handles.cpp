#include "harness/viewer/light_handles.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "harness/viewer/camera_control.hpp"

namespace penumbra {
namespace {

CameraRay rayAt(const HandleView& view, const glm::dvec2& at) {
    return cameraRay(view.camera, at.x, at.y, view.width, view.height);
}

/// How far along the line from `point` in unit `direction` it comes closest to the ray.
std::optional<double> alongLine(const glm::dvec3& point, const glm::dvec3& direction,
                                const CameraRay& ray) {
    const double cosine = glm::dot(direction, ray.direction);
    const double sine2 = 1.0 - cosine * cosine;
    if (sine2 < 1e-6) return {};
    const glm::dvec3 between = point - ray.origin;
    return (cosine * glm::dot(between, ray.direction) - glm::dot(between, direction)) / sine2;
}

std::optional<glm::dvec3> onPlane(const glm::dvec3& point, const glm::dvec3& normal,
                                  const CameraRay& ray) {
    const double slope = glm::dot(normal, ray.direction);
    if (std::abs(slope) < 1e-6) return {};
    const double t = glm::dot(normal, point - ray.origin) / slope;
    if (t <= 0.0) return {};
    return ray.origin + t * ray.direction;
}

/// The sphere's point under the ray, on the side where `near` is; past its rim the rim's.
glm::dvec3 onSphere(const glm::dvec3& centre, double radius, const CameraRay& ray,
                    const glm::dvec3& near) {
    const double along = glm::dot(centre - ray.origin, ray.direction);
    const glm::dvec3 foot = ray.origin + along * ray.direction - centre;
    const double across2 = glm::dot(foot, foot);
    if (across2 >= radius * radius) return glm::normalize(foot) * radius;
    const glm::dvec3 half = std::sqrt(radius * radius - across2) * ray.direction;
    return glm::dot(near, ray.direction) > 0.0 ? foot + half : foot - half;
}

double armM(const AreaLight& light, const HandleView& view) {
    return view.armPixels * metresPerPixel(view.camera, light.centre, view.height);
}

/// In the light's plane, clear of its edges.
glm::dvec3 twistOffset(const AreaLight& light, double arm) {
    return (light.halfU + 0.35 * arm) * light.axisU + (light.halfV + 0.35 * arm) * light.axisV;
}

glm::dvec3 worldAxis(LightHandle handle) {
    return {handle == LightHandle::alongX, handle == LightHandle::alongY,
            handle == LightHandle::alongZ};
}

AreaLight turnedBy(AreaLight light, const glm::dquat& turn) {
    light.axisU = glm::normalize(turn * light.axisU);
    const glm::dvec3 v = turn * light.axisV;
    light.axisV = glm::normalize(v - glm::dot(v, light.axisU) * light.axisU);
    return light;
}

}  // namespace

std::vector<HandlePoint> lightHandles(const AreaLight& light, const HandleView& view) {
    const double arm = armM(light, view);
    if (!(arm > 0.0)) return {};
    std::vector<HandlePoint> handles{{LightHandle::centre, light.centre}};
    for (const LightHandle h : {LightHandle::alongX, LightHandle::alongY, LightHandle::alongZ})
        handles.push_back({h, light.centre + arm * worldAxis(h)});
    handles.push_back({LightHandle::aim, light.centre + 1.3 * arm * light.normal()});
    handles.push_back({LightHandle::twist, light.centre + twistOffset(light, arm)});
    for (const double side : {1.0, -1.0}) {
        handles.push_back({LightHandle::widerU, light.centre + side * light.halfU * light.axisU});
        handles.push_back({LightHandle::widerV, light.centre + side * light.halfV * light.axisV});
    }
    // Those of a point light's sides lie on its centre, which shall be had.
    if (light.isPoint()) handles.resize(handles.size() - 4);
    return handles;
}

LightHandle pickHandle(const std::vector<HandlePoint>& handles, const HandleView& view,
                       const glm::dvec2& at, double reachPixels) {
    LightHandle best = LightHandle::none;
    double least = reachPixels;
    for (const HandlePoint& handle : handles) {
        const auto seen = projected(view.camera, handle.at, view.width, view.height);
        if (!seen) continue;
        const double distance = glm::distance(*seen, at);
        if (distance > least) continue;
        least = distance;
        best = handle.handle;
    }
    return best;
}

AreaLight facing(const AreaLight& light, const glm::dvec3& normal) {
    const glm::dvec3 before = light.normal();
    const double cosine = glm::dot(before, normal);
    if (cosine < -1.0 + 1e-9)
        return turnedBy(light, glm::angleAxis(glm::pi<double>(), light.axisU));
    return turnedBy(light, glm::normalize(glm::dquat(1.0 + cosine, glm::cross(before, normal))));
}

AreaLight draggedLight(const AreaLight& start, LightHandle handle, const HandleView& view,
                       const glm::dvec2& from, const glm::dvec2& to) {
    const CameraRay first = rayAt(view, from), now = rayAt(view, to);
    AreaLight light = start;
    switch (handle) {
        case LightHandle::none:
            break;
        case LightHandle::centre: {
            const auto a = onPlane(start.centre, view.camera.back, first);
            const auto b = onPlane(start.centre, view.camera.back, now);
            if (a && b) light.centre += *b - *a;
            break;
        }
        case LightHandle::alongX:
        case LightHandle::alongY:
        case LightHandle::alongZ: {
            const glm::dvec3 axis = worldAxis(handle);
            const auto a = alongLine(start.centre, axis, first);
            const auto b = alongLine(start.centre, axis, now);
            if (a && b) light.centre += (*b - *a) * axis;
            break;
        }
        case LightHandle::aim: {
            const double radius = 1.3 * armM(start, view);
            const glm::dvec3 a = onSphere(start.centre, radius, first, start.normal());
            const glm::dvec3 b = onSphere(start.centre, radius, now, start.normal());
            // What turns the point taken hold of into the one under the hand turns the light.
            const glm::dvec3 across = glm::cross(a, b);
            const double sine = glm::length(across) / (radius * radius);
            if (sine < 1e-12) break;
            light =
                turnedBy(start, glm::angleAxis(std::atan2(sine, glm::dot(a, b) / (radius * radius)),
                                               glm::normalize(across)));
            break;
        }
        case LightHandle::twist: {
            const glm::dvec3 normal = start.normal();
            const auto a = onPlane(start.centre, normal, first);
            const auto b = onPlane(start.centre, normal, now);
            if (!a || !b) break;
            const glm::dvec3 p = *a - start.centre, q = *b - start.centre;
            const double angle = std::atan2(glm::dot(glm::cross(p, q), normal), glm::dot(p, q));
            light = turnedBy(start, glm::angleAxis(angle, normal));
            break;
        }
        case LightHandle::widerU:
        case LightHandle::widerV: {
            const bool u = handle == LightHandle::widerU;
            const glm::dvec3& axis = u ? start.axisU : start.axisV;
            const double half = u ? start.halfU : start.halfV;
            const auto a = alongLine(start.centre, axis, first);
            const auto b = alongLine(start.centre, axis, now);
            if (!a || !b) break;
            // The side that was taken follows the hand, the other goes the other way.
            const double side = *a < 0.0 ? -1.0 : 1.0;
            (u ? light.halfU : light.halfV) =
                std::max(kLeastShrink * half, half + side * (*b - *a));
            break;
        }
    }
    return light;
}

}  // namespace penumbra
