#include "harness/reference/exact_irradiance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace penumbra {

namespace {

/// Twice the irradiance through the triangle of the point (the origin), `a` and `b`: Lambert
/// (1760), the angle between a and b times the cosine between the normal and that of their plane.
double edgeTerm(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& normal) {
    const glm::dvec3 across = glm::cross(a, b);
    const double sine = glm::length(across);
    return sine > 0.0 ? std::atan2(sine, glm::dot(a, b)) * glm::dot(normal, across) / sine : 0.0;
}

/// Irradiance from a piece of the light, corners counter-clockwise in (x, y).
double irradiance(const std::array<glm::dvec3, 4>& corners, const glm::dvec3& normal) {
    std::array<glm::dvec3, 5> above;
    std::size_t count = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3& a = corners[i];
        const glm::dvec3& b = corners[(i + 1) % corners.size()];
        const double heightA = glm::dot(normal, a), heightB = glm::dot(normal, b);
        if (heightA >= 0.0) above[count++] = a;
        if ((heightA > 0.0 && heightB < 0.0) || (heightA < 0.0 && heightB > 0.0))
            above[count++] = a + heightA / (heightA - heightB) * (b - a);
    }
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i)
        sum += edgeTerm(above[i], above[(i + 1) % count], normal);
    // Seen from the point the corners run clockwise.
    return -0.5 * sum;
}

}  // namespace

double uncoveredIrradiance(const std::vector<Strip>& covered, const glm::dvec3& point,
                           const glm::dvec3& normal, const glm::dvec2& halfLight) {
    const auto corner = [&](double x, double y) {
        return glm::dvec3((2.0 * x - 1.0) * halfLight.x, (2.0 * y - 1.0) * halfLight.y, 0.0) -
               point;
    };
    const auto of = [&](const Strip& strip) {
        return strip.sign * irradiance({corner(0.0, strip.y0), corner(strip.x0, strip.y0),
                                        corner(strip.x1, strip.y1), corner(0.0, strip.y1)},
                                       normal);
    };
    const double whole = of({0.0, 1.0, 1.0, 1.0, 1});
    if (!(whole > 0.0)) return 1.0;
    double hidden = 0.0;
    for (const Strip& strip : covered)
        if (strip.x0 > 0.0 || strip.x1 > 0.0) hidden += of(strip);
    return std::clamp(1.0 - hidden / whole, 0.0, 1.0);
}

}  // namespace penumbra
