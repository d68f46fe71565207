#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "harness/run/compare.hpp"
#include "harness/run/statistics.hpp"

namespace penumbra {

/// What grows: the triangles of the scene, its surface staying what it is; the image's pixels; a
/// method's parameter of that name; the light's sides.
enum class ScalingAxis { triangles, pixels, map_size, light_size, slices };

/// Throws InputError with the valid names.
ScalingAxis parseScalingAxis(const std::string& text);
const char* nameOf(ScalingAxis axis);

/// y = c x^exponent through points by least squares of the logarithms.
struct PowerLaw {
    double exponent = 0.0;
    double worstFactor = 1.0;  ///< the farthest point from the curve: off by this factor, >= 1
};

/// Throws std::invalid_argument for fewer than two points, all of one x, or anything not above 0.
PowerLaw fitPowerLaw(std::span<const double> x, std::span<const double> y);

/// How a time grows with x.
struct Growth {
    TimingSummary exponent;    ///< of the rounds' exponents: each round timed every x once
    double worstFactor = 1.0;  ///< of the power law through the medians over the rounds
};

/// `rounds[r][i]` is the time at x[i] in round r. Absent for fewer than two points and where a time
/// is 0, as the build of what has none.
std::optional<Growth> growthOf(std::span<const double> x,
                               const std::vector<std::vector<double>>& rounds, std::uint32_t seed);

/// `penumbra compare --scaling`: times every setting of `options` on the first frame of every scene
/// over a geometric series of `axis`, in rounds whose order is drawn anew for each. Writes
/// scaling.csv, summary.md and, per scene, scaling/<scene>.svg and .png. Returns 0, or 3 when some point failed. Throws InputError for bad
/// input before anything is measured.
int scaling(const CompareOptions& options, ScalingAxis axis);

}  // namespace penumbra
