#pragma once

#include "harness/run/run_folder.hpp"
#include "harness/run/run_record.hpp"

namespace penumbra {

/// Rewrites results.csv in the record's order of scenes, frames and settings, so that an
/// interrupted and resumed run ends with the same file as one that was not. What `check` said of
/// the rows before goes.
void orderRows(const RunFolder& folder, const RunRecord& record);

/// Rebuilds grid/*.png, report.html, summary.md, benchmark.json and, where a method has several
/// settings, pareto.csv and curve/* from run.json, results.csv and the images. `curveMetric` is the
/// error in the latter; empty: the run's own choice. Throws InputError if it is none.
void writeArtefacts(const RunFolder& folder, const std::string& curveMetric = {});

/// summary.md alone; paired.csv, claims.md, stress.md and gate.md, where they are there, are
/// sections of it.
void writeSummary(const RunFolder& folder, const std::string& curveMetric = {});

}  // namespace penumbra
