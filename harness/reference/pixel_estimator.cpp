#include "harness/reference/pixel_estimator.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace penumbra {

namespace {

constexpr int kReplicates = ReplicateTables::kReplicates;
constexpr int kGrid = ReplicateTables::kGrid;
constexpr int kCells = kGrid * kGrid;
constexpr int kCoarseGrid = ReplicateTables::kCoarseGrid;
constexpr int kCoarseCells = kCoarseGrid * kCoarseGrid;

// More cells than this and sampling only them saves too little to pay for the confirmation.
constexpr int kMaxSilhouetteCells = kCells * 3 / 5;
// Confirming rays per replicate over the whole light (those in silhouette cells are left out),
// where the pilot's grid resolves the silhouettes and where it does not.
constexpr int kConfirmPoints = 16;
constexpr int kConfirmPointsUnresolved = 32;
constexpr int kUnresolvedRings = 3;
constexpr int kConfirmAttempts = 2;
// Less than one in this many counts as rare.
constexpr int kRareShare = 64;
constexpr int kMinWholeLightPoints = 32;
// Squared error of n net points in a unit square crossed by one edge: 0.36^2 n^-3/2 (METHODS.md
// R4).
constexpr double kEdgeVariance = 0.13;
// A pixel is extended only when clearly above the target: 16 replicates know their own error to 18
// % only, and stopping on the first lucky value below a tight limit would make the reported errors
// too small.
constexpr double kTolerance = 1.2;

enum Salt : std::uint32_t { kPilotSalt = 1, kConfirmSalt, kSilhouetteSalt, kWholeSalt };

/// A random digital shift.
struct Shift {
    std::uint32_t x, y;
    explicit Shift(std::uint32_t h) : x(h), y(hash(h ^ 0x68bc21ebu)) {}
    SobolPoint operator()(const SobolPoint& p) const { return {p.x ^ x, p.y ^ y}; }
};

/// A cell of the pilot's grid.
struct Cell {
    int x, y;
    static Cell of(const SobolPoint& p) {
        static_assert(kGrid == 32);
        return {static_cast<int>(p.x >> 27), static_cast<int>(p.y >> 27)};
    }
};

// Bits of x at even, of y at odd places, the highest 16 of each.
std::uint32_t morton(const SobolPoint& p) {
    const auto spread = [](std::uint32_t v) {
        v = (v | (v << 8)) & 0x00ff00ffu;
        v = (v | (v << 4)) & 0x0f0f0f0fu;
        v = (v | (v << 2)) & 0x33333333u;
        return (v | (v << 1)) & 0x55555555u;
    };
    return spread(p.x >> 16) | (spread(p.y >> 16) << 1);
}

bool mortonLess(const SobolPoint& a, const SobolPoint& b) {
    return morton(a) < morton(b);
}

}  // namespace

ReplicateTables::ReplicateTables(int points) {
    for (int r = 0; r < kReplicates; ++r) {
        auto& table = overLight_[r];
        for (int i = 0; i < points; ++i) table.push_back(owenSobol(i, hash(0x7e3a91u, r)));
        alongList_[r] = table;
        for (int from = 0; from < points;) {
            const int to = std::min(points, roundUp(from + 1));
            std::sort(table.begin() + from, table.begin() + to, mortonLess);
            std::sort(alongList_[r].begin() + from, alongList_[r].begin() + to,
                      [](const SobolPoint& a, const SobolPoint& b) { return a.x < b.x; });
            from = to;
        }
    }
    for (int i = 0; i < kCells; ++i) pilot_.push_back(owenSobol(i, 0x51ed27u));
    std::sort(pilot_.begin(), pilot_.begin() + kCoarseCells, mortonLess);
    std::sort(pilot_.begin() + kCoarseCells, pilot_.end(), mortonLess);
}

int ReplicateTables::roundUp(double n) {
    int power = 1;
    while (power < n) power *= 2;
    return power >= 4 && power / 4 * 3 >= n ? power / 4 * 3 : power;
}

int ReplicateTables::roundDown(double n) {
    int power = 1;
    while (2 * power <= n) power *= 2;
    return power >= 2 && power / 2 * 3 <= n ? power / 2 * 3 : power;
}

namespace {

/// A grid of bits, one word per row, bit x is column x.
template <int n>
struct BitGrid {
    std::array<std::uint32_t, n> row{};

