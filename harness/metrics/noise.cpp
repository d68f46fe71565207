#include "harness/metrics/noise.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "harness/metrics/error_sums.hpp"

namespace penumbra {

std::optional<double> noise(std::span<const float> visibility, const Reference& reference,
                            const GBuffer& gbuffer, std::span<const LightClass> classes) {
    constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();
    const int width = gbuffer.width, height = gbuffer.height;
    const auto index = [width](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    };
    std::vector<double> errors(gbuffer.size(), kAbsent);
    for (std::size_t i = 0; i < errors.size(); ++i) {
        if (gbuffer.mask[i] == PixelClass::scored && std::isfinite(visibility[i])) {
            errors[i] = static_cast<double>(visibility[i]) - reference.visibility[i];
        }
    }

    std::vector<ErrorSums> rows(static_cast<std::size_t>(height));
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t i = index(x, y);
            if (classes[i] != LightClass::penumbra || std::isnan(errors[i])) continue;
            double sum = 0;
            int count = 0;
            for (int v = std::max(0, y - kNoiseRadius); v <= std::min(height - 1, y + kNoiseRadius);
                 ++v) {
                for (int u = std::max(0, x - kNoiseRadius);
                     u <= std::min(width - 1, x + kNoiseRadius); ++u) {
                    const double error = errors[index(u, v)];
                    if (std::isnan(error)) continue;
                    sum += error;
                    ++count;
                }
            }
            if (count > 1) rows[static_cast<std::size_t>(y)].add(errors[i] - sum / count);
        }
    });
    ErrorSums all;
    for (const ErrorSums& row : rows) {  // in order: the same sum for any number of threads
        all.sumSquares += row.sumSquares;
        all.count += row.count;
    }
    return all.rms();
}

}  // namespace penumbra
