#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/gate/baseline.hpp"

namespace penumbra::gate {

/// One value of one row that an approval changed. No `before`: the row or the value is new; no
/// `after`: it is gone.
struct Change {
    std::string scene;
    int frame = 0;
    std::string setting, metric;
    std::optional<double> before, after;
    bool operator==(const Change&) const = default;
};

struct Approval {
    std::string when;  ///< UTC, ISO 8601
    std::string who, commit, reason, renderer, machine;
    int threads = 0;
    /// XXH3 of the baseline that it wrote, 16 hex digits.
    std::string baseline;
    std::vector<Change> changes;
};

/// results/history.csv: one line for each approval, its changes in the lines below it, where the
/// approval's own columns are empty:
///
///     when,who,commit,reason,renderer,threads,machine,baseline,scene,frame,setting,metric,before,after
///
/// Metrics are gatedMetrics() and the ends of frame_ms's interval.
///
/// An approval writes the history first and the baseline last, each in one step; the second makes
/// it count. If it was stopped between the two, the last approval's hash is not the baseline's:
/// dropUnborn() leaves it out. So whoever reads both sees all of an approval or nothing.
std::vector<Approval> readHistory(const std::filesystem::path& file);
std::string historyText(const std::vector<Approval>& approvals);

/// Drops the last approval if `baselineText` is not what it wrote but what the one before it did,
/// or if there is no baseline (empty text).
void dropUnborn(std::vector<Approval>& approvals, std::string_view baselineText);

std::string hashOf(std::string_view text);

/// Names of what history.csv keeps of a row.
const std::vector<std::string>& historyMetrics();

/// What differs in `after`, which may hold new rows and lack old ones; in order of the rows.
std::vector<Change> changesBetween(const std::vector<Row>& before, const std::vector<Row>& after);

}  // namespace penumbra::gate