    bool operator[](Cell c) const { return (row[c.y] >> c.x) & 1u; }
    void set(Cell c) { row[c.y] |= 1u << c.x; }
    void assign(Cell c, bool value) {
        row[c.y] = (row[c.y] & ~(1u << c.x)) | (static_cast<std::uint32_t>(value) << c.x);
    }
    int count() const {
        int total = 0;
        for (const std::uint32_t bits : row) total += std::popcount(bits);
        return total;
    }
    BitGrid complement() const {
        BitGrid result;
        for (int y = 0; y < n; ++y) result.row[y] = ~row[y] & (~0u >> (32 - n));
        return result;
    }
    BitGrid operator&(const BitGrid& other) const {
        BitGrid result;
        for (int y = 0; y < n; ++y) result.row[y] = row[y] & other.row[y];
        return result;
    }
    BitGrid operator|(const BitGrid& other) const {
        BitGrid result;
        for (int y = 0; y < n; ++y) result.row[y] = row[y] | other.row[y];
        return result;
    }
    /// The cells of the grid of half as many a side that hold one of this grid's.
    BitGrid<n / 2> coarser() const {
        BitGrid<n / 2> result;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x)
                if ((row[y] >> x) & 1u) result.set({x / 2, y / 2});
        return result;
    }
    /// This grid's cells and all within `rings` of them.
    BitGrid grown(int rings) const {
        BitGrid result = *this;
        for (int ring = 0; ring < rings; ++ring) result = result | result.beside();
        return result;
    }
    /// The cells that have one of this grid's among their eight neighbours.
    BitGrid beside() const {
        BitGrid result;
        for (int y = 0; y < n; ++y) {
            std::uint32_t bits = (row[y] << 1) | (row[y] >> 1);
            for (const int j : {y - 1, y + 1})
                if (j >= 0 && j < n) bits |= row[j] | (row[j] << 1) | (row[j] >> 1);
            result.row[y] = bits & (~0u >> (32 - n));
        }
        return result;
    }
};

/// What differs from what in a grid of rays' answers.
template <int n>
struct Silhouette {
    BitGrid<n> cells;  ///< those with a neighbour of the other kind
    /// No cell is alone of its kind, and neither kind is rare: else there are features finer than
    /// the grid, and likely more of them that it missed.
    bool resolved = true;

    explicit Silhouette(const BitGrid<n>& lit) {
        const BitGrid<n> dark = lit.complement();
        const BitGrid<n> besideLit = lit.beside(), besideDark = dark.beside();
        for (int y = 0; y < n; ++y) {
            cells.row[y] = (lit.row[y] & besideDark.row[y]) | (dark.row[y] & besideLit.row[y]);
            resolved &=
                ((lit.row[y] & ~besideLit.row[y]) | (dark.row[y] & ~besideDark.row[y])) == 0;
        }
        resolved &= std::min(lit.count(), dark.count()) * kRareShare > n * n;
    }
};

}  // namespace

