#include "harness/reference/replicate_tables.hpp"

#include <algorithm>
#include <utility>

namespace penumbra {

namespace {

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
    for (int i = 0; i < kGrid * kGrid; ++i) pilot_.push_back(owenSobol(i, 0x51ed27u));
    std::sort(pilot_.begin(), pilot_.begin() + kCoarseGrid * kCoarseGrid, mortonLess);
    static_assert(kCoarseGrid == 16);
    std::sort(pilot_.begin() + kCoarseGrid * kCoarseGrid, pilot_.end(),
              [](const SobolPoint& a, const SobolPoint& b) {
                  return std::pair(a.y >> 28, a.x >> 28) < std::pair(b.y >> 28, b.x >> 28);
              });
}

int ReplicateTables::roundUp(double n) {
    constexpr int kMost = 1 << 24;  // beyond any budget
    int power = 1;
    while (power < n && power < kMost) power *= 2;
    return power >= 4 && power / 4 * 3 >= n ? power / 4 * 3 : power;
}

int ReplicateTables::roundDown(double n) {
    int power = 1;
    while (2 * power <= n) power *= 2;
    return power >= 2 && power / 2 * 3 <= n ? power / 2 * 3 : power;
}

}  // namespace penumbra
