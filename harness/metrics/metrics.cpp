#include "harness/metrics/metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "harness/metrics/error_sums.hpp"
#include "harness/metrics/noise.hpp"

namespace penumbra {

namespace {

constexpr double kLeakThreshold = 0.05;  ///< umbra pixels brighter than this leak
constexpr double kFalseShadowThreshold =
    0.95;  ///< lit pixels darker than this are falsely shadowed

/// Whether the reference's standard error at a pixel is the measured spread of its replicates.
/// Where all rays agree it is the bound 3/n on what they may have missed, far above the expected
/// error.
bool hasMeasuredError(float visibility) {
    return visibility > 0.0F && visibility < 1.0F;
}

}  // namespace

Scorer::Scorer(const Reference& reference, const GBuffer& gbuffer,
               std::span<const ShadowEdge> edges)
    : reference_(reference), gbuffer_(gbuffer) {
    const std::size_t pixels = gbuffer.size();
    if (reference.visibility.size() != pixels || reference.standardError.size() != pixels) {
        throw std::invalid_argument(fmt::format("score: {} reference and {} G-buffer pixels differ",
                                                reference.visibility.size(), pixels));
    }
    classes_ = classifyLight(reference, gbuffer);
    light_ = pictureLight(gbuffer);
    ssim_ = prepareSsim(gbuffer.width, gbuffer.height, reference.visibility);
    flip_ = prepareFlip(shadeVisibility(gbuffer, reference.visibility, light_));
    for (const ShadowEdge& edge : edges) {
        EdgeScan scan = scanEdge(edge, gbuffer);
        if (const auto truth = scan.measured(reference.visibility))
            edges_.push_back({std::move(scan), *truth});
    }
}

Metrics Scorer::score(std::span<const float> visibility) const {
    const std::size_t pixels = gbuffer_.size();
    if (visibility.size() != pixels) {
        throw std::invalid_argument(fmt::format(
            "score: {} visibility and {} G-buffer pixels differ", visibility.size(), pixels));
    }
    Metrics metrics;
    ErrorSums all, lit, penumbra, umbra, referenceError;
    double referenceVariance = 0;  // summed over the pixels of `all`
    std::vector<double> absoluteErrors;
    absoluteErrors.reserve(pixels);
    std::size_t leaks = 0, falseShadows = 0;

    for (std::size_t i = 0; i < pixels; ++i) {
        const PixelClass mask = gbuffer_.mask[i];
        if (mask != PixelClass::scored && mask != PixelClass::horizon) continue;
        const bool scored = mask == PixelClass::scored;
        ++(scored ? metrics.scoredPixels : metrics.horizonPixels);

        // The reference's own error does not depend on what the method drew here.
        if (scored && classes_[i] == LightClass::penumbra) {
            referenceError.add(reference_.standardError[i]);
        }

        const double v = visibility[i];
        if (!std::isfinite(v)) {
            ++metrics.nonfinite;
            continue;
        }
        if (v < 0.0 || v > 1.0) ++metrics.outOfRange;
        if (!scored) continue;

        const double error = v - static_cast<double>(reference_.visibility[i]);
        all.add(error);
        if (hasMeasuredError(reference_.visibility[i])) {
            const double standardError = reference_.standardError[i];
            referenceVariance += standardError * standardError;
        }
        absoluteErrors.push_back(std::abs(error));
        switch (classes_[i]) {
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
    if (all.count) {
        const double excess = all.sumSquares - referenceVariance;
        metrics.rmseCorrected = std::sqrt(std::max(0.0, excess) / static_cast<double>(all.count));
    }
    scoreNeighbourhoods(visibility, metrics);
    scoreEdges(visibility, metrics);
    return metrics;
}

void Scorer::scoreNeighbourhoods(std::span<const float> visibility, Metrics& metrics) const {
    // Where nobody answers, and at non-finite pixels, the image gets the reference's value, so that
    // what it holds there does not show in its neighbours' numbers.
    std::vector<float> seen = reference_.visibility;
    std::vector<std::uint8_t> counted(seen.size(), 0);
    for (std::size_t i = 0; i < seen.size(); ++i) {
        if (gbuffer_.mask[i] != PixelClass::scored || !std::isfinite(visibility[i])) continue;
        seen[i] = visibility[i];
        counted[i] = 1;
    }
    const FlipImage picture = prepareFlip(shadeVisibility(gbuffer_, seen, light_));
    metrics.flip = meanWhere(flipErrors(flip_, picture), counted);
    metrics.ssim =
        ssim(ssim_, prepareSsim(gbuffer_.width, gbuffer_.height, std::move(seen)), counted);
    metrics.noise = noise(visibility, reference_, gbuffer_, classes_);
}

void Scorer::scoreEdges(std::span<const float> visibility, Metrics& metrics) const {
    if (edges_.empty()) return;
    double width = 0, shift = 0;
    for (const Edge& edge : edges_) {
        const std::optional<EdgeProfile> seen = edge.scan.measured(visibility);
        // Means over fewer edges than another image's would not compare.
        if (!seen) return;
        const EdgeError error = compareEdges(*seen, edge.truth);
        width += error.width;
        shift += error.centreShift;
    }
    metrics.penumbraWidthError = width / static_cast<double>(edges_.size());
    metrics.penumbraShift = shift / static_cast<double>(edges_.size());
}

const std::vector<MetricInfo>& allMetrics() {
    static const std::vector<MetricInfo> kMetrics{
        {"rmse", "V",
         "Root mean square error over scored pixels: the headline. Large errors dominate; blind to "
         "sign and place, and diluted where most of the image is plainly lit. Raw: the noise of "
         "the reference is not taken out (rmse_corrected)."},
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
        {"ssim", "1",
         "Structural similarity of visibility (11x11 Gaussian, sigma 1.5, L = 1) over scored "
         "pixels "
         "five or more from the border; 1 is equal, may be below 0. Sees lost or invented "
         "structure, "
         "such as grain, banding and missing detail. Blind to large errors beside strong edges, "
         "over-sensitive in flat regions, diluted where the image is plainly lit; never read it "
         "alone."},
        {"flip", "FLIP",
         "Mean LDR-FLIP over scored pixels between the shaded pictures, both under one fixed "
         "exposure, at 67.0206 pixels per degree: what an observer sees who flips between them; 0 "
         "is equal, 1 the most. Blind to what that observer cannot see: fine grain, and errors on "
         "dark or poorly lit surfaces."},
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
        {"noise", "V",
         "Root mean square, over penumbra pixels, of the error minus its 5x5 mean: grain, dither, "
         "banding and shadow-map steps, which FLIP hides by design. Blind to smooth error of any "
         "size and to blotches wider than five pixels. Contains the reference's own noise."},
        {"flicker", "V",
         "Mean |change of V - change of the reference| since the frame before, over pixels that "
         "show "
         "the same point in both: shimmering and popping under moving lights and casters. Blind to "
         "error that stands still; absent for first frames and where the camera moved."},
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
        {"rmse_corrected", "V",
         "rmse with the reference's noise taken out: sqrt(rmse^2 - mean squared standard error), 0 "
         "where noise explains it all. Pixels whose reference rays all agree subtract nothing. "
         "Else as rmse; blind to the reference's bias."},
        {"penumbra_width_error", "Wref",
         "(W - Wref) / Wref over the scene's straight shadow edges, W the 10-90 % width across the "
         "edge: above 0 the penumbra is too wide, -1 is a hard shadow (less a pixel). Blind to its "
         "place, its profile and all other shadows; errors of opposite sign on two edges cancel. "
         "Absent where an edge is not dark on one side and lit on the other."},
        {"penumbra_shift", "Wref",
         "How far the penumbra's centre lies towards the light of where the reference has it: "
         "above 0 the shadow is too large, below 0 too small, as under a wrong bias. Blind as "
         "penumbra_width_error is, and to the width."},
    };
    return kMetrics;
}

}  // namespace penumbra
