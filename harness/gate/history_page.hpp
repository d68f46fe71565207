#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/gate/history.hpp"

namespace penumbra::gate {

/// A self-contained page: every approval, every step change, and each metric of each row over the
/// approved commits.
std::string historyPage(const std::vector<Approval>& approvals);

/// Reads a history and writes its page to `out` (empty: history.html beside it), whose path is
/// printed. An approval that the baseline.csv beside the history says was stopped is left out.
/// Returns 0. Throws InputError for a history that cannot be read.
int writeHistoryPage(const std::filesystem::path& history, const std::filesystem::path& out);

}  // namespace penumbra::gate
