#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "harness/gate/baseline.hpp"
#include "harness/gate/thresholds.hpp"

namespace penumbra::gate {

/// A run as the gate takes it.
struct JudgedRun {
    std::filesystem::path folder;
    RunRecord record;
    ResultsTable table;

    /// Throws InputError with the file and line of what is wrong.
    static JudgedRun read(const std::filesystem::path& folder);
};

enum class State {
    passed,
    failed,
    recovered,     ///< failed at first, not when it was measured again
    missing,       ///< the baseline's row is not in the run
    missingKnown,  ///< and a rule in gates.toml lets it
    added,         ///< a row that the baseline does not have: nothing to compare with
};

/// One metric that became worse than it may.
struct Finding {
    std::string metric;
    std::string change;     ///< from what to what, and by how much
    std::string limit;      ///< what would have been allowed, and why
    double severity = 0.0;  ///< times the limit; infinite for what has no number
};

/// What one row says about one kind of thing; a testcase of junit.xml.
struct Gate {
    Row row;  ///< the run's, or the baseline's where the run has none
    Kind kind = Kind::row;
    State state = State::passed;
    std::vector<Finding> findings;  ///< gravest first; of a recovered gate those of the first time
    std::string note;               ///< why it is in this state, if it did not just pass or fail
    std::string again;              ///< what measuring again came to, if it was to be

    bool fails() const { return state == State::failed || state == State::missing; }
    std::string place() const;  ///< "fence frame 0 pcss"
};

struct Verdict {
    std::vector<Gate> gates;         ///< in order of the baseline's rows, new ones last
    std::vector<std::string> notes;  ///< what was not compared at all, each said once
    std::size_t improvements = 0;    ///< metrics that are better by more than their limit
    std::vector<double> timeRatios;  ///< run over baseline, of all rows compared in time

    std::size_t count(State state) const;
    bool fails() const;
};

/// Compares a run with a baseline.
///
/// - row: a row of the baseline must be there, and `ok` where it was `ok`. One that is not there is
///   `missing` and fails unless a rule lets it; one that only the run has is `added` and neither
///   passes nor fails. A row that was not `ok` in the baseline has nothing to be compared with.
/// - accuracy: a metric fails if it is worse by more than its threshold *and* by more than both
/// runs'
///   reference noise explains (reference_noise.hpp).
/// - time: frame_ms fails if its interval lies wholly above the baseline's *and* the medians differ
/// by
///   more than the threshold. Rows of different renderers, thread counts or machines, of an unknown
///   machine or without intervals are not compared.
/// - work: counters may not grow, maps and texture memory among them; on one renderer only, whose
///   rasterisation decides the fragments and through them what adaptive methods do.
/// - effects: those that a method leaves out must have been left out before.
///
/// A value that the baseline has and the run has not fails its metric. Columns that one of the
/// files lacks are not compared. Throws InputError where sizes differ: nothing could be compared.
Verdict judge(const Baseline& baseline, const JudgedRun& run, const Thresholds& thresholds);

}  // namespace penumbra::gate
