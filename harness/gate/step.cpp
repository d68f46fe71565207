#include "harness/gate/step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "harness/run/statistics.hpp"

namespace penumbra::gate {
namespace {

constexpr double kSigmasOfStep = 3.0;
constexpr double kSigmaOfMad = 1.4826;

double medianOf(std::span<const Point> side) {
    std::vector<double> values;
    for (const Point& p : side) values.push_back(p.value);
    return median(std::move(values));
}

double deviation(std::span<const Point> side, double level) {
    double sum = 0.0;
    for (const Point& p : side) sum += std::abs(p.value - level);
    return sum;
}

/// A series as two levels, and how well that describes it.
struct Split {
    Step step;
    double deviation = std::numeric_limits<double>::infinity();
};

Split bestSplit(std::span<const Point> series) {
    Split best;
    for (std::size_t at = 1; at < series.size(); ++at) {
        const auto left = series.first(at), right = series.subspan(at);
        const double before = medianOf(left), after = medianOf(right);
        const double sum = deviation(left, before) + deviation(right, after);
        const double change = std::abs(after - before);
        const double bestChange = std::abs(best.step.after - best.step.before);
        if (sum < best.deviation || (sum == best.deviation && change > bestChange))
            best = {{at, before, after}, sum};
    }
    return best;
}

/// Median of what is there; 0 of nothing.
double medianOrZero(std::vector<double> values) {
    return values.empty() ? 0.0 : median(std::move(values));
}

/// What the medians on both sides of `at` must differ by to be more than noise.
double leastAboveNoise(std::span<const Point> series, std::size_t at) {
    std::vector<double> differences, halfWidths;
    for (std::size_t i = 0; i < series.size(); ++i) {
        halfWidths.push_back(series[i].halfWidth);
        if (i > 0 && i != at)
            differences.push_back(std::abs(series[i].value - series[i - 1].value));
    }
    const double sigma = kSigmaOfMad / std::sqrt(2.0) * medianOrZero(std::move(differences));
    return std::max(kSigmasOfStep * sigma, 2.0 * medianOrZero(std::move(halfWidths)));
}

void addSplits(std::span<const Point> series, std::size_t offset, double relative, double absolute,
               std::vector<std::size_t>& splits) {
    if (series.size() < 2) return;
    const Step step = bestSplit(series).step;
    if (!(std::abs(step.after - step.before) >
          std::max({relative * std::abs(step.before), absolute, leastAboveNoise(series, step.at)})))
        return;
    addSplits(series.first(step.at), offset, relative, absolute, splits);
    splits.push_back(offset + step.at);
    addSplits(series.subspan(step.at), offset + step.at, relative, absolute, splits);
}

}  // namespace

std::vector<Step> findSteps(std::span<const Point> series, double relative, double absolute) {
    std::vector<std::size_t> splits;
    addSplits(series, 0, relative, absolute, splits);
    std::vector<Step> steps;
    for (std::size_t i = 0; i < splits.size(); ++i) {
        const std::size_t begin = i == 0 ? 0 : splits[i - 1];
        const std::size_t end = i + 1 == splits.size() ? series.size() : splits[i + 1];
        steps.push_back({splits[i], medianOf(series.subspan(begin, splits[i] - begin)),
                         medianOf(series.subspan(splits[i], end - splits[i]))});
    }
    return steps;
}

}  // namespace penumbra::gate
