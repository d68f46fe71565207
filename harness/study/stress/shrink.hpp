#pragma once

#include <functional>

#include "harness/study/stress/random_draw.hpp"

namespace penumbra::stress {

/// A simpler draw for which `fails` still holds: fewer bodies and assignments, no placement, a
/// smaller image, numbers of fewer digits. Tries at most `attempts` draws. `fails(draw)` holds.
Draw shrink(Draw draw, const std::function<bool(const Draw&)>& fails, int attempts = 300);

}  // namespace penumbra::stress
