#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "harness/reference/exact_union.hpp"

namespace penumbra {

/// The share of the light's irradiance at `point` that the rest of the light beside `covered`
/// gives. All in light space; `covered` is on the light as the unit square, `normal` the unit
/// geometric normal. The light below the horizon gives nothing.
double uncoveredIrradiance(const std::vector<Strip>& covered, const glm::dvec3& point,
                           const glm::dvec3& normal, const glm::dvec2& halfLight);

}  // namespace penumbra
