#include "harness/run/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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

MedianInterval signTestInterval(std::vector<double> values) {
    const std::size_t n = values.size();
    if (n < kFewestForSignTest)
        throw std::invalid_argument("a 95 % interval of a median needs at least 6 values");
    std::ranges::sort(values);
    // P(heads = i) by its logarithm: 2^-n alone underflows beyond a thousand values.
    double logChance = -static_cast<double>(n) * std::log(2.0), tail = std::exp(logChance);
    std::size_t k = 0;
    while (tail <= 0.025) {
        ++k;
        logChance += std::log(static_cast<double>(n - k + 1) / static_cast<double>(k));
        tail += std::exp(logChance);
    }
    return {median(values), values[k - 1], values[n - k]};
}

}  // namespace penumbra
