#include "harness/study/scaling.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/error.hpp"

namespace penumbra {
namespace {

constexpr std::array<const char*, 5> kAxes = {"triangles", "pixels", "map_size", "light_size",
                                              "slices"};

}  // namespace

ScalingAxis parseScalingAxis(const std::string& text) {
    for (std::size_t i = 0; i < kAxes.size(); ++i)
        if (text == kAxes[i]) return static_cast<ScalingAxis>(i);
    throw InputError(
        fmt::format("--scaling {}: unknown; valid are {}", text, fmt::join(kAxes, ", ")));
}

const char* nameOf(ScalingAxis axis) {
    return kAxes[static_cast<std::size_t>(axis)];
}

PowerLaw fitPowerLaw(std::span<const double> x, std::span<const double> y) {
    const auto positive = [](double v) { return v > 0.0 && std::isfinite(v); };
    if (x.size() < 2 || x.size() != y.size() || !std::ranges::all_of(x, positive) ||
        !std::ranges::all_of(y, positive))
        throw std::invalid_argument("fitPowerLaw: needs two points or more, all above 0");
    const double n = static_cast<double>(x.size());
    double meanX = 0.0, meanY = 0.0, xx = 0.0, xy = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        meanX += std::log(x[i]) / n;
        meanY += std::log(y[i]) / n;
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double dx = std::log(x[i]) - meanX;
        xx += dx * dx;
        xy += dx * (std::log(y[i]) - meanY);
    }
    if (!(xx > 0.0)) throw std::invalid_argument("fitPowerLaw: all points have one x");
    PowerLaw law{xy / xx, 1.0};
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double fitted = meanY + law.exponent * (std::log(x[i]) - meanX);
        law.worstFactor = std::max(law.worstFactor, std::exp(std::abs(std::log(y[i]) - fitted)));
    }
    return law;
}

std::optional<Growth> growthOf(std::span<const double> x,
                               const std::vector<std::vector<double>>& rounds, std::uint32_t seed) {
    if (x.size() < 2 || rounds.empty()) return std::nullopt;
    std::vector<double> exponents, medians;
    for (const std::vector<double>& times : rounds) {
        if (!std::ranges::all_of(times, [](double ms) { return ms > 0.0; })) return std::nullopt;
        exponents.push_back(fitPowerLaw(x, times).exponent);
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
        std::vector<double> times;
        for (const std::vector<double>& round : rounds) times.push_back(round[i]);
        medians.push_back(median(std::move(times)));
    }
    return Growth{summarise(exponents, seed), fitPowerLaw(x, medians).worstFactor};
}

}  // namespace penumbra
