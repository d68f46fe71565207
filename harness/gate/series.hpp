#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/gate/history.hpp"
#include "harness/gate/step.hpp"

namespace penumbra::gate {

/// One metric of one row over all approvals.
struct Series {
    std::string scene;
    int frame = 0;
    std::string setting, metric;
    /// What held after each approval; none where there was no such row or value.
    std::vector<std::optional<double>> values;
    /// Of judged metrics, by their own thresholds (GatedMetric); `at` is the approval. Never
    /// between times of different renderers, thread counts or machines.
    std::vector<Step> steps;
};

/// In the order in which rows and metrics first appear.
std::vector<Series> seriesOf(const std::vector<Approval>& approvals);

}  // namespace penumbra::gate
