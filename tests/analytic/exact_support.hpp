#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>
#include <random>
#include <vector>

#include "harness/reference/exact.hpp"
#include "tests/support/procedural.hpp"

namespace penumbra::test {

/// Surface points without a surface: one row of pixels.
inline GBuffer pointGBuffer(const std::vector<glm::dvec3>& points, const glm::dvec3& normal,
                            const AreaLight& light) {
    GBuffer out;
    out.width = static_cast<int>(points.size());
    out.height = 1;
    for (const glm::dvec3& point : points) {
        const glm::vec3 p(point), n(normal);
        out.position.push_back(p);
        out.geometricNormal.push_back(n);
        out.shadingNormal.push_back(n);
        out.albedo.push_back(glm::vec3(0.5f));
        out.mask.push_back(classify(glm::dvec3(p), glm::dvec3(n), light));
        out.irradianceUnshadowed.push_back(
            static_cast<float>(unshadowedIrradiance(glm::dvec3(p), glm::dvec3(n), light)));
    }
    return out;
}

inline Reference exactOf(const Shape& shape, const GBuffer& gbuffer, const AreaLight& light,
                         const ExactOptions& options = {}, ExactStats* stats = nullptr) {
    const Tracer tracer(shape.geometry(), kOpaque, kNoImages);
    return exactReference(tracer, kOpaque, gbuffer, light, options, {}, stats);
}

/// What one point with its normal along z sees.
inline double exactAt(const Shape& shape, const glm::dvec3& point, const AreaLight& light) {
    const Reference exact = exactOf(shape, pointGBuffer({point}, {0, 0, 1}, light), light);
    EXPECT_EQ(exact.rays[0], 0.0f) << "too many edges to be exact";
    return exact.visibility[0];
}

/// A rotation about `axis`, which need not be unit.
inline glm::dmat3 turn(const glm::dvec3& axis, double angleRad) {
    const glm::dvec3 k = glm::normalize(axis);
    const double c = std::cos(angleRad), s = std::sin(angleRad);
    glm::dmat3 m;
    for (int column = 0; column < 3; ++column) {
        glm::dvec3 e(0.0);
        e[column] = 1.0;
        m[column] = c * e + s * glm::cross(k, e) + (1.0 - c) * glm::dot(k, e) * k;
    }
    return m;
}

inline AreaLight turned(AreaLight light, const glm::dmat3& rotation) {
    light.centre = rotation * light.centre;
    light.axisU = rotation * light.axisU;
    light.axisV = rotation * light.axisV;
    return light;
}

/// A triangle's.
struct Corners {
    glm::dvec3 a, b, c;
};

/// Triangles of all sizes and directions between the plane z = 0 and the light at z = 4, some of
/// them through either.
inline std::vector<Corners> soup(int count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto vector = [&] {
        const double x = unit(random), y = unit(random), z = unit(random);
        return glm::dvec3(x, y, z);
    };
    std::vector<Corners> triangles;
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 centre = glm::dvec3(0, 0, 2.2) + vector() * glm::dvec3(1.2, 1.2, 2.2);
        const double size = 0.6 * std::abs(unit(random));
        triangles.push_back(
            {centre + size * vector(), centre + size * vector(), centre + size * vector()});
    }
    return triangles;
}

inline Shape shapeOf(const std::vector<Corners>& triangles) {
    Shape shape;
    for (const Corners& t : triangles) shape.triangle(t.a, t.b, t.c);
    return shape;
}

inline GBuffer floorPoints(int size, const AreaLight& light) {
    return planeGBuffer(size, size, {-1.5, -1.5, 0}, {3, 0, 0}, {0, 3, 0}, light);
}

}  // namespace penumbra::test
