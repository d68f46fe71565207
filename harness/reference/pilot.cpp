#include "harness/reference/pilot.hpp"

#include <array>
#include <bit>

namespace penumbra {

void Pilot::trace(LightProbe& probe, const ReplicateTables& tables, std::uint32_t seed) {
    seed_ = seed;
    const Shift shift(seed);
    LightBatch batch;
    static_assert(kCoarseRays == LightBatch::kCapacity);
    const SobolPoint* const points = tables.coarsePilot();
    for (int i = 0; i < kCoarseRays; ++i) {
        const SobolPoint p = shift(points[i]);
        batch.s[i] = toUnitFloat(p.x);
        batch.t[i] = toUnitFloat(p.y);
    }
    batch.size = kCoarseRays;
    probe.look(batch);
    rays_ += kCoarseRays;
    BitGrid<kCoarseGrid> coarse;
    for (int i = 0; i < kCoarseRays; ++i) {
        const Cell cell = cellOf(shift(points[i]));
        if (batch.visible[i]) coarse.set({cell.x / 2, cell.y / 2});
    }
    const int litCount = coarse.count();
    constant_ = litCount == 0 || litCount == kCoarseRays;
    constantVisibility_ = litCount == 0 ? 0.0 : 1.0;
    if (constant_) return;

    for (int y = 0; y < kGrid; ++y)
        for (int x = 0; x < kGrid; ++x)
            if (coarse[{x / 2, y / 2}]) lit_.set({x, y});
    if (!Silhouette<kCoarseGrid>(coarse).resolved) refine(probe, tables, refined_.complement());
    for (;;) {
        const BitGrid<kCoarseGrid> wanted =
            Silhouette<kGrid>(lit_).cells.coarser() & refined_.complement();
        if (wanted.count() == 0) break;
        refine(probe, tables, wanted);
    }
    findSilhouette();
}

void Pilot::complete(LightProbe& probe, const ReplicateTables& tables) {
    refine(probe, tables, refined_.complement());
    findSilhouette();
    completed_ = true;
}

void Pilot::refine(LightProbe& probe, const ReplicateTables& tables,
                   const BitGrid<kCoarseGrid>& wanted) {
    const Shift shift(seed_);
    LightBatch batch;
    std::array<Cell, LightBatch::kCapacity> cells;
    const auto flush = [&] {
        probe.look(batch);
        rays_ += static_cast<int>(batch.size);
        for (std::size_t i = 0; i < batch.size; ++i) lit_.assign(cells[i], batch.visible[i] != 0);
        batch.size = 0;
    };
    for (int y = 0; y < kCoarseGrid; ++y)
        for (std::uint32_t left = wanted.row[y]; left != 0; left &= left - 1) {
            // A digital shift moves whole cells.
            const int x = std::countr_zero(left);
            const SobolPoint* const points = tables.finePilot(x ^ static_cast<int>(shift.x >> 28),
                                                              y ^ static_cast<int>(shift.y >> 28));
            for (int i = 0; i < 3; ++i) {
                const SobolPoint p = shift(points[i]);
                batch.s[batch.size] = toUnitFloat(p.x);
                batch.t[batch.size] = toUnitFloat(p.y);
                cells[batch.size] = cellOf(p);
                if (++batch.size == LightBatch::kCapacity) flush();
            }
        }
    if (batch.size > 0) flush();
    refined_ = refined_ | wanted;
}

void Pilot::findSilhouette() {
    const Silhouette<kGrid> seen(lit_);
    resolved_ = seen.resolved;
    // What slips through the grid here and there, a wire say, is near where it does not.
    silhouette_ = resolved_ ? seen.cells : seen.cells.grown(kUnresolvedRings);
    crossings_ = 0;
    for (int y = 0; y < kGrid; ++y) {
        crossings_ += std::popcount((lit_.row[y] ^ (lit_.row[y] >> 1)) & 0x7fffffffu);
        if (y + 1 < kGrid) crossings_ += std::popcount(lit_.row[y] ^ lit_.row[y + 1]);
    }
}

bool Pilot::sureOfOtherThan(const Pilot& other) const {
    const BitGrid<kGrid> unsure = silhouette_.grown(kParallaxRings);
    for (int y = 0; y < kGrid; ++y)
        if ((lit_.row[y] ^ other.lit_.row[y]) & ~unsure.row[y]) return true;
    return false;
}

void Pilot::refute(const BitGrid<kGrid>& cells) {
    resolved_ = false;
    silhouette_ = silhouette_ | cells.grown(kUnresolvedRings);
}

}  // namespace penumbra
