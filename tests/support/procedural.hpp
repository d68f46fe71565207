#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "core/scene/area_light.hpp"
#include "core/scene/geometry.hpp"
#include "core/scene/material.hpp"
#include "core/scene/shape.hpp"

namespace penumbra::test {

using penumbra::Shape;

/// One opaque material, no images: what most tests trace against.
inline const std::vector<Material> kOpaque(1);
inline const std::vector<TextureImage> kNoImages;

/// A light in the plane z = height that shines down, its sides along x and y.
inline AreaLight lightAbove(double height, double width, double length) {
    AreaLight light;
    light.centre = {0.0, 0.0, height};
    light.axisU = {1, 0, 0};
    light.axisV = {0, -1, 0};
    light.halfU = 0.5 * width;
    light.halfV = 0.5 * length;
    return light;
}

/// Points origin + (x + 1/2)/width edgeU + (y + 1/2)/height edgeV with the normal edgeU x edgeV,
/// classified and with their unshadowed irradiance.
inline GBuffer planeGBuffer(int width, int height, const glm::dvec3& origin,
                            const glm::dvec3& edgeU, const glm::dvec3& edgeV,
                            const AreaLight& light) {
    GBuffer out;
    out.width = width;
    out.height = height;
    const glm::vec3 normal(glm::normalize(glm::cross(edgeU, edgeV)));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::vec3 p(origin + edgeU * ((x + 0.5) / width) + edgeV * ((y + 0.5) / height));
            out.position.push_back(p);
            out.geometricNormal.push_back(normal);
            out.shadingNormal.push_back(normal);
            out.albedo.push_back(glm::vec3(0.5f));
            out.mask.push_back(classify(glm::dvec3(p), glm::dvec3(normal), light));
            out.irradianceUnshadowed.push_back(
                static_cast<float>(unshadowedIrradiance(glm::dvec3(p), glm::dvec3(normal), light)));
        }
    return out;
}

}  // namespace penumbra::test
