#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/run/cells.hpp"
#include "harness/run/statistics.hpp"

namespace penumbra {

/// One pair of frames timed one right after the other, so that what else the machine does hits
/// both.
struct PairSample {
    bool aFirst = false;  ///< the order, drawn anew for every pair
    double aMs = 0.0, bMs = 0.0;
    bool operator==(const PairSample&) const = default;
};

enum class PairedVerdict { faster, slower, indistinguishable };

/// How much faster A is than B: the median over pairs of B's time over A's, with its sign-test
/// interval. Because the order within each pair is a fair coin, two settings that cost the same
/// have either as the slower one of a pair with the same chance, whatever the noise, the drift and
/// the advantage of going second: they are called different in at most 5 % of cases.
struct PairedTiming {
    MedianInterval speedup;  ///< above 1: A is the faster one
    std::size_t pairs = 0;
    PairedVerdict verdict = PairedVerdict::indistinguishable;  ///< of A: whether 1 is outside
};

/// Needs kFewestForSignTest pairs, else throws std::invalid_argument.
PairedTiming judgePairs(const std::vector<PairSample>& pairs);

/// The verdict of any median of ratios.
PairedVerdict verdictOf(const MedianInterval& speedup);

struct PairedResult {
    Row a, b;  ///< as runCells makes them, metrics still empty
    std::vector<float> visibilityA, visibilityB;
    std::vector<PairSample> pairs;  ///< in the order of measurement; empty unless ok()
    bool ok() const { return a.status == "ok" && b.status == "ok"; }
};

/// Times `options.repeats` pairs of frames of the two settings, which may be the same one, by
/// runCells with the same warm-up and clock as every other cell. A setting that fails or refuses
/// the frame says so in its row. `options.sampled` is not used.
PairedResult measurePaired(const Frame& frame, CellOptions options, const Setting& a,
                           const Setting& b, const TextureTarget& target);

}  // namespace penumbra
