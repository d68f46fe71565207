#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace penumbra {

/// Column and row of a grid.
struct Cell {
    int x, y;
};

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
    /// Less than one in this many counts as rare.
    static constexpr int kRareShare = 64;
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

}  // namespace penumbra
