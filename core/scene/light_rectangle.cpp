#include "core/scene/light_rectangle.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

constexpr double kTolerance = 1e-4;  // of the rectangle's size: exporters write float corners

using Corners = std::array<glm::dvec3, 4>;

/// The outline of two triangles that share an edge, in the winding of the first and starting at
/// its first corner.
std::optional<Corners> outlineOf(const std::array<glm::dvec3, 6>& p) {
    double size = 0.0;
    for (const glm::dvec3& q : p) size = std::max(size, glm::distance(p[0], q));
    const auto same = [&](int i, int j) { return glm::distance(p[i], p[j]) <= kTolerance * size; };
    for (int a = 0; a < 3; ++a) {  // the first triangle's edge a -> b ...
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        for (int d = 3; d < 6; ++d) {  // ... must be walked backwards in the second: b, a, then f
            const int e = 3 + (d - 2) % 3, f = 3 + (d - 1) % 3;
            if (!same(b, d) || !same(a, e) || same(c, f)) continue;
            std::array<int, 4> outline = {a, f, b, c};
            std::rotate(outline.begin(), std::find(outline.begin(), outline.end(), 0),
                        outline.end());
            return Corners{p[outline[0]], p[outline[1]], p[outline[2]], p[outline[3]]};
        }
    }
    return std::nullopt;
}

bool isRectangle(const Corners& c) {
    const glm::dvec3 u = c[1] - c[0], v = c[3] - c[0];
    const double lengthU = glm::length(u), lengthV = glm::length(v);
    const double shorter = std::min(lengthU, lengthV);
    return shorter > 0.0 && lengthU + lengthV < kMaxExtentM &&
           glm::length(c[0] + c[2] - c[1] - c[3]) <= kTolerance * shorter &&
           std::abs(glm::dot(u, v)) <= kTolerance * lengthU * lengthV;
}

}  // namespace

std::optional<LocalRectangle> rectangleOf(const AssetPrimitive& primitive,
                                          const glm::dmat4& world) {
    if (primitive.indices.size() != 6) return std::nullopt;
    std::array<glm::dvec3, 6> local{};
    for (int i = 0; i < 6; ++i) local[i] = glm::dvec3(primitive.positions[primitive.indices[i]]);
    const std::optional<Corners> outline = outlineOf(local);
    if (!outline) return std::nullopt;
    Corners placed = *outline;
    for (glm::dvec3& corner : placed) corner = glm::dmat3(world) * corner;
    if (!isRectangle(placed)) return std::nullopt;
    return LocalRectangle{(*outline)[0], (*outline)[1] - (*outline)[0],
                          (*outline)[3] - (*outline)[0]};
}

AreaLight LocalRectangle::placedBy(const glm::dmat4& world) const {
    const glm::dmat3 linear(world);
    const glm::dvec3 u = linear * edgeU, v = linear * edgeV;
    const double lengthU = glm::length(u), lengthV = glm::length(v);
    AreaLight light;
    light.centre = glm::dvec3(world * glm::dvec4(corner + 0.5 * (edgeU + edgeV), 1.0));
    light.halfU = 0.5 * lengthU;
    light.halfV = 0.5 * lengthV;
    light.axisU = u / lengthU;
    // Right angles hold up to the tolerance only; the axes must be exactly orthogonal.
    const double mirror = glm::determinant(linear) < 0.0 ? -1.0 : 1.0;
    light.axisV = mirror * glm::normalize(v - glm::dot(v, light.axisU) * light.axisU);
    return light;
}

}  // namespace penumbra::scene_detail
