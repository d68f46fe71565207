#pragma once

#include <string>
#include <vector>

#include "harness/run/effects_record.hpp"
#include "harness/run/row.hpp"

namespace penumbra {

/// The section of summary.md about what the frames call for, with the evidence, and what finding
/// that out took. Frames of a scene that agree share their lines. Empty without records.
std::string effectsMarkdown(const std::vector<EffectsRecord>& records);

/// The section about what the rows' methods can simulate, by their traits. Empty where no row is of
/// a registered method.
std::string capabilityMarkdown(const std::vector<Row>& rows);

}  // namespace penumbra
