#include "core/frame/gbuffer.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {

/// Sine of the angle below which a direction counts as in a plane. Normals and positions are
/// rounded to float, so angles against a plane are known to some 1e-7.
constexpr double kInPlane = 1e-6;

bool above(const glm::dvec3& point, const glm::dvec3& planePoint, const glm::dvec3& planeNormal) {
    const glm::dvec3 offset = point - planePoint;
    return glm::dot(planeNormal, offset) > kInPlane * glm::length(offset);
}

/// The part of a convex polygon above the plane through the origin, by Sutherland and Hodgman.
/// One plane adds at most one corner.
struct Polygon {
    std::array<glm::dvec3, 5> corner;
    int size = 0;
};

Polygon clipToHorizon(const std::array<glm::dvec3, 4>& corners, const glm::dvec3& normal) {
    Polygon clipped;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3& a = corners[i];
        const glm::dvec3& b = corners[(i + 1) % corners.size()];
        const double heightA = glm::dot(normal, a), heightB = glm::dot(normal, b);
        if (heightA >= 0.0) clipped.corner[clipped.size++] = a;
        if ((heightA > 0.0 && heightB < 0.0) || (heightA < 0.0 && heightB > 0.0))
            clipped.corner[clipped.size++] = a + heightA / (heightA - heightB) * (b - a);
    }
    return clipped;
}

}  // namespace

std::size_t GBuffer::count(PixelClass c) const {
    return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), c));
}

std::vector<std::size_t> GBuffer::asked() const {
    std::vector<std::size_t> pixels;
    for (std::size_t i = 0; i < size(); ++i)
        if (isAsked(mask[i])) pixels.push_back(i);
    return pixels;
}

PixelClass classify(const glm::dvec3& position, const glm::dvec3& normal, const AreaLight& light) {
    if (!above(position, light.centre, light.normal())) return PixelClass::facingAway;
    const auto corners = light.corners();  // of a point light: the point, four times
    const auto visible = std::count_if(corners.begin(), corners.end(), [&](const glm::dvec3& q) {
        return above(q, position, normal);
    });
    if (visible == 4) return PixelClass::scored;
    return visible == 0 ? PixelClass::facingAway : PixelClass::horizon;
}

double unshadowedIrradiance(const glm::dvec3& position, const glm::dvec3& normal,
                            const AreaLight& light) {
    const glm::dvec3 toCentre = light.centre - position;
    if (glm::dot(light.normal(), toCentre) >= 0.0) return 0.0;
    const double distance2 = glm::dot(toCentre, toCentre);
    const double extent2 = light.halfU * light.halfU + light.halfV * light.halfV;
    // Below this solid angle the sum over the edges loses as many digits to cancellation as the
    // point formula does to the light's extent: both are good to about 1e-8.
    if (extent2 < 1e-8 * distance2) {
        const double cosP = glm::dot(normal, toCentre), cosL = -glm::dot(light.normal(), toCentre);
        const double perArea = std::max(0.0, cosP) * cosL / (distance2 * distance2);
        return light.isPoint() ? perArea : light.area() * perArea;
    }
    auto corners = light.corners();
    for (glm::dvec3& corner : corners) corner -= position;
    const Polygon seen = clipToHorizon(corners, normal);
    // Lambert (1760): E = 1/2 sum over edges of the angle they subtend times the cosine between the
    // normal and that of the plane through the edge and the point.
    double sum = 0.0;
    for (int i = 0; i < seen.size; ++i) {
        const glm::dvec3& a = seen.corner[i];
        const glm::dvec3& b = seen.corner[(i + 1) % seen.size];
        const glm::dvec3 across = glm::cross(a, b);
        const double sine = glm::length(across);
        if (sine > 0.0) sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(normal, across) / sine;
    }
    // The corners run counter-clockwise seen from the side the light emits to.
    return std::max(0.0, -0.5 * sum);
}

GBuffer renderGBuffer(const Tracer& tracer, const SceneFrame& frame, const Scene& scene, int width,
                      int height) {
    GBuffer out;
    out.width = width;
    out.height = height;
    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    out.position.resize(pixels, glm::vec3(0.0f));
    out.geometricNormal.resize(pixels, glm::vec3(0.0f));
    out.shadingNormal.resize(pixels, glm::vec3(0.0f));
    out.albedo.resize(pixels, glm::vec3(0.0f));
    out.mask.resize(pixels, PixelClass::background);
    out.irradianceUnshadowed.resize(pixels, 0.0f);
    tbb::parallel_for(tbb::blocked_range<int>(0, height), [&](const tbb::blocked_range<int>& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y)
            for (int x = 0; x < width; ++x) {
                const CameraRay ray = cameraRay(frame.camera, x + 0.5, y + 0.5, width, height);
                const SurfaceHit hit =
                    tracer.firstHit(ray.origin, ray.direction, ray.tNear, ray.tFar);
                if (!hit.hit) continue;
                const std::size_t i = static_cast<std::size_t>(y) * width + x;
                out.position[i] = glm::vec3(hit.position);
                out.geometricNormal[i] = hit.geometricNormal;
                out.shadingNormal[i] = hit.shadingNormal;
                out.albedo[i] =
                    glm::vec3(baseColorAt(scene.materials[hit.material], scene.images, hit.uv));
                // From the floats that everyone else will read.
                const glm::dvec3 position(out.position[i]), normal(out.geometricNormal[i]);
                out.mask[i] = classify(position, normal, frame.light);
                if (out.mask[i] != PixelClass::facingAway)
                    out.irradianceUnshadowed[i] =
                        static_cast<float>(unshadowedIrradiance(position, normal, frame.light));
            }
    });
    return out;
}

}  // namespace penumbra
