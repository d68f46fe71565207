#include "harness/reference/pixel_estimator.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace penumbra {

namespace {

constexpr int kReplicates = ReplicateTables::kReplicates;
constexpr int kGrid = Pilot::kGrid;
constexpr int kCells = kGrid * kGrid;

// More cells than this and sampling only them saves too little to pay for the confirmation.
constexpr int kMaxSilhouetteCells = kCells * 3 / 5;
// Confirming rays per replicate over the whole light (those in silhouette cells are left out): few
// where an edge or two cross the light and the grid resolves them, more elsewhere.
constexpr int kConfirmPoints = 16, kConfirmPointsElse = 48;
constexpr int kConfirmAttempts = 2;
constexpr int kMinWholeLightPoints = 32;
// Squared error of n net points in a unit square crossed by one edge: 0.36^2 n^-3/2 (METHODS.md
// R4).
constexpr double kEdgeVariance = 0.13;
// A pixel is extended only when clearly above the target: 16 replicates know their own error to 18
// % only, and stopping on the first lucky value below a tight limit would make the reported errors
// too small.
constexpr double kTolerance = 1.2;

enum Salt : std::uint32_t { kPilotSalt = 1, kConfirmSalt, kSilhouetteSalt, kWholeSalt };

}  // namespace

struct PixelEstimator::Sums {
    std::array<int, kReplicates> hits{};
    double weightLit = 0.0, weightAll = 0.0;
    int rays = 0;
};

/// Gathers points into streams and adds up what they see.
class PixelEstimator::Collector {
  public:
    Collector(LightProbe& probe, Sums& sums) : probe_(probe), sums_(sums) {}

    /// `count` points of one replicate, each mapped to where on the light it lies.
    template <class Map>
    void add(int replicate, const SobolPoint* points, int count, const Map& map) {
        while (count > 0) {
            const int room = static_cast<int>(LightBatch::kCapacity - batch_.size);
            const int n = std::min(count, room);
            float* const s = batch_.s.data() + batch_.size;
            float* const t = batch_.t.data() + batch_.size;
            for (int i = 0; i < n; ++i) {
                const SobolPoint p = map(points[i]);
                s[i] = toUnitFloat(p.x);
                t[i] = toUnitFloat(p.y);
            }
            batch_.size += n;
            runs_[runCount_++] = {replicate, batch_.size};
            if (n == room) flush();
            points += n;
            count -= n;
        }
    }

    void flush() {
        probe_.look(batch_);
        probe_.weigh(batch_);
        float lit = 0.0f, all = 0.0f;
        std::size_t i = 0;
        for (int run = 0; run < runCount_; ++run) {
            int hits = 0;
            for (; i < runs_[run].end; ++i) {
                hits += batch_.visible[i];
                all += batch_.weight[i];
                lit += static_cast<float>(batch_.visible[i]) * batch_.weight[i];
            }
            sums_.hits[runs_[run].replicate] += hits;
        }
        sums_.weightLit += lit;
        sums_.weightAll += all;
        sums_.rays += static_cast<int>(batch_.size);
        batch_.size = 0;
        runCount_ = 0;
    }

  private:
    struct Run {
        int replicate;
        std::size_t end;  ///< in the batch
    };
    LightProbe& probe_;
    Sums& sums_;
    LightBatch batch_;
    std::array<Run, LightBatch::kCapacity> runs_;
    int runCount_ = 0;
};

namespace {

struct MeanAndError {
    double mean, standardError;
};

/// Mean of the replicates base + scale * hits and its standard error. A replicate moves in steps of
/// `scale`: along an edge parallel to the light's sides all replicates can agree on k steps and yet
/// all be off by part of one. The error of their mean by that is of the order of 1/N, N = all
/// points.
MeanAndError spread(const std::array<int, kReplicates>& hits, double base, double scale) {
    double sum = 0.0, squares = 0.0;
    for (const int h : hits) sum += h;
    const double mean = sum / kReplicates;
    for (const int h : hits) squares += (h - mean) * (h - mean);
    const double variance = squares / (kReplicates - 1) / kReplicates;
    const double resolution = 1.0 / kReplicates;
    return {base + scale * mean, scale * std::sqrt(variance + resolution * resolution)};
}

}  // namespace

PixelEstimator::PixelEstimator(const ReplicateTables& tables, double targetStandardError,
                               int maxRays)
    : tables_(tables), target_(targetStandardError), maxRays_(maxRays) {}

