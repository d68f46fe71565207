#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/trace/tracer.hpp"

namespace penumbra {

/// What a pixel shows, as the `mask` channel of gbuffer.exr.
enum class PixelClass : std::uint8_t {
    background = 0,
    scored = 1,      ///< a surface with the whole light above its geometric tangent plane
    horizon = 2,     ///< part of the light is below its tangent plane
    facingAway = 3,  ///< none of the light is above its tangent plane, or it lies behind the light
};

/// Whether methods and the reference answer for such a pixel: part of the light may be seen.
constexpr bool isAsked(PixelClass c) {
    return c == PixelClass::scored || c == PixelClass::horizon;
}

/// The points that everyone answers for: reference, methods, metrics. Row-major, top row first,
/// width * height entries each.
struct GBuffer {
    int width = 0, height = 0;
    std::vector<glm::vec3> position;         ///< metres relative to Scene::origin
    std::vector<glm::vec3> geometricNormal;  ///< unit, on the camera's side
    std::vector<glm::vec3> shadingNormal;    ///< unit, on the geometric normal's side
    std::vector<glm::vec3> albedo;           ///< linear RGB
    std::vector<PixelClass> mask;
    std::vector<float>
        irradianceUnshadowed;  ///< analytic, unit radiance, geometric normal (W/m^2 per W/m^2/sr)

    std::size_t size() const { return mask.size(); }
    std::size_t count(PixelClass c) const;
    /// Pixels for which methods and the reference answer, in order.
    std::vector<std::size_t> asked() const;
};

/// Traces the pixel centres' camera rays and classifies each point against the light. Parallel.
GBuffer renderGBuffer(const Tracer& tracer, const SceneFrame& frame, const Scene& scene, int width,
                      int height);

/// The class of a surface point: corners of the light against its tangent plane, the point against
/// the light's plane.
PixelClass classify(const glm::dvec3& position, const glm::dvec3& normal, const AreaLight& light);

/// Irradiance at `position` with unit `normal` from the whole unoccluded light of unit radiance:
/// Lambert's formula over the rectangle clipped to the horizon; for a point light the limit
/// cos cos / r^2 per unit area. 0 behind the light.
double unshadowedIrradiance(const glm::dvec3& position, const glm::dvec3& normal,
                            const AreaLight& light);

}  // namespace penumbra
