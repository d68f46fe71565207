#pragma once

#include <filesystem>
#include <string>

namespace penumbra::gate {

/// What `penumbra approve` was asked for.
struct ApproveOptions {
    std::filesystem::path run;
    std::string reason;
    std::filesystem::path baseline;
    std::filesystem::path history;  ///< empty: history.csv beside the baseline
};

/// Makes the rows of a run the baseline, all of them and no others, and appends to the history what
/// that changes. Prints how many rows are new, changed and gone. Stopped at any point it leaves the
/// old baseline with its history or the new one (history.hpp). Returns 0. Throws InputError before
/// anything is written for an empty reason, a run that is not finished or has failed cells or no
/// rows, and for files that cannot be read.
int approve(const ApproveOptions& options);

}  // namespace penumbra::gate
