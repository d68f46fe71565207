#pragma once

#include <cstddef>
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

/// A median with the interval that the sign test leaves it: the values between the k-th smallest
/// and the k-th greatest, where k is the greatest number such that fewer than k of n fair coins
/// show heads with a chance of at most 2.5 %. It holds the true median in at least 95 % of cases
/// whatever the distribution, and whatever outliers there are (Conover 1999, section 3.2).
struct MedianInterval {
    double median = 0, low = 0, high = 0;
};

/// With fewer values even their whole span covers the median in less than 95 % of cases.
inline constexpr std::size_t kFewestForSignTest = 6;

/// Throws std::invalid_argument for fewer than kFewestForSignTest values.
MedianInterval signTestInterval(std::vector<double> values);

}  // namespace penumbra