/// What the light looks like at one ray per cell.
class PixelEstimator::Pilot {
  public:
    /// False where the coarse grid's rays all agree: nothing more is traced or known then.
    bool trace(LightProbe& probe, const std::vector<SobolPoint>& net, std::uint32_t seed) {
        const Shift shift(hash(seed, kPilotSalt));
        LightBatch batch;
        std::array<Cell, LightBatch::kCapacity> cells;
        const auto add = [&](const SobolPoint& point) {
            const SobolPoint p = shift(point);
            batch.s[batch.size] = toUnitFloat(p.x);
            batch.t[batch.size] = toUnitFloat(p.y);
            cells[batch.size++] = Cell::of(p);
        };
        static_assert(kCoarseCells == LightBatch::kCapacity);
        for (int i = 0; i < kCoarseCells; ++i) add(net[i]);
        probe.look(batch);
        rays_ += kCoarseCells;
        BitGrid<kCoarseGrid> coarse;
        for (int i = 0; i < kCoarseCells; ++i)
            if (batch.visible[i]) coarse.set({cells[i].x / 2, cells[i].y / 2});
        const int litCount = coarse.count();
        constantVisibility_ = litCount == 0 ? 0.0 : 1.0;
        if (litCount == 0 || litCount == kCoarseCells) return false;

        for (int y = 0; y < kGrid; ++y)
            for (int x = 0; x < kGrid; ++x)
                if (coarse[{x / 2, y / 2}]) lit.set({x, y});
        const auto flush = [&] {
            probe.look(batch);
            rays_ += static_cast<int>(batch.size);
            for (std::size_t i = 0; i < batch.size; ++i)
                lit.assign(cells[i], batch.visible[i] != 0);
            batch.size = 0;
        };
        // Refine along the silhouettes as far as they lead; everywhere if some are not resolved.
        BitGrid<kCoarseGrid> refined;
        const bool everywhere = !Silhouette<kCoarseGrid>(coarse).resolved;
        for (bool more = true; more;) {
            const Silhouette<kGrid> seen(lit);
            silhouette = seen.cells;
            resolved = seen.resolved;
            BitGrid<kCoarseGrid> wanted = refined.complement();
            if (!everywhere) wanted = wanted & silhouette.coarser();
            batch.size = 0;
            for (int i = kCoarseCells; i < kCells; ++i) {
                const Cell cell = Cell::of(shift(net[i]));
                if (!wanted[{cell.x / 2, cell.y / 2}]) continue;
                add(net[i]);
                if (batch.size == LightBatch::kCapacity) flush();
            }
            flush();
            refined = refined | wanted;
            more = wanted.count() > 0;
        }
        // What slips through the grid here and there, a wire say, is near where it does not.
        if (!resolved) silhouette = silhouette.grown(kUnresolvedRings);
        for (int y = 0; y < kGrid; ++y) {
            crossings += std::popcount((lit.row[y] ^ (lit.row[y] >> 1)) & 0x7fffffffu);
            if (y + 1 < kGrid) crossings += std::popcount(lit.row[y] ^ lit.row[y + 1]);
        }
        return true;
    }

    int rays() const { return rays_; }
    double constantVisibility() const { return constantVisibility_; }
    BitGrid<kGrid> lit, silhouette;
    bool resolved = true;
    int crossings =
        0;  ///< pairs of cells side by side that differ: the silhouettes' length in cells

  private:
    int rays_ = 0;
    double constantVisibility_ = 1.0;
};

struct PixelEstimator::Sums {
    std::array<int, kReplicates> hits{};
    double weightLit = 0.0, weightAll = 0.0;
    int rays = 0;
};

/// Gathers points into streams and adds up what they see.
class PixelEstimator::Collector {
  public:
    Collector(LightProbe& probe, Sums& sums) : probe_(probe), sums_(sums) {}

    void add(std::uint32_t x, std::uint32_t y, int replicate) {
        batch_.s[batch_.size] = toUnitFloat(x);
        batch_.t[batch_.size] = toUnitFloat(y);
        replicate_[batch_.size] = static_cast<std::uint8_t>(replicate);
        if (++batch_.size == LightBatch::kCapacity) flush();
    }

    void flush() {
        probe_.look(batch_);
        probe_.weigh(batch_);
        float lit = 0.0f, all = 0.0f;
        for (std::size_t i = 0; i < batch_.size; ++i) {
            sums_.hits[replicate_[i]] += batch_.visible[i];
            all += batch_.weight[i];
            lit += batch_.visible[i] ? batch_.weight[i] : 0.0f;
        }
        sums_.weightLit += lit;
        sums_.weightAll += all;
        sums_.rays += static_cast<int>(batch_.size);
        batch_.size = 0;
    }

  private:
    LightProbe& probe_;
    Sums& sums_;
    LightBatch batch_;
    std::array<std::uint8_t, LightBatch::kCapacity> replicate_;
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
    Pilot pilot;
    if (!pilot.trace(probe, tables_.pilot(), seed)) {
        const double value = pilot.constantVisibility();
        return {value, 3.0 / kCoarseCells, value, kCoarseCells, true};
    }
    int rays = pilot.rays();
    for (std::uint32_t attempt = 0; attempt < kConfirmAttempts; ++attempt)
        if (pilot.silhouette.count() > kMaxSilhouetteCells)
            break;
        else if (confirm(probe, hash(seed, kConfirmSalt, attempt), pilot, rays))
            return alongSilhouette(probe, seed, pilot, rays);
    const int points = ReplicateTables::roundUp(predictPoints(pilot.crossings));
    return wholeLight(probe, seed, std::max(kMinWholeLightPoints, points), rays, true);
}

