#pragma once

#include <optional>
#include <span>

#include "core/frame/gbuffer.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {

/// One frame of a sequence, as flicker() sees it.
struct FlickerFrame {
    const GBuffer& gbuffer;
    const Reference& reference;
    std::span<const float> visibility;
};

/// Two pixels show the same point if their positions differ by less than this share of the scene's
/// radius (half the diagonal of the points seen now): far above the rounding of float positions,
/// far below the distance between neighbouring pixels' points.
constexpr double kSamePointTolerance = 1e-5;

/// Least share of the scored pixels that must show the same point as before. Below it the camera
/// moved, and the few points that stayed (about the axis it moves along) stand for nothing.
constexpr double kLeastCorrespondence = 0.25;

/// Temporal flicker: mean |(V_t - V_t-1) - (R_t - R_t-1)| over pixels that are scored, finite and
/// show the same point in both frames. What the truth changes is no flicker, so light and casters
/// may move. The reference must have used the same samples in both frames, or its noise is in here.
/// Absent where the frames do not correspond.
std::optional<double> flicker(const FlickerFrame& before, const FlickerFrame& now);

}  // namespace penumbra
