#include "harness/gate/gated_metric.hpp"

#include <cmath>
#include <stdexcept>

namespace penumbra::gate {
namespace {

constexpr double kHalfReferenceSe = 0.5 / 1024;  ///< of the default --reference-se

constexpr std::string_view kMeanReason =
    "an image is deterministic on one renderer; another one's rounding moves means by less";
constexpr std::string_view kPixelReason = "decided by few pixels, which rounding can move";
constexpr std::string_view kEdgeReason = "a fiftieth of the penumbra's width is below what shows";
constexpr std::string_view kExactReason = "work is counted, not measured: any more of it is more";
constexpr std::string_view kNoneReason = "not one pixel more may be wrong in this way";

}  // namespace

std::string_view nameOf(Kind kind) {
    switch (kind) {
        case Kind::row:
            return "row";
        case Kind::accuracy:
            return "accuracy";
        case Kind::time:
            return "time";
        case Kind::work:
            return "work";
        case Kind::effects:
            return "effects";
    }
    throw std::logic_error("no such kind of gate");
}

const std::vector<GatedMetric>& gatedMetrics() {
    using enum Kind;
    using enum Better;
    static const std::vector<GatedMetric> kMetrics = {
        {"frame_ms", time, lower, Noise::none, 0.10, 0.0,
         "a tenth is what a change of method shows and a change of weather does not"},
        {"draw_calls", work, lower, Noise::none, 0.0, 0.0, kExactReason},
        {"triangles", work, lower, Noise::none, 0.0, 0.0, kExactReason},
        {"fragments", work, lower, Noise::none, 0.0, 0.0, kExactReason},
        {"maps", work, lower, Noise::none, 0.0, 0.0, kExactReason},
        {"light_texels", work, lower, Noise::none, 0.0, 0.0, kExactReason},
        {"texture_mib", work, lower, Noise::none, 0.0, 0.0, kExactReason},
        {"rmse", accuracy, lower, Noise::meanOfAll, 0.02, kHalfReferenceSe, kMeanReason},
        {"mae", accuracy, lower, Noise::meanOfAll, 0.02, kHalfReferenceSe, kMeanReason},
        {"bias", accuracy, nearZero, Noise::meanOfAll, 0.02, kHalfReferenceSe, kMeanReason},
        {"p99", accuracy, lower, Noise::onePixel, 0.02, 0.002, kPixelReason},
        {"max_error", accuracy, lower, Noise::worstPixel, 0.05, 0.02, kPixelReason},
        {"ssim", accuracy, higher, Noise::onePixel, 0.02, 0.001, kMeanReason},
        {"flip", accuracy, lower, Noise::onePixel, 0.02, kHalfReferenceSe, kMeanReason},
        {"rmse_lit", accuracy, lower, Noise::onePixel, 0.02, kHalfReferenceSe, kMeanReason},
        {"rmse_penumbra", accuracy, lower, Noise::meanOfPenumbra, 0.02, kHalfReferenceSe,
         kMeanReason},
        {"rmse_umbra", accuracy, lower, Noise::onePixel, 0.02, kHalfReferenceSe, kMeanReason},
        {"leak_rate", accuracy, lower, Noise::onePixel, 0.02, kHalfReferenceSe, kMeanReason},
        {"false_shadow_rate", accuracy, lower, Noise::onePixel, 0.02, kHalfReferenceSe,
         kMeanReason},
        {"noise", accuracy, lower, Noise::meanOfPenumbra, 0.02, kHalfReferenceSe, kMeanReason},
        {"flicker", accuracy, lower, Noise::onePixel, 0.02, kHalfReferenceSe, kMeanReason},
        {"scored_pixels", accuracy, unchanged, Noise::none, 0.001, 0.0,
         "the same points are judged, but for silhouettes that another machine's rounding moves",
         true},
        {"horizon_pixels", accuracy, unchanged, Noise::none, 0.001, 16.0,
         "the same points are judged, but for silhouettes that another machine's rounding moves",
         true},
        {"nonfinite", accuracy, lower, Noise::none, 0.0, 0.0, kNoneReason},
        {"out_of_range", accuracy, lower, Noise::none, 0.0, 0.0, kNoneReason},
        {"reference_se", accuracy, lower, Noise::none, 0.25, 1e-5,
         "a noisier reference hides regressions of accuracy", true},
        {"rmse_corrected", accuracy, lower, Noise::meanOfAll, 0.02, kHalfReferenceSe, kMeanReason},
        {"penumbra_width_error", accuracy, nearZero, Noise::onePixel, 0.02, 0.02, kEdgeReason},
        {"penumbra_shift", accuracy, nearZero, Noise::onePixel, 0.02, 0.02, kEdgeReason},
    };
    return kMetrics;
}

double worsening(const GatedMetric& metric, double before, double after) {
    switch (metric.better) {
        case Better::lower:
            return after - before;
        case Better::higher:
            return before - after;
        case Better::nearZero:
            return std::abs(after) - std::abs(before);
        case Better::unchanged:
            return std::abs(after - before);
    }
    throw std::logic_error("no such direction");
}

double scaleOf(const GatedMetric& metric, double before) {
    // The one metric that is better when higher is ssim, best at 1.
    return std::abs(metric.better == Better::higher ? 1.0 - before : before);
}

}  // namespace penumbra::gate
