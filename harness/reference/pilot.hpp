#pragma once

#include <cstdint>

#include "harness/reference/light_probe.hpp"
#include "harness/reference/replicate_tables.hpp"
#include "harness/reference/silhouette.hpp"

namespace penumbra {

/// A random digital shift of sample points.
struct Shift {
    std::uint32_t x, y;
    explicit Shift(std::uint32_t h) : x(h), y(hash(h ^ 0x68bc21ebu)) {}
    SobolPoint operator()(const SobolPoint& p) const { return {p.x ^ x, p.y ^ y}; }
};

/// What the light looks like from one point at one ray per cell: of a grid of 16 x 16, then of 32 x
/// 32 along the silhouettes seen. It decides where the estimate's rays go; its own are no part of
/// the estimate.
class Pilot {
  public:
    static constexpr int kGrid = ReplicateTables::kGrid;
    static constexpr int kCoarseGrid = ReplicateTables::kCoarseGrid;
    static constexpr int kCoarseRays = kCoarseGrid * kCoarseGrid;

    /// Traces the coarse grid and, unless its rays all agree, the finer one along the silhouettes
    /// as far as they lead; everywhere if they are not resolved.
    void trace(LightProbe& probe, const ReplicateTables& tables, std::uint32_t seed);
    /// Traces what is left of the finer grid.
    void complete(LightProbe& probe, const ReplicateTables& tables);
    /// Takes the surroundings of cells where fresh rays see something else for silhouettes too.
    void refute(const BitGrid<kGrid>& cells);

    bool constant() const { return constant_; }
    double constantVisibility() const { return constantVisibility_; }
    /// About one or two edges across the light, and nobody asked for more: little can have been
    /// missed.
    bool simple() const { return !completed_ && resolved_ && crossings_ <= kSimpleCrossings; }
    /// Whether a neighbour's pilot sees another thing than this one where this one is sure: well
    /// off its silhouettes, that is, which move a little from pixel to pixel. Neither constant.
    bool sureOfOtherThan(const Pilot& neighbour) const;
    int rays() const { return rays_; }
    /// Cell by cell, whether the light is seen; cells along silhouettes are not known.
    const BitGrid<kGrid>& lit() const { return lit_; }
    const BitGrid<kGrid>& silhouette() const { return silhouette_; }
    /// Pairs of cells side by side that differ: the silhouettes' length in cells.
    int crossings() const { return crossings_; }

    /// The cell that a point lies in.
    static Cell cellOf(const SobolPoint& p) {
        static_assert(kGrid == 32);
        return {static_cast<int>(p.x >> 27), static_cast<int>(p.y >> 27)};
    }

  private:
    static constexpr int kSimpleCrossings = 2 * kGrid;
    // By how many cells a silhouette grows where something slipped through the grid.
    static constexpr int kUnresolvedRings = 3;
    static constexpr int kParallaxRings = 3;

    void refine(LightProbe& probe, const ReplicateTables& tables,
                const BitGrid<kCoarseGrid>& wanted);
    void findSilhouette();

    std::uint32_t seed_ = 0;
    BitGrid<kGrid> lit_, silhouette_;
    BitGrid<kCoarseGrid> refined_;
    int crossings_ = 0, rays_ = 0;
    double constantVisibility_ = 1.0;
    bool constant_ = true, resolved_ = true, completed_ = false;
};

}  // namespace penumbra
