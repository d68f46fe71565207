#include "harness/metrics/error_sums.hpp"

#include <algorithm>

namespace penumbra {

double percentile99(std::vector<double>& values) {
    const std::size_t rank = (99 * values.size() + 99) / 100;
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

std::optional<double> meanWhere(std::span<const float> values,
                                std::span<const std::uint8_t> counted) {
    ErrorSums sums;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (counted[i]) sums.add(values[i]);
    }
    return sums.mean(sums.sum);
}

}  // namespace penumbra
