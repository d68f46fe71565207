#pragma once

#include <optional>
#include <string>

namespace penumbra {

/// A number known to lie in [low, high], 95 times of 100 for measured ones; low == high for counts
/// and whatever else has no noise. Infinity where something is divided by 0.
struct Interval {
    double value = 0.0, low = 0.0, high = 0.0;

    static Interval exact(double value) { return {value, value, value}; }
    bool isExact() const { return low == high; }
    bool operator==(const Interval&) const = default;
};

/// What a claim says of a ratio.
enum class Relation {
    match,      ///< the paper's, within a factor either way
    at_least,   ///< the paper's or more
    at_most,    ///< the paper's or less
    above_one,  ///< side a has more, in words only
    below_one,  ///< side a has less, in words only
};

struct Expectation {
    Relation relation = Relation::match;
    std::optional<double> ratio;  ///< the paper's; none for above_one and below_one
    double factor = 1.0;          ///< of match, above 1

    /// The ratios that agree with the claim, ends included except for 1 itself in above_one and
    /// below_one.
    bool allows(double measured) const;
    /// As in "10.7 (within 2x)", "at least 25", "> 1".
    std::string text() const;
};

/// `undecided`: the interval holds both ratios that agree with the claim and ratios that do not.
enum class Verdict { holds, does_not_hold, undecided, could_not_run, not_implemented };

/// "holds", "does not hold", ...
const char* textOf(Verdict verdict);

Verdict judge(const Expectation& expected, const Interval& measured);

}  // namespace penumbra
