#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/sampling/sampling.hpp"
#include "core/trace/tracer.hpp"

namespace penumbra {

/// Points of the light, in its (s, t) in [0,1)^2, and what one pixel sees of them.
struct LightBatch {
    static constexpr std::size_t kCapacity = Tracer::kStreamSize;
    std::size_t size = 0;
    std::array<float, kCapacity> s, t;
    std::array<float, kCapacity> weight;  ///< max(0, cosP) max(0, cosL) / r^2
    std::array<std::uint8_t, kCapacity> visible;
};

/// One pixel's view of the light.
class LightProbe {
  public:
    virtual ~LightProbe() = default;
    /// Fills `weight`.
    virtual void weigh(LightBatch& batch) = 0;
    /// Fills `visible`, one ray per point.
    virtual void look(LightBatch& batch) = 0;
};

/// The first points of R independent Owen-scrambled Sobol sequences, shared by all pixels. XOR with
/// a random word per dimension (a digital shift) makes of each a further one that keeps the net
/// property, so a pixel pays one XOR per coordinate for its own samples.
class ReplicateTables {
  public:
    static constexpr int kReplicates = 16;
    /// Of the pilot's cells, coarse first: its first 16 x 16 points are one in each of 16 x 16
    /// cells.
    static constexpr int kCoarseGrid = 16, kGrid = 32;

    explicit ReplicateTables(int points);
    /// Points between two lengths in use are sorted so that consecutive rays are close together: in
    /// Morton order over the light, or by x for sampling along a list.
    const SobolPoint* overLight(int r) const { return overLight_[r].data(); }
    const SobolPoint* alongList(int r) const { return alongList_[r].data(); }
    const std::vector<SobolPoint>& pilot() const { return pilot_; }
    int size() const { return static_cast<int>(overLight_[0].size()); }

    /// Lengths in use: 2^k and 3 * 2^(k-1).
    static int roundUp(double n);
    static int roundDown(double n);

  private:
    std::array<std::vector<SobolPoint>, kReplicates> overLight_, alongList_;
    std::vector<SobolPoint> pilot_;
};

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
///    to 768 more refine the grid to 32 x 32 along the silhouettes it sees.
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
    /// For a pixel whose pilot was constant although a neighbour's was not: kGuardPoints per
    /// replicate over the whole light, and on to the target if they do not all agree with the
    /// pilot.
    PixelEstimate guard(LightProbe& probe, std::uint32_t seed, const PixelEstimate& pilot) const;
    /// maxRays over the whole light, whatever they show.
    PixelEstimate uniform(LightProbe& probe, std::uint32_t seed) const;

    static constexpr int kGuardPoints = 64;

  private:
    class Pilot;
    struct Sums;
    class Collector;

    /// Whether fresh rays see what the pilot says off the silhouettes. Where they do not, the
    /// silhouettes grow by the surroundings, and may be confirmed by another seed.
    bool confirm(LightProbe& probe, std::uint32_t seed, Pilot& pilot, int& rays) const;
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
