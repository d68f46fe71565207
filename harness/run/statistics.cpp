#include "harness/run/statistics.hpp"

#include <algorithm>
#include <cmath>

#include "core/sampling/sampling.hpp"

namespace penumbra {

double median(std::vector<double> values) {
    std::ranges::sort(values);
    const std::size_t n = values.size();
    return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

TimingSummary summarise(const std::vector<double>& values, std::uint32_t seed) {
    constexpr std::uint32_t kResamples = 2000;
    TimingSummary summary;
    summary.median = median(values);
    std::vector<double> deviations;
    for (double v : values) deviations.push_back(std::abs(v - summary.median));
    summary.mad = median(deviations);

    std::vector<double> medians(kResamples), resample(values.size());
    for (std::uint32_t b = 0; b < kResamples; ++b) {
        for (std::uint32_t i = 0; i < resample.size(); ++i)
            resample[i] = values[hash(b, i, seed) % values.size()];
        medians[b] = median(resample);
    }
    std::ranges::sort(medians);
    summary.low = medians[kResamples * 25 / 1000];
    summary.high = medians[kResamples * 975 / 1000 - 1];
    summary.unstable = summary.high - summary.low > 0.2 * summary.median;
    return summary;
}

}  // namespace penumbra
