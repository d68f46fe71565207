#pragma once

#include <string>

#include "core/file/atomic_file.hpp"

namespace penumbra {

/// Adds `markdown` to the page that GitHub shows of a CI step, where $GITHUB_STEP_SUMMARY names one.
void appendToStepSummary(const std::string& markdown);

}  // namespace penumbra
