#include "harness/gate/reference_noise.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace penumbra::gate {

ReferenceNoise ReferenceNoise::of(const Row& row, std::size_t penumbraPixels) {
    return {row.metrics.referenceSe.value_or(0.0), row.metrics.scoredPixels, penumbraPixels};
}

double standardErrorOf(Noise kind, const ReferenceNoise& noise) {
    const auto count = [](std::size_t pixels) {
        return static_cast<double>(std::max<std::size_t>(pixels, 1));
    };
    const double s = noise.standardError;
    switch (kind) {
        case Noise::none:
            return 0.0;
        case Noise::meanOfAll:
            return s / std::sqrt(count(noise.scoredPixels));
        case Noise::meanOfPenumbra:
            return s / std::sqrt(count(noise.penumbraPixels));
        case Noise::onePixel:
            return s;
        case Noise::worstPixel:
            return s * std::sqrt(2.0 * std::log(std::max(count(noise.scoredPixels), 2.0)));
    }
    throw std::logic_error("no such kind of noise");
}

double explainedByNoise(Noise kind, double before, const ReferenceNoise& baseline,
                        const ReferenceNoise& run) {
    if (kind == Noise::none) return 0.0;
    const double sa = baseline.standardError, sb = run.standardError;
    const double ofDifference =
        std::hypot(standardErrorOf(kind, baseline), standardErrorOf(kind, run));
    const double ofFloor =
        std::sqrt(before * before + std::abs(sa * sa - sb * sb)) - std::abs(before);
    return kSigmas * ofDifference + ofFloor;
}

}  // namespace penumbra::gate
