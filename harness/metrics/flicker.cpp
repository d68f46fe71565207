#include "harness/metrics/flicker.hpp"

#include <cmath>

#include "core/scene/geometry.hpp"
#include "harness/metrics/error_sums.hpp"

namespace penumbra {

std::optional<double> flicker(const FlickerFrame& before, const FlickerFrame& now) {
    if (before.gbuffer.width != now.gbuffer.width || before.gbuffer.height != now.gbuffer.height) {
        return std::nullopt;
    }
    Bounds seen;
    for (std::size_t i = 0; i < now.gbuffer.size(); ++i) {
        if (now.gbuffer.mask[i] != PixelClass::background) seen.add(now.gbuffer.position[i]);
    }
    const double toleranceM = kSamePointTolerance * seen.radius();

    ErrorSums changes;
    std::size_t scored = 0, same = 0;
    for (std::size_t i = 0; i < now.gbuffer.size(); ++i) {
        if (now.gbuffer.mask[i] != PixelClass::scored) continue;
        ++scored;
        const glm::dvec3 moved =
            glm::dvec3(now.gbuffer.position[i]) - glm::dvec3(before.gbuffer.position[i]);
        if (before.gbuffer.mask[i] != PixelClass::scored || glm::length(moved) > toleranceM) {
            continue;
        }
        ++same;
        const double change = static_cast<double>(now.visibility[i]) - before.visibility[i];
        const double trueChange =
            static_cast<double>(now.reference.visibility[i]) - before.reference.visibility[i];
        if (std::isfinite(change)) changes.add(change - trueChange);
    }
    if (static_cast<double>(same) < kLeastCorrespondence * static_cast<double>(scored)) {
        return std::nullopt;
    }
    return changes.mean(changes.sumAbs);
}

}  // namespace penumbra
