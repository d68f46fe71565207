#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/study/claims.hpp"

namespace penumbra {

/// What became of one claim.
struct ClaimResult {
    std::string paper;  ///< id
    std::string citation;
    Claim claim;
    Verdict verdict = Verdict::could_not_run;
    std::string message;            ///< why it could not run, or what is odd; else empty
    std::optional<double> a, b;     ///< the metric's values: medians of times
    std::optional<Interval> ratio;  ///< a over b
};

/// The table of claims.csv, header first: one row per claim.
std::string claimsCsv(const std::vector<ClaimResult>& results);

/// A page: `heading` lines, a table per paper and what each claim was measured with below it. A
/// claim's `found` stands there if the verdict is that it does not hold.
std::string claimsMarkdown(const std::vector<ClaimResult>& results,
                           const std::vector<std::string>& heading);

/// One line per claim, for terminals.
std::string claimsText(const std::vector<ClaimResult>& results);

}  // namespace penumbra
