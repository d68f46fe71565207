#pragma once

#include <cstddef>
#include <optional>

#include "core/frame/frame.hpp"

namespace penumbra {

/// Whether the light's centre is seen from pixel `i`, which shows a surface; nothing where the
/// answer changes, or is ill-defined, within `edgeM` sideways as the light sees it. 25 rays, so
/// that a corner within that reach may be missed.
std::optional<bool> centreSeen(const Frame& frame, std::size_t i, double edgeM);

}  // namespace penumbra
