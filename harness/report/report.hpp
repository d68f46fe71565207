#pragma once

#include "harness/run/run_folder.hpp"
#include "harness/run/run_record.hpp"

namespace penumbra {

/// Rewrites results.csv in the record's order of scenes, frames and settings, so that an interrupted
/// and resumed run ends with the same file as one that was not.
void orderRows(const RunFolder& folder, const RunRecord& record);

/// Rebuilds grid/*.png and summary.md from run.json, results.csv and the images.
void writeArtefacts(const RunFolder& folder);

/// summary.md alone.
void writeSummary(const RunFolder& folder);

}  // namespace penumbra
