#pragma once

#include <cstdint>

#include "harness/reference/light_probe.hpp"
#include "harness/reference/pilot.hpp"
#include "harness/reference/replicate_tables.hpp"

namespace penumbra {

struct PixelEstimate {
    double visibility = 1.0;
    double standardError = 0.0;  ///< of visibility; 3/rays where all rays agree
    double shading = 1.0;        ///< visible part of the light's irradiance, sum(w v) / sum(w)
    int rays = 0;
    bool constant = true;  ///< all rays agree
};

/// Estimates one pixel's visibility to a wanted standard error with as few rays as it can. The
/// estimate is the mean of R independent replicates and its error their spread; a pilot only
/// decides where rays go, and its own rays are not part of the estimate, which so stays unbiased.
///
/// 1. Pilot: 256 rays, one per cell of a 16 x 16 grid on the light. All agree: done. Otherwise up
///    to 768 more refine the grid to 32 x 32 along the silhouettes it sees; everywhere if a
///    neighbouring pixel's pilot sees another thing where this one is sure.
/// 2. Where silhouettes are few: cells with like neighbours only are taken at the pilot's
///    word, which a sparse set of fresh rays must confirm, and the replicates sample nothing but
///    the cells along the silhouettes.
/// 3. Manifold casters, or where the confirmation failed: each replicate samples the whole
///    light.
///
/// Sample counts are predicted from the length of the silhouette on the pilot's grid and the rate
/// n^-3/4 of nets at edges (METHODS.md R4), then extended as the measured error demands.
class PixelEstimator {
  public:
    PixelEstimator(const ReplicateTables& tables, double targetStandardError, int maxRays);

    PixelEstimate adaptive(LightProbe& probe, std::uint32_t seed) const;
    /// The same in steps: a pilot that neighbours may be asked about, ...
    Pilot look(LightProbe& probe, std::uint32_t seed) const;
    /// ... the rest of its rays where they see more than it does, ...
    void lookCloser(LightProbe& probe, Pilot& pilot) const;
    /// ... and the estimate.
    PixelEstimate finish(LightProbe& probe, std::uint32_t seed, Pilot& pilot) const;
    /// For a pixel whose pilot was constant although a neighbour's was not: kGuardPoints per
    /// replicate over the whole light, and on to the target if they do not all agree with the
    /// pilot.
    PixelEstimate guard(LightProbe& probe, std::uint32_t seed, const PixelEstimate& pilot) const;
    /// maxRays over the whole light, whatever they show.
    PixelEstimate uniform(LightProbe& probe, std::uint32_t seed) const;

    static constexpr int kGuardPoints = 64;

  private:
    struct Sums;
    class Collector;

    /// Whether fresh rays see what the pilot says off the silhouettes. Where they do not, the
    /// silhouettes grow by the surroundings, and may be confirmed by another seed.
    bool confirm(LightProbe& probe, std::uint32_t seed, Pilot& pilot, int& rays) const;
    struct Weights {
        double lit = 0.0, all = 0.0;
    };
    /// Sums over the cells off the silhouettes, by the midpoint rule.
    static Weights weightsOff(LightProbe& probe, const Pilot& pilot);
    PixelEstimate alongSilhouette(LightProbe& probe, std::uint32_t seed, const Pilot& pilot,
                                  int raysSpent) const;
    PixelEstimate wholeLight(LightProbe& probe, std::uint32_t seed, int points, int raysSpent,
                             bool extend) const;
    /// Points per replicate over the whole light for the target, from the silhouettes' length in
    /// cells of a grid of kGrid.
    double predictPoints(int crossings) const;
    int extended(int points, double standardError) const;

    const ReplicateTables& tables_;
    double target_;
    int maxRays_;
};

}  // namespace penumbra