double PixelEstimator::predictPoints(int crossings) const {
    // One edge across the light crosses about kGrid cells; variances of edges add.
    return std::pow(kEdgeVariance * crossings / kGrid / (kReplicates * target_ * target_),
                    2.0 / 3.0);
}

int PixelEstimator::extended(int points, double standardError) const {
    const double wanted = points * std::pow(standardError / target_, 4.0 / 3.0);
    return std::max(ReplicateTables::roundUp(points + 1),
                    ReplicateTables::roundUp(std::min(wanted, 4.0 * points)));
}

PixelEstimate PixelEstimator::adaptive(LightProbe& probe, std::uint32_t seed) const {
    Pilot pilot = look(probe, seed);
    return finish(probe, seed, pilot);
}

Pilot PixelEstimator::look(LightProbe& probe, std::uint32_t seed) const {
    Pilot pilot;
    pilot.trace(probe, tables_, hash(seed, kPilotSalt));
    return pilot;
}

void PixelEstimator::lookCloser(LightProbe& probe, Pilot& pilot) const {
    pilot.complete(probe, tables_);
}

PixelEstimate PixelEstimator::finish(LightProbe& probe, std::uint32_t seed, Pilot& pilot) const {
    int rays = pilot.rays();
    if (pilot.constant()) {
        const double value = pilot.constantVisibility();
        return {value, 3.0 / rays, value, rays, true};
    }
    for (std::uint32_t attempt = 0; attempt < kConfirmAttempts; ++attempt)
        if (pilot.silhouette().count() > kMaxSilhouetteCells)
            break;
        else if (confirm(probe, hash(seed, kConfirmSalt, attempt), pilot, rays))
            return alongSilhouette(probe, seed, pilot, rays);
    const int points = ReplicateTables::roundUp(predictPoints(pilot.crossings()));
    return wholeLight(probe, seed, std::max(kMinWholeLightPoints, points), rays, true);
}

bool PixelEstimator::confirm(LightProbe& probe, std::uint32_t seed, Pilot& pilot, int& rays) const {
    const BitGrid<kGrid>& silhouette = pilot.silhouette();
    LightBatch batch;
    std::array<Cell, LightBatch::kCapacity> cells;
    BitGrid<kGrid> refuted;
    const auto flush = [&] {
        probe.look(batch);
        rays += static_cast<int>(batch.size);
        for (std::size_t i = 0; i < batch.size; ++i)
            if ((batch.visible[i] != 0) != pilot.lit()[cells[i]]) refuted.set(cells[i]);
        batch.size = 0;
    };
    const int points =
        std::min(tables_.size(), pilot.simple() ? kConfirmPoints : kConfirmPointsElse);
    for (int r = 0; r < kReplicates; ++r) {
        const Shift shift(hash(seed, r));
        for (int i = 0; i < points; ++i) {
            const SobolPoint p = shift(tables_.overLight(r)[i]);
            const Cell cell = Pilot::cellOf(p);
            if (silhouette[cell]) continue;
            batch.s[batch.size] = toUnitFloat(p.x);
            batch.t[batch.size] = toUnitFloat(p.y);
            cells[batch.size] = cell;
            if (++batch.size == LightBatch::kCapacity) flush();
        }
    }
    flush();
    if (refuted.count() == 0) return true;
    pilot.refute(refuted);
    return false;
}

PixelEstimator::Weights PixelEstimator::weightsOff(LightProbe& probe, const Pilot& pilot) {
    constexpr int kRows = LightBatch::kCapacity / kGrid;
    const BitGrid<kGrid>& silhouette = pilot.silhouette();
    Weights sums;
    LightBatch centres;
    centres.size = LightBatch::kCapacity;
    for (int top = 0; top < kGrid; top += kRows) {
        for (int i = 0; i < kRows * kGrid; ++i) {
            centres.s[i] = (static_cast<float>(i % kGrid) + 0.5f) / kGrid;
            centres.t[i] = (static_cast<float>(top + i / kGrid) + 0.5f) / kGrid;
        }
        probe.weigh(centres);
        for (int i = 0; i < kRows * kGrid; ++i) {
            const Cell cell{i % kGrid, top + i / kGrid};
            if (silhouette[cell]) continue;
            sums.all += centres.weight[i];
            if (pilot.lit()[cell]) sums.lit += centres.weight[i];
        }
    }
    return sums;
}

