#pragma once

#include <array>
#include <glm/glm.hpp>

namespace penumbra {

/// A rectangle that emits from one side with unit radiance. Points are relative to Scene::origin.
/// halfU and halfV are orthogonal; the light emits towards normal() = axisU x axisV. Both half
/// lengths may be 0 (a point light), the axes and the normal stay defined.
struct AreaLight {
    glm::dvec3 centre{0.0};
    glm::dvec3 axisU{1, 0, 0};  ///< unit
    glm::dvec3 axisV{0, 0, 1};  ///< unit, orthogonal to axisU
    double halfU = 0.0;         ///< metres
    double halfV = 0.0;         ///< metres

    glm::dvec3 normal() const { return glm::cross(axisU, axisV); }
    double area() const { return 4.0 * halfU * halfV; }
    bool isPoint() const { return halfU == 0.0 && halfV == 0.0; }
    /// Point of the light at (s, t) in [0,1]^2, (1/2, 1/2) being the centre.
    glm::dvec3 at(double s, double t) const {
        return centre + (2 * s - 1) * halfU * axisU + (2 * t - 1) * halfV * axisV;
    }
    std::array<glm::dvec3, 4> corners() const { return {at(0, 0), at(1, 0), at(1, 1), at(0, 1)}; }
    bool operator==(const AreaLight&) const = default;
};

}  // namespace penumbra
