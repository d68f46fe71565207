#include "harness/metrics/penumbra_width.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

namespace penumbra {

namespace {

constexpr double kLow = 0.1, kHigh = 0.9;

/// Distance of the crossings over the whole width. A disc's visibility at distance t (in radii)
/// from the penumbra's centre is 1/2 + (t sqrt(1 - t^2) + asin t) / pi, which is 0.9 at this t.
double crossingsShare(EdgeShape shape) {
    return shape == EdgeShape::disc ? 0.6870488261325404 : kHigh - kLow;
}

}  // namespace

std::optional<EdgeProfile> measureEdge(std::span<const double> positionsM,
                                       std::span<const double> visibility, EdgeShape shape) {
    if (positionsM.size() != visibility.size()) {
        throw std::invalid_argument("measureEdge: one visibility per position is needed");
    }
    if (std::ranges::adjacent_find(positionsM, std::not_fn(std::less<>())) != positionsM.end()) {
        throw std::invalid_argument("measureEdge: positions must rise");
    }
    std::vector<double> x(positionsM.begin(), positionsM.end());
    std::vector<double> v(visibility.begin(), visibility.end());
    if (v.empty() || !std::ranges::all_of(v, [](double value) { return std::isfinite(value); })) {
        return std::nullopt;
    }
    if (v.front() > v.back()) {
        std::ranges::reverse(x);
        std::ranges::reverse(v);
    }
    if (v.front() >= kLow || v.back() <= kHigh) return std::nullopt;

    // The ends guarantee both crossings: the first sample above 0.9, the last one below 0.1 before.
    const auto crossing = [&](std::size_t i, double level) {
        return x[i - 1] + (level - v[i - 1]) / (v[i] - v[i - 1]) * (x[i] - x[i - 1]);
    };
    std::size_t high = 1;
    while (v[high] <= kHigh) ++high;
    std::size_t low = high;
    while (v[low - 1] >= kLow) --low;
    const double atLow = crossing(low, kLow), atHigh = crossing(high, kHigh);
    return EdgeProfile{std::abs(atHigh - atLow) / crossingsShare(shape), 0.5 * (atLow + atHigh)};
}

EdgeError compareEdges(const EdgeProfile& measured, const EdgeProfile& reference) {
    return {(measured.widthM - reference.widthM) / reference.widthM,
            (measured.centreM - reference.centreM) / reference.widthM};
}

}  // namespace penumbra
