#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/run/row.hpp"

namespace penumbra::gate {

/// What a gate is about. Each row has at most one gate of each kind.
enum class Kind { row, accuracy, time, work, effects };
std::string_view nameOf(Kind kind);

/// Where a metric's best value lies.
enum class Better { lower, higher, nearZero, unchanged };

/// How the reference's standard error shows in a metric (reference_noise.hpp).
enum class Noise { none, meanOfAll, meanOfPenumbra, onePixel, worstPixel };

/// How much worse a metric may become: the greater of `relative` times the baseline's magnitude and
/// `absolute` in the metric's own unit.
struct Threshold {
    double relative = 0.0, absolute = 0.0;
    bool ignored = false;  ///< the metric is not judged at all
    std::string reason;
};

/// A column of results.csv that the gate judges.
struct GatedMetric {
    std::string_view id;
    Kind kind = Kind::accuracy;
    Better better = Better::lower;
    Noise noise = Noise::none;
    double relative = 0.0, absolute = 0.0;
    std::string_view reason;  ///< of the two numbers
    /// The frame's, the same in all of its rows: judged in the first only.
    bool ofFrame = false;

    Threshold threshold() const { return {relative, absolute, false, std::string(reason)}; }
};

/// In order of the columns.
const std::vector<GatedMetric>& gatedMetrics();

/// What a rule in gates.toml can name besides those: the presence and state of a row, and the
/// effects it misses.
inline constexpr std::string_view kRow = "row", kEffectsMissing = "effects_missing";

/// By how much `after` is worse than `before`; negative where it is better.
double worsening(const GatedMetric& metric, double before, double after);
/// What `relative` is a fraction of: the distance of `before` from the best value, or its
/// magnitude.
double scaleOf(const GatedMetric& metric, double before);

}  // namespace penumbra::gate
