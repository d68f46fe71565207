#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <memory>
#include <numbers>

#include "core/scene/geometry.hpp"

namespace penumbra {

/// Geometry put together in doubles; vertices are rounded to float as an asset's are.
class Shape {
  public:
    void triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        const glm::vec3 normal = normalOf(a, b, c);
        for (const glm::dvec3& p : {a, b, c}) vertex(glm::vec3(p), normal, glm::vec2(0.0f));
    }
    /// Corners in order; texture coordinates (0,0), (1,0), (1,1), (0,1).
    void quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
        const glm::vec3 normal = normalOf(a, b, c);
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
    /// Any unit vector where the three lie on a line.
    static glm::vec3 normalOf(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        const glm::dvec3 across = glm::cross(b - a, c - a);
        const double length = glm::length(across);
        return length > 0.0 ? glm::vec3(across / length) : glm::vec3(0.0f, 1.0f, 0.0f);
    }
    void vertex(const glm::vec3& p, const glm::vec3& normal, glm::vec2 uv) {
        geometry_.indices.push_back(static_cast<std::uint32_t>(geometry_.positions.size()));
        geometry_.positions.push_back(p);
        geometry_.normals.push_back(normal);
        geometry_.uvs.push_back(uv);
    }
    Geometry geometry_;
};

}  // namespace penumbra
