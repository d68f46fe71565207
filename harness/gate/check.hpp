#pragma once

#include <filesystem>

namespace penumbra::gate {

/// What `penumbra check` was asked for.
struct CheckOptions {
    std::filesystem::path run;
    std::filesystem::path baseline;
    std::filesystem::path gates;  ///< empty: gates.toml beside the baseline, if there is one
    bool remeasure = true;        ///< what fails is measured once more before it fails
    /// Rows of scenes and settings that the run was not asked for are not missing.
    bool partial = false;
};

/// Judges a run folder against a baseline: prints the verdict, writes junit.xml, benchmark.json and
/// gate.md, a section of summary.md, into it, and tells CI (GITHUB_STEP_SUMMARY, and `::error`
/// lines where GITHUB_ACTIONS is true). Returns 0, or 1 if the gate fails. Throws InputError before
/// anything is written for a run, baseline or rules that cannot be read or compared.
int check(const CheckOptions& options);

}  // namespace penumbra::gate
