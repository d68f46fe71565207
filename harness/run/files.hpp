#pragma once

#include <filesystem>
#include <string>

namespace penumbra {

/// Writes `text` beside `path` and renames it there: readers see the old file or the whole new one.
/// Throws std::runtime_error with the reason. With `durable` the text is on the disk before its name
/// is, so that not even a power cut leaves half of it.
void writeFileAtomically(const std::filesystem::path& path, const std::string& text,
                         bool durable = false);

/// Adds `markdown` to the page that GitHub shows of a CI step, where $GITHUB_STEP_SUMMARY names one.
void appendToStepSummary(const std::string& markdown);

}  // namespace penumbra
