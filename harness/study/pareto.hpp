#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/run/row.hpp"

namespace penumbra {

/// What accuracy costs in time: every setting of a run as one point of error against frame time,
/// for each scene and over all of them.
///
/// **Error** is a metric's column; where larger is better or the sign says only which way, what is
/// left of it is below 1 (1 - ssim) or its absolute value (bias, penumbra_width_error,
/// penumbra_shift). In a scene it is the mean over the frames; over the suite the root mean square
/// over all frames of all scenes, so that one bad scene is not bought off by many easy ones.
///
/// **Time** is the mean of frame_ms over the frames, its interval the mean of the intervals'
/// bounds: that of frames whose noise is one and the same, wider than any other. Frames that were
/// not rendered here have no time and are left out.
///
/// **The front** holds a setting if every setting with less error is surely slower, and no setting
/// with the same error is surely faster. Surely: 0 is outside the interval of the difference of
/// their times. That interval follows from the two of every frame (Zou & Donner 2008): distances of
/// the values from the ends of their intervals, added in squares, because noise of two settings and
/// of two frames is independent as far as it matters: drift that hits all alike cancels in the
/// difference. Asking that the two intervals do not touch adds distances themselves: over a suite
/// of ten frames with 30 % noise the front of ten settings, each 1.3 times as costly as the one
/// before, then had one left, here nine.
///
/// So an advantage in time that noise could explain never puts a setting on the front; equal
/// settings are both on it or both off. The price remains that of three settings of which each
/// could be as fast as the next only the most accurate is left: where noise is larger than the
/// distance between settings a front is not to be known. Letting those that are off keep nobody off
/// would fill it, with settings that a more accurate one beats: 12 % of such instead of 1 %.
///
/// **Coverage.** A frame belongs to the study if any setting has an error and a time in it. A
/// setting that lacks some (failed, unsupported) is measured over those that it has, and competes
/// with others over just these: it can be kept off the front by settings that have all of its
/// frames, it keeps nobody off who has frames that it lacks. Tables over the study leave it out.
struct CostPoint {
    std::string method, setting, params;
    double error = 0;
    double ms = 0, lowMs = 0, highMs = 0;
    bool onFront = false;
    std::size_t frames = 0, scenes = 0;  ///< that it covers
};

struct CostStudy {
    std::string scene;                   ///< kWholeSuite: over all of them
    std::size_t frames = 0, scenes = 0;  ///< that there are
    std::vector<CostPoint> points;       ///< by method, then from fast to slow
    /// The error that the reference's own noise would give a perfect image; for rmse and
    /// rmse_penumbra.
    std::optional<double> floor;

    bool covers(const CostPoint& point) const { return point.frames == frames; }
};

inline constexpr std::string_view kWholeSuite = "suite";

/// The method at whose cost tables count budgets. The harness knows no method; this is a word that
/// readers know: what one shadow map costs. Runs without it have no such table.
inline constexpr std::string_view kCostUnit = "hard";

/// Whether the rows have several timed settings of one method: else there is no curve.
bool hasCurve(const std::vector<Row>& rows);

/// One study per scene, by name, and one over the suite if there are several scenes. The order of
/// the rows does not matter.
std::vector<CostStudy> costStudies(const std::vector<Row>& rows, const std::string& metric);

/// Throws InputError with the valid ones if `metric` is none that can be an error.
void requireCostMetric(const std::string& metric);

/// How an axis or a column names the error that costStudies makes of `metric`.
std::string errorName(const std::string& metric);

// Of the points that cover all of the study, or null:

/// The fastest whose error is at most `error`; of `method` unless that is empty.
const CostPoint* cheapestReaching(const CostStudy& study, double error,
                                  const std::string& method = {});
/// The one with the least error whose time is at most `ms`.
const CostPoint* bestWithin(const CostStudy& study, double ms);
/// kCostUnit at its defaults, else its fastest setting.
const CostPoint* costUnit(const CostStudy& study);

/// pareto.csv: one line per study and setting, in the conventions of results.csv.
std::string paretoCsv(const std::vector<CostStudy>& studies, const std::string& metric);

}  // namespace penumbra
