#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace penumbra::gate {

struct Point {
    double value = 0.0;
    double halfWidth = 0.0;  ///< of the value's 95 % interval; 0 where it is deterministic
};

/// The level of a series changes before its point `at`.
struct Step {
    std::size_t at = 0;
    double before = 0.0,
           after = 0.0;  ///< medians of the levels on both sides, up to the next steps
};

/// Where the level of a series changes. The series is split in two where the absolute deviations
/// from both sides' medians sum up to the least; that is a step if the medians differ by more than
/// `relative` times the left one's magnitude, by more than `absolute`, by more than two of the
/// median halfWidth, so that intervals of that size around both are apart, and by more than three
/// standard deviations of the noise. That is 1.4826 / sqrt(2) times the median difference of
/// neighbours, the two at the split excepted: for normal noise it is the standard deviation,
/// whatever other steps there are. Both sides are then split likewise, until none has a step. A
/// single outlier between other points is none; one at the end may be. A level that lasts for less
/// than half of what follows it and returns is taken for outliers too.
std::vector<Step> findSteps(std::span<const Point> series, double relative, double absolute);

}  // namespace penumbra::gate
