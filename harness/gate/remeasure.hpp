#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "harness/gate/judge.hpp"

namespace penumbra::gate {

struct Remeasured {
    JudgedRun run;  ///< as it was, with the rows that were measured again in place of the first
    std::set<std::string> keys;  ///< Row::key of those
    std::string never;           ///< why there are none; empty if there are
};

/// Measures the cells of every failing gate, and the frame before a cell that had no image (flicker
/// needs it), once more, with the options of the run's record, into
/// RUN/remeasured, which is made anew. Nothing is measured where this program or machine is not the
/// one of the run (another commit, processor, kind of build or renderer), whose cells then would be
/// others. Rows that no cell makes, the separation and images from outside, stay as they are.
/// Writes progress to standard error. Throws Interrupted if a signal asked to stop.
Remeasured measureAgain(const JudgedRun& run, const Verdict& verdict);

/// The first verdict with every failed gate judged anew by what was measured again; each says what
/// became of it. A time or a failed cell that fails no more has `recovered`. Accuracy, work and
/// effects do not depend on chance: where they pass the second time only, the run's rows are not
/// this program's (edited by hand, say), and the gate fails as at first.
Verdict judgeAgain(const Verdict& first, const Remeasured& again, const Baseline& baseline,
                   const Thresholds& thresholds);

}  // namespace penumbra::gate
