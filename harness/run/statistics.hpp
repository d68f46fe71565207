#pragma once

#include <cstdint>
#include <vector>

namespace penumbra {

/// Repeated timings of one thing, in milliseconds.
struct TimingSummary {
    double median = 0, mad = 0;  ///< mad: median absolute deviation
    double low = 0, high = 0;    ///< 95 % bootstrap percentile interval of the median
    bool unstable = false;       ///< the interval is wider than a fifth of the median
};

double median(std::vector<double> values);

/// `values` must not be empty. 2,000 resamples, seeded: the same values give the same interval.
TimingSummary summarise(const std::vector<double>& values, std::uint32_t seed);

}  // namespace penumbra
