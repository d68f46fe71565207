#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/gate/gated_metric.hpp"

namespace penumbra::gate {

/// What differs from the metrics' own thresholds, by place: gates.toml.
///
///     [[gate]]
///     scene    = "foliage*"    # globs with * and ?; what is left out matches everything
///     method   = "pcss*"       # a method's id or a setting's name
///     metric   = "frame_ms"    # a column of gatedMetrics(), "row" or "effects_missing"
///     relative = 0.2           # of the baseline's value
///     absolute = 0.5           # in the metric's unit; the greater of the two counts
///     reason   = "..."         # needed
///
/// Instead of numbers `ignore = true` leaves the metric unjudged; with `metric = "row"` it lets
/// rows vanish, with "effects_missing" effects go missing. The last rule that matches wins.
class Thresholds {
  public:
    /// No rules: every metric's own threshold.
    Thresholds() = default;
    /// Throws InputError with file:line for what is no such file, an unknown key or a pattern that
    /// no metric matches.
    static Thresholds read(const std::filesystem::path& file);

    Threshold of(const GatedMetric& metric, const Row& row) const;
    /// For kRow and kEffectsMissing; `ignored` or not.
    Threshold of(std::string_view state, const Row& row) const;

  private:
    struct Rule {
        std::string scene = "*", method = "*", metric = "*";
        Threshold threshold;
    };
    template <class MatchesMetric>
    const Rule* lastMatching(const Row& row, const MatchesMetric& matchesMetric) const;

    std::vector<Rule> rules_;
};

/// Whether `text` is matched by `pattern`, in which * stands for any characters and ? for one byte.
bool matchesGlob(std::string_view pattern, std::string_view text);

}  // namespace penumbra::gate
