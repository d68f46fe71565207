#pragma once

#include <string_view>
#include <vector>

#include "core/frame/frame.hpp"
#include "harness/reference/reference.hpp"
#include "harness/run/row.hpp"

namespace penumbra {

/// What separating shading from visibility costs, as rows among those of the methods. A real-time
/// method multiplies the unshadowed irradiance by V; the truth has the visibility inside the light
/// integral. The two agree where V is 0 or 1 or the light is small and far (Eisemann and Decoret
/// 2006, eq. 3), and every method inherits the difference. The row's method, setting and image
/// name; no method may be called so.
inline constexpr std::string_view kSeparation = "separation";

/// Whether `row` judges the separation and no method: it has no times, work or effects.
inline bool isSeparation(const Row& row) {
    return row.method == kSeparation;
}

/// The visibility that times the unshadowed irradiance is the reference's coupled irradiance, to be
/// scored against its V: above V the truth is brighter than the product. Background is 1, facing
/// away 0. NaN where an asked-about point gets no light at all, as in the light's own plane: any
/// factor would do there, and scoring leaves the pixel out and counts it.
std::vector<float> separationImage(const Reference& reference, const GBuffer& gbuffer);

/// The frame's row before scoring.
Row separationRow(const Frame& frame);

}  // namespace penumbra
