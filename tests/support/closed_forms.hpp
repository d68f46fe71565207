#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <vector>

#include "core/scene/area_light.hpp"

/// Visibilities known in closed form (METHODS.md R2), in doubles and without sampling.
/// Where a set-up is needed it is R2's: receiver z = 0, occluders in z = h, the light in z = H.
namespace penumbra::closed_form {

/// An axis-parallel rectangle in a plane of constant z.
struct Rect {
    glm::dvec2 lo, hi;
    double area() const {
        const glm::dvec2 size = glm::max(hi - lo, glm::dvec2(0.0));
        return size.x * size.y;
    }
};

inline Rect intersection(const Rect& a, const Rect& b) {
    return {glm::max(a.lo, b.lo), glm::min(a.hi, b.hi)};
}

/// The occluder as it lies on the light seen from (p, 0): q = p + (o - p) m, m = H/h.
inline Rect projected(const Rect& occluder, glm::dvec2 p, double h, double H) {
    return {p + (occluder.lo - p) * (H / h), p + (occluder.hi - p) * (H / h)};
}

/// R2.1: a rectangle over a rectangular light.
inline double rectangle(glm::dvec2 p, const Rect& occluder, double h, const Rect& light, double H) {
    return 1.0 - intersection(projected(occluder, p, h, H), light).area() / light.area();
}

/// R2.2: the half-plane x > e over a light from -w/2 to w/2 in x.
inline double halfPlane(double x, double e, double h, double w, double H) {
    const double x0 = e * H / (H - h), penumbraWidth = w * h / (H - h);
    return std::clamp(0.5 - (x - x0) / penumbraWidth, 0.0, 1.0);
}

/// R2.3: the part of a disc of radius R on the side of x <= edge, its centre at x = 0: a share of
/// its area.
inline double discBeside(double edge, double R) {
    const double a = std::clamp(edge / R, -1.0, 1.0);
    return 0.5 + (a * std::sqrt(1.0 - a * a) + std::asin(a)) / std::numbers::pi;
}

/// R2.4: any straight edge, any receiver: the share of the light on the side of `openSide` of the
/// plane through p and the edge's line a b.
inline double straightEdge(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                           const glm::dvec3& openSide, const AreaLight& light) {
    glm::dvec3 normal = glm::cross(a - p, b - p);
    if (glm::dot(normal, openSide - p) < 0.0) normal = -normal;
    std::vector<glm::dvec2> polygon;  // in (s, t) of the light, clipped by Sutherland and Hodgman
    const glm::dvec2 corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const auto height = [&](glm::dvec2 q) { return glm::dot(normal, light.at(q.x, q.y) - p); };
    for (int i = 0; i < 4; ++i) {
        const glm::dvec2 from = corners[i], to = corners[(i + 1) % 4];
        const double h0 = height(from), h1 = height(to);
        if (h0 >= 0.0) polygon.push_back(from);
        if ((h0 > 0.0 && h1 < 0.0) || (h0 < 0.0 && h1 > 0.0))
            polygon.push_back(from + h0 / (h0 - h1) * (to - from));
    }
    double doubled = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 u = polygon[i], v = polygon[(i + 1) % polygon.size()];
        doubled += u.x * v.y - u.y * v.x;
    }
    return 0.5 * doubled;
}

/// R2.6: the area that two discs of radii r and R have in common, their centres D apart.
inline double lens(double D, double r, double R) {
    if (D >= r + R) return 0.0;
    const double least = std::min(r, R);
    if (D <= std::abs(R - r)) return std::numbers::pi * least * least;
    // The segment of one disc beyond the chord, from half its angle's sine: near a tangency a
    // cosine beside 1 has lost the angle's digits.
    const auto segment = [&](double a, double b) {
        const double square = (a + b - D) * (D + (b - a)) / (4 * D * a);
        const double angle = 2 * std::asin(std::sqrt(std::clamp(square, 0.0, 1.0)));
        return a * a * (angle - 0.5 * std::sin(2 * angle));
    };
    return segment(r, R) + segment(R, r);
}

/// R2.7: a sphere before a rectangular light: chords of the ellipse, clipped to the light, at
/// `nodes` places.
inline double besideSphere(const glm::dvec3& p, const glm::dvec3& centre, double radius,
                           const AreaLight& light, int nodes) {
    const glm::dvec3 A = centre - p;
    const double H = light.centre.z - p.z, k = glm::dot(A, A) - radius * radius;
    double hidden = 0.0;
    for (int i = 0; i < nodes; ++i) {
        const double X = (2.0 * (i + 0.5) / nodes - 1.0) * light.halfU - p.x;
        // (aX + bY + hH)^2 >= k (X^2 + Y^2 + H^2), a quadratic in Y.
        const double c0 = A.x * X + A.z * H;
        const double q2 = k - A.y * A.y, q1 = -2.0 * A.y * c0, q0 = k * (X * X + H * H) - c0 * c0;
        const double radicand = q1 * q1 - 4.0 * q2 * q0;
        if (radicand <= 0.0) continue;
        const double low = (-q1 - std::sqrt(radicand)) / (2.0 * q2) + p.y,
                     high = (-q1 + std::sqrt(radicand)) / (2.0 * q2) + p.y;
        hidden += std::max(0.0, std::min(high, light.halfV) - std::max(low, -light.halfV));
    }
    return 1.0 - hidden / nodes / (2.0 * light.halfV);
}

/// R2.8 and R2.9: two rectangles at the heights ha and hb, overlapping or not: the union by
/// inclusion and exclusion.
inline double twoRectangles(glm::dvec2 p, const Rect& a, double ha, const Rect& b, double hb,
                            const Rect& light, double H) {
    const Rect onLightA = intersection(projected(a, p, ha, H), light);
    const Rect onLightB = intersection(projected(b, p, hb, H), light);
    const double covered =
        onLightA.area() + onLightB.area() - intersection(onLightA, onLightB).area();
    return 1.0 - covered / light.area();
}

}  // namespace penumbra::closed_form