PixelEstimate PixelEstimator::alongSilhouette(LightProbe& probe, std::uint32_t seed,
                                              const Pilot& pilot, int raysSpent) const {
    const BitGrid<kGrid>& silhouette = pilot.silhouette();
    // The silhouettes' cells in rows, every other one backwards, so that neighbours in the list are
    // neighbours on the light as far as can be.
    std::array<Cell, kMaxSilhouetteCells> list;
    std::uint32_t cells = 0;
    int litCells = 0;
    for (int y = 0; y < kGrid; ++y) {
        litCells += std::popcount(pilot.lit().row[y] & ~silhouette.row[y]);
        for (std::uint32_t left = silhouette.row[y]; left != 0;) {
            const int x = y % 2 == 0 ? std::countr_zero(left) : 31 - std::countl_zero(left);
            list[cells++] = {x, y};
            left &= ~(1u << x);
        }
    }
    auto [weightLit, weightAll] = weightsOff(probe, pilot);

    const double area = static_cast<double>(cells) / kCells;
    const int affordable = std::max(1, (maxRays_ - raysSpent) / kReplicates);
    const int cap = std::min(tables_.size(), ReplicateTables::roundDown(affordable));
    // The cells hold the density that the whole light would need, and no more is wanted.
    int points = std::min(cap, ReplicateTables::roundUp(area * predictPoints(pilot.crossings())));
    int done = 0;
    Sums sums;
    Collector collector(probe, sums);
    for (;;) {
        for (int r = 0; r < kReplicates; ++r) {
            const Shift shift(hash(seed, kSilhouetteSalt, r));
            const auto place = [&](const SobolPoint& point) {
                // The first coordinate runs along the list and, within a cell, across it.
                const SobolPoint p = shift(point);
                const std::uint64_t along = static_cast<std::uint64_t>(p.x) * cells;
                const Cell cell = list[along >> 32];
                return SobolPoint{(static_cast<std::uint32_t>(cell.x) << 27) |
                                      (static_cast<std::uint32_t>(along) >> 5),
                                  (static_cast<std::uint32_t>(cell.y) << 27) | (p.y >> 5)};
            };
            collector.add(r, tables_.alongList(r) + done, points - done, place);
        }
        collector.flush();
        done = points;
        const MeanAndError result =
            spread(sums.hits, static_cast<double>(litCells) / kCells, area / done);
        if (result.standardError <= kTolerance * target_ || done == cap) {
            const double perCell = static_cast<double>(cells) / (kReplicates * done);
            weightLit += perCell * sums.weightLit;
            weightAll += perCell * sums.weightAll;
            return {result.mean, result.standardError,
                    weightAll > 0.0 ? weightLit / weightAll : 0.0, raysSpent + sums.rays, false};
        }
        points = std::min(cap, extended(done, result.standardError));
    }
}

PixelEstimate PixelEstimator::wholeLight(LightProbe& probe, std::uint32_t seed, int points,
                                         int raysSpent, bool extend) const {
    const int cap =
        std::min(tables_.size(),
                 ReplicateTables::roundDown(std::max(1, (maxRays_ - raysSpent) / kReplicates)));
    Sums sums;
    Collector collector(probe, sums);
    int done = 0;
    points = std::min(points, cap);
    for (;;) {
        for (int r = 0; r < kReplicates; ++r) {
            const Shift shift(hash(seed, kWholeSalt, r));
            collector.add(r, tables_.overLight(r) + done, points - done, shift);
        }
        collector.flush();
        done = points;
        const int total = kReplicates * done;
        int hits = 0;
        for (const int h : sums.hits) hits += h;
        if (hits == 0 || hits == total) {
            const double value = hits == 0 ? 0.0 : 1.0;
            const int rays = raysSpent + sums.rays;
            return {value, 3.0 / rays, value, rays, true};
        }
        const MeanAndError result = spread(sums.hits, 0.0, 1.0 / done);
        if (!extend || result.standardError <= kTolerance * target_ || done == cap) {
            const double shading = sums.weightAll > 0.0 ? sums.weightLit / sums.weightAll : 0.0;
            return {result.mean, result.standardError, shading, raysSpent + sums.rays, false};
        }
        points = std::min(cap, extended(done, result.standardError));
    }
}

PixelEstimate PixelEstimator::guard(LightProbe& probe, std::uint32_t seed,
                                    const PixelEstimate& pilot) const {
    return wholeLight(probe, seed, kGuardPoints, pilot.rays, true);
}

PixelEstimate PixelEstimator::uniform(LightProbe& probe, std::uint32_t seed) const {
    return wholeLight(probe, seed, tables_.size(), 0, false);
}

}  // namespace penumbra