bool PixelEstimator::confirm(LightProbe& probe, std::uint32_t seed, Pilot& pilot, int& rays) const {
    LightBatch batch;
    std::array<Cell, LightBatch::kCapacity> cells;
    BitGrid<kGrid> refuted;
    const auto flush = [&] {
        probe.look(batch);
        rays += static_cast<int>(batch.size);
        for (std::size_t i = 0; i < batch.size; ++i)
            if ((batch.visible[i] != 0) != pilot.lit[cells[i]]) refuted.set(cells[i]);
        batch.size = 0;
    };
    const int points =
        std::min(tables_.size(), pilot.resolved ? kConfirmPoints : kConfirmPointsUnresolved);
    for (int r = 0; r < kReplicates; ++r) {
        const Shift shift(hash(seed, r));
        for (int i = 0; i < points; ++i) {
            const SobolPoint p = shift(tables_.overLight(r)[i]);
            const Cell cell = Cell::of(p);
            if (pilot.silhouette[cell]) continue;
            batch.s[batch.size] = toUnitFloat(p.x);
            batch.t[batch.size] = toUnitFloat(p.y);
            cells[batch.size] = cell;
            if (++batch.size == LightBatch::kCapacity) flush();
        }
    }
    flush();
    if (refuted.count() == 0) return true;
    pilot.resolved = false;
    pilot.silhouette = pilot.silhouette | refuted.grown(kUnresolvedRings);
    return false;
}

PixelEstimate PixelEstimator::alongSilhouette(LightProbe& probe, std::uint32_t seed,
                                              const Pilot& pilot, int raysSpent) const {
    // The silhouettes' cells in rows, every other one backwards, so that neighbours in the list are
    // neighbours on the light as far as can be; and the irradiance of all others by the midpoint
    // rule.
    std::array<Cell, kMaxSilhouetteCells> list;
    std::uint32_t cells = 0;
    int litCells = 0;
    double weightLit = 0.0, weightAll = 0.0;
    LightBatch centres;
    const auto addCentres = [&] {
        probe.weigh(centres);
        for (std::size_t i = 0; i < centres.size; ++i) {
            weightAll += centres.weight[i];
            if (centres.visible[i]) weightLit += centres.weight[i];
        }
        centres.size = 0;
    };
    for (int k = 0; k < kCells; ++k) {
        const int y = k / kGrid;
        const Cell cell{y % 2 == 0 ? k % kGrid : kGrid - 1 - k % kGrid, y};
        if (pilot.silhouette[cell]) {
            list[cells++] = cell;
            continue;
        }
        litCells += pilot.lit[cell];
        centres.s[centres.size] = (static_cast<float>(cell.x) + 0.5f) / kGrid;
        centres.t[centres.size] = (static_cast<float>(cell.y) + 0.5f) / kGrid;
        centres.visible[centres.size] = pilot.lit[cell];
        if (++centres.size == LightBatch::kCapacity) addCentres();
    }
    addCentres();

    const double area = static_cast<double>(cells) / kCells;
    const int affordable = std::max(1, (maxRays_ - raysSpent) / kReplicates);
    const int cap = std::min(tables_.size(), ReplicateTables::roundDown(affordable));
    // The cells hold the density that the whole light would need, and no more is wanted.
    int points = std::min(cap, ReplicateTables::roundUp(area * predictPoints(pilot.crossings)));
    int done = 0;
    Sums sums;
    Collector collector(probe, sums);
    for (;;) {
        for (int r = 0; r < kReplicates; ++r) {
            const Shift shift(hash(seed, kSilhouetteSalt, r));
            for (int i = done; i < points; ++i) {
                // The first coordinate runs along the list and, within a cell, across it.
                const SobolPoint p = shift(tables_.alongList(r)[i]);
                const std::uint64_t along = static_cast<std::uint64_t>(p.x) * cells;
                const Cell cell = list[along >> 32];
                collector.add((static_cast<std::uint32_t>(cell.x) << 27) |
                                  (static_cast<std::uint32_t>(along) >> 5),
                              (static_cast<std::uint32_t>(cell.y) << 27) | (p.y >> 5), r);
            }
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
            for (int i = done; i < points; ++i) {
                const SobolPoint p = shift(tables_.overLight(r)[i]);
                collector.add(p.x, p.y, r);
            }
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
