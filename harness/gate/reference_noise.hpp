#pragma once

#include <cstddef>

#include "harness/gate/gated_metric.hpp"

namespace penumbra::gate {

/// What is known of the noise that a run's reference leaves in its metrics.
struct ReferenceNoise {
    double standardError = 0.0;      ///< column reference_se: rms over the penumbra pixels
    std::size_t scoredPixels = 0;    ///< column scored_pixels
    std::size_t penumbraPixels = 0;  ///< of run.json; 0: unknown

    static ReferenceNoise of(const Row& row, std::size_t penumbraPixels);
};

/// Standard error that the reference's own gives a metric, in the metric's unit.
///
/// Let e_i = d_i - n_i be a pixel's error, d_i the method's own and n_i the reference's with
/// standard error s_i, independent between pixels. Then Var(mean e) = mean(s^2) / N, and
/// Var(mean e^2) <= 4 max(s^2) mean(d^2) / N to first order, so by the delta method a root mean
/// square has a standard error of at most s / sqrt(N) however the method's errors are distributed.
/// meanOfAll divides by the scored pixels, meanOfPenumbra by those in penumbra (by 1 where their
/// number is unknown). Adaptive stopping keeps s_i nearly equal, so that the column's rms stands
/// for it.
///
/// onePixel does not divide: for a quantile, for means over pixels that noise moves from one class
/// into the other, and for metrics that answer to V by a slope of about one (ssim, flip, widths),
/// where s itself is a safe bound. worstPixel is the greatest of N normal draws, s sqrt(2 ln N).
double standardErrorOf(Noise kind, const ReferenceNoise& noise);

/// The greatest change of a metric that two runs' references explain between them: kSigmas standard
/// errors of the difference, and what a reference of another standard error adds to a root mean
/// square, sqrt(before^2 + |sa^2 - sb^2|) - before.
double explainedByNoise(Noise kind, double before, const ReferenceNoise& baseline,
                        const ReferenceNoise& run);

/// A run has some 25,000 comparisons of accuracy; a one-sided tail of 2.9e-7 leaves it a chance of
/// less than 1 % that noise alone makes one of them fail.
inline constexpr double kSigmas = 5.0;

}  // namespace penumbra::gate
