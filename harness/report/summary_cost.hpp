#pragma once

#include <string>
#include <vector>

#include "harness/study/pareto.hpp"

namespace penumbra {

/// The section of summary.md about what accuracy costs: the front, the cheapest setting that
/// reaches an error, the least error within a budget, what the next halving of error costs. The
/// suite's tables first; those of single scenes are folded away where they are long. Empty without
/// studies.
std::string costMarkdown(const std::vector<CostStudy>& studies, const std::string& metric);

}  // namespace penumbra
