#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/gl/context.hpp"
#include "harness/run/row.hpp"
#include "harness/run/settings.hpp"
#include "harness/run/truth.hpp"

namespace penumbra {

/// What `penumbra tune` was asked for: exactly one of maxRmse and maxMs.
struct TuneOptions : TruthOptions {
    std::string scene;
    int frame = 0;
    std::vector<std::string> methods;  ///< empty: all
    std::optional<double> maxRmse;     ///< the fastest setting whose rmse is no greater
    std::optional<double> maxMs;       ///< the most accurate whose median frame time is no greater
    gl::ContextKind context = gl::ContextKind::osmesa;
    bool remeasure = false;       ///< measures anew what the cache folder holds
    bool againstLadders = false;  ///< measures every rung that could win, and says whether one does
    std::filesystem::path out;    ///< empty: nothing is written
};

/// A constraint and what is best under it, as one number that a search can follow.
struct TuneGoal {
    std::optional<double> maxRmse, maxMs;

    bool meets(double rmse, double ms) const { return maxMs ? ms <= *maxMs : rmse <= *maxRmse; }
    /// The smaller the better: the logarithm of what is to be small and a steep penalty for missing
    /// the constraint.
    double merit(double rmse, double ms) const;
    /// "rmse <= 0.01" or "12 ms".
    std::string text() const;
};

/// One measurement on the way.
struct TuneTrial {
    std::string phase;  ///< ladder, round 1..3, confirm, final, check
    Row row;
};

struct TuneResult {
    std::vector<TuneTrial> trials;
    std::optional<Row> best;     ///< the final measurement; absent: nothing meets the constraint
    std::optional<Row> nearest;  ///< then: what comes nearest
    /// With againstLadders: the best rung that meets the constraint, and the found setting's row
    /// measured interleaved with it.
    std::optional<Row> ladderBest, besideLadder;
    bool atLeastAsGood = true;  ///< as ladderBest: no worse beyond the intervals
};

/// Measures settings on the small image (false) or the full one (true).
using TuneMeasure = std::function<std::vector<Row>(bool, const std::vector<Setting>&, int repeats)>;

/// The search. Every choice in it is a function of the seed and of what `measure` says:
///
/// 1. Ladders, on the small image: every method climbs its ladder side by side with the others and
///    stops where its time is twice what could still win.
/// 2. Successive halving, on the small image: the best 12, 6, then 3 settings (at most half of one
///    method) get new neighbours and ever more repeats. The full image's time is build time plus
///    shade time by the ratio of pixels. Until the final, times are the lower ends of their
///    intervals: neighbours on the machine only ever add.
/// 3. Confirmation at full size, best estimate first; what is learned of a method's ratio of full
/// to
///    estimate corrects those of its other settings. Ends when the next estimate is a quarter worse
///    than the best that was confirmed.
/// 4. Final: the best few interleaved with 9 repeats. Under maxRmse the fastest wins; of settings
///    within 3 % of it whose intervals overlap the most accurate one, so that noise seldom decides.
TuneResult searchSettings(const std::vector<std::string>& methods, const TuneGoal& goal,
                          double pixelRatio, std::uint32_t seed, bool againstLadders,
                          const TuneMeasure& measure);

/// Runs the command: prints what was found and tried, writes tune.csv into `out`. Returns 0, or 1
/// when nothing meets the constraint. Throws InputError for bad input before anything is written.
int tune(const TuneOptions& options);

}  // namespace penumbra
