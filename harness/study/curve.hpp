#pragma once

#include <map>
#include <string>
#include <vector>

#include "harness/study/pareto.hpp"
#include "harness/study/plot.hpp"

namespace penumbra {

/// A number for the look of each method in `studies`, the same in all of them and, for methods of
/// this build, in all runs.
std::map<std::string, int> methodStyles(const std::vector<CostStudy>& studies);

/// Error against frame time: one series per method, its line through those of its settings that no
/// other of its own is better than in both; the study's front as filled dots, joined by the band;
/// the floor. Methods that lack frames of the study are dashed and say how many they have.
Plot curvePlot(const CostStudy& study, const std::string& metric,
               const std::map<std::string, int>& styles);

}  // namespace penumbra
