#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <memory>
#include <numbers>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "core/scene/area_light.hpp"
#include "core/scene/geometry.hpp"
#include "core/scene/material.hpp"

namespace penumbra::test {

/// Geometry put together in doubles; vertices are rounded to float as an asset's are.
class Shape {
  public:
    void triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        const glm::vec3 normal(glm::normalize(glm::cross(b - a, c - a)));
        for (const glm::dvec3& p : {a, b, c}) vertex(glm::vec3(p), normal, glm::vec2(0.0f));
    }
    /// Corners in order; texture coordinates (0,0), (1,0), (1,1), (0,1).
    void quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
        const glm::vec3 normal(glm::normalize(glm::cross(b - a, c - a)));
        const glm::dvec3* corner[] = {&a, &b, &c, &a, &c, &d};
        const glm::vec2 uv[] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
        for (int i = 0; i < 6; ++i) vertex(glm::vec3(*corner[i]), normal, uv[i]);
    }
    void rectangle(glm::dvec2 lo, glm::dvec2 hi, double z) {
        quad({lo.x, lo.y, z}, {hi.x, lo.y, z}, {hi.x, hi.y, z}, {lo.x, hi.y, z});
    }
    void box(const glm::dvec3& lo, const glm::dvec3& hi) {
        const auto at = [&](int x, int y, int z) {
            return glm::dvec3(x ? hi.x : lo.x, y ? hi.y : lo.y, z ? hi.z : lo.z);
        };
        quad(at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0));
        quad(at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1));
        quad(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
        quad(at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0));
        quad(at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0));
        quad(at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1));
    }
    void sphere(const glm::dvec3& centre, double radius, int rings) {
        const auto at = [&](int i, int j) {
            const double theta = std::numbers::pi * i / rings, phi = std::numbers::pi * j / rings;
            return centre + radius * glm::dvec3(std::sin(theta) * std::cos(phi),
                                                std::sin(theta) * std::sin(phi), std::cos(theta));
        };
        for (int i = 0; i < rings; ++i)
            for (int j = 0; j < 2 * rings; ++j) {
                if (i > 0) triangle(at(i, j), at(i + 1, j), at(i, j + 1));
                if (i + 1 < rings) triangle(at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
            }
    }
    /// n x n quads over origin + [0,1] edgeU + [0,1] edgeV.
    void grid(const glm::dvec3& origin, const glm::dvec3& edgeU, const glm::dvec3& edgeV, int n) {
        const auto at = [&](int i, int j) {
            return origin + edgeU * (static_cast<double>(i) / n) +
                   edgeV * (static_cast<double>(j) / n);
        };
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1));
                triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
            }
    }
    /// One part with material 0.
    std::shared_ptr<const Geometry> geometry() const {
        auto result = std::make_shared<Geometry>(geometry_);
        Part part;
        part.vertexCount = static_cast<std::uint32_t>(result->positions.size());
        part.indexCount = static_cast<std::uint32_t>(result->indices.size());
        result->parts = {part};
        return result;
    }

  private:
    void vertex(const glm::vec3& p, const glm::vec3& normal, glm::vec2 uv) {
        geometry_.indices.push_back(static_cast<std::uint32_t>(geometry_.positions.size()));
        geometry_.positions.push_back(p);
        geometry_.normals.push_back(normal);
        geometry_.uvs.push_back(uv);
    }
    Geometry geometry_;
};

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
