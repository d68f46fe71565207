#pragma once

#include <set>
#include <string>

#include "harness/run/run_folder.hpp"
#include "harness/run/run_record.hpp"

namespace penumbra {

/// Prepares a run folder that an earlier process left, however it ended, for the rest of its cells:
/// files that were cut off while they were written go, and so do rows that must be done again,
/// those of failed cells and those whose image is gone. `record`, of the run that goes on, takes
/// over what the earlier one found out. Returns the Row::key of every row that stays. Throws
/// InputError, changing nothing, where the two differ in what the rows depend on.
std::set<std::string> takeUpRun(const RunFolder& folder, RunRecord& record);

/// Removes what a process that was killed before it had a results.csv left in the folder.
void removeTornBeginnings(const RunFolder& folder);

}  // namespace penumbra
