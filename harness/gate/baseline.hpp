#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/run/row.hpp"
#include "harness/run/run_record.hpp"

namespace penumbra::gate {

/// A baseline: the columns of results.csv and, after them, `machine`. Another run's results.csv is
/// one too; its machine is then that of the run.json beside it.
struct Baseline {
    std::filesystem::path file;
    ResultsTable table;
    /// Of each row, empty where unknown.
    std::vector<std::string> machines;
};

/// The processor and the kind of build that a run's times are of.
std::string machineOf(const RunRecord& record);

/// Throws InputError with file:line (readResultsTable).
Baseline readBaseline(const std::filesystem::path& file);

/// The text of a baseline that holds these rows of one machine.
std::string baselineText(const std::vector<Row>& rows, const std::string& machine);

}  // namespace penumbra::gate
