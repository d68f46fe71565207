#include "harness/metrics/metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace penumbra {

namespace {

constexpr double kLeakThreshold = 0.05;  ///< umbra pixels brighter than this leak
constexpr double kFalseShadowThreshold =
    0.95;  ///< lit pixels darker than this are falsely shadowed

/// Running sums over the finite pixels of one class. Doubles: a float sum over a million pixels
/// loses the low errors behind the large ones.
struct ErrorSums {
    double sum = 0, sumAbs = 0, sumSquares = 0;
    std::size_t count = 0;

    void add(double error) {
        sum += error;
        sumAbs += std::abs(error);
        sumSquares += error * error;
        ++count;
    }
    std::optional<double> mean(double total) const {
        return count ? std::optional(total / static_cast<double>(count)) : std::nullopt;
    }
    std::optional<double> rms() const {
        return count ? std::optional(std::sqrt(sumSquares / static_cast<double>(count)))
                     : std::nullopt;
    }
};

/// Nearest rank: the ceil(0.99 n)-th smallest value. Reorders `values`, which must not be empty.
double percentile99(std::vector<double>& values) {
    const std::size_t rank = (99 * values.size() + 99) / 100;
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

}  // namespace

Metrics score(std::span<const float> visibility, const Reference& reference,
              const GBuffer& gbuffer) {
    const std::size_t pixels = gbuffer.size();
    if (visibility.size() != pixels || reference.visibility.size() != pixels ||
        reference.standardError.size() != pixels) {
        throw std::invalid_argument(
            fmt::format("score: {} visibility, {} reference and {} G-buffer pixels differ",
                        visibility.size(), reference.visibility.size(), pixels));
    }

    const std::vector<LightClass> classes = classifyLight(reference, gbuffer);
    Metrics metrics;
    ErrorSums all, lit, penumbra, umbra, referenceError;
    std::vector<double> absoluteErrors;
    absoluteErrors.reserve(pixels);
    std::size_t leaks = 0, falseShadows = 0;

    for (std::size_t i = 0; i < pixels; ++i) {
        const PixelClass mask = gbuffer.mask[i];
        if (mask != PixelClass::scored && mask != PixelClass::horizon) continue;
        const bool scored = mask == PixelClass::scored;
        ++(scored ? metrics.scoredPixels : metrics.horizonPixels);

        // The reference's own error does not depend on what the method drew here.
        if (scored && classes[i] == LightClass::penumbra) {
            referenceError.add(reference.standardError[i]);
        }

        const double v = visibility[i];
        if (!std::isfinite(v)) {
            ++metrics.nonfinite;
            continue;
        }
        if (v < 0.0 || v > 1.0) ++metrics.outOfRange;
        if (!scored) continue;

        const double error = v - static_cast<double>(reference.visibility[i]);
        all.add(error);
        absoluteErrors.push_back(std::abs(error));
        switch (classes[i]) {
            case LightClass::lit:
                lit.add(error);
                falseShadows += v < kFalseShadowThreshold;
                break;
            case LightClass::penumbra:
                penumbra.add(error);
                break;
            case LightClass::umbra:
                umbra.add(error);
                leaks += v > kLeakThreshold;
                break;
            case LightClass::none:
                break;
        }
    }

    metrics.rmse = all.rms();
    metrics.mae = all.mean(all.sumAbs);
    metrics.bias = all.mean(all.sum);
    if (!absoluteErrors.empty()) {
        metrics.p99 = percentile99(absoluteErrors);
        metrics.maxError = *std::max_element(absoluteErrors.begin(), absoluteErrors.end());
    }
    metrics.rmseLit = lit.rms();
    metrics.rmsePenumbra = penumbra.rms();
    metrics.rmseUmbra = umbra.rms();
    metrics.leakRate = umbra.mean(static_cast<double>(leaks));
    metrics.falseShadowRate = lit.mean(static_cast<double>(falseShadows));
    metrics.referenceSe = referenceError.rms();
    return metrics;
}

const std::vector<MetricInfo>& allMetrics() {
    static const std::vector<MetricInfo> kMetrics{
        {"rmse", "V",
         "Root mean square error over scored pixels: the headline. Large errors dominate; blind to "
         "sign and place, and diluted where most of the image is plainly lit. Raw: the noise of "
         "the reference (reference_se) is not taken out."},
        {"mae", "V",
         "Mean absolute error over scored pixels: the typical pixel. Blind to sign and place, and "
         "to rare large errors."},
        {"bias", "V",
         "Mean signed error over scored pixels: above 0 the image leaks light, below 0 it is too "
         "dark. Blind to errors that cancel."},
        {"p99", "V",
         "99th percentile (nearest rank) of the absolute error: the worst pixels without single "
         "outliers. Blind to how bad the last hundredth is."},
        {"max_error", "V",
         "Largest absolute error of any scored pixel: sees a single wrong pixel, and an unlucky "
         "reference pixel. Blind to how many there are."},
        {"rmse_lit", "V",
         "rmse over pixels the reference sees fully lit: acne, over-wide penumbrae. Blind to the "
         "shadow itself."},
        {"rmse_penumbra", "V",
         "rmse over pixels the reference sees partly lit: the softness, where soft-shadow "
         "techniques differ. Blind to penumbra drawn outside the true one."},
        {"rmse_umbra", "V",
         "rmse over pixels the reference sees fully shadowed: light leaks. Blind to lit ground."},
        {"leak_rate", "fraction",
         "Umbra pixels with V > 0.05: light bleeding, lost contact shadows. Blind to fainter leaks "
         "and to how bright a leak is."},
        {"false_shadow_rate", "fraction",
         "Lit pixels with V < 0.95: acne, over-wide penumbrae. Blind to fainter darkening and to "
         "how dark it is."},
        {"scored_pixels", "pixels",
         "Surface pixels with the whole light above their horizon: what the headline numbers are "
         "taken over. Says nothing about quality."},
        {"horizon_pixels", "pixels",
         "Surface pixels with part of the light below their horizon: not in the headline numbers. "
         "Says nothing about quality."},
        {"nonfinite", "pixels",
         "Scored or horizon pixels that are NaN or infinite; they are left out of every mean, so a "
         "good rmse beside a count above 0 means nothing."},
        {"out_of_range", "pixels",
         "Finite scored or horizon pixels outside [0,1]; they enter the means as they are. Blind "
         "to how far outside."},
        {"reference_se", "V",
         "Root mean square standard error of the reference over its penumbra pixels: the floor "
         "under which an rmse is noise. Blind to the reference's bias."},
    };
    return kMetrics;
}

}  // namespace penumbra
