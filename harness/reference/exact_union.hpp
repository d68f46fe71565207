#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace penumbra {

/// A straight piece of a union's boundary, standing for all between it and x = 0. The union ends
/// there towards greater x (`sign` +1) or begins (-1): it is the signed sum of its strips.
struct Strip {
    double y0, y1;  ///< y0 < y1
    double x0, x1;  ///< of the boundary at y0 and y1
    int sign;
    double signedArea() const { return 0.5 * sign * (y1 - y0) * (x0 + x1); }
};

/// The union of polygons within the unit square, given by their outlines in any order.
///
/// An outline edge says by how much the number of polygons over a point changes across it, so
/// edges inside a mesh, where one triangle ends and the next begins, need not be given at all. The
/// union is where that number is positive. The square is swept in slabs between the ordinates of
/// vertices and crossings; in a slab all edges are straight and in one order, so the strips' areas
/// are exact (METHODS.md R2.8). Rounding moves edges by some 1e-15; edges that lie on each other,
/// slivers and vertices that almost meet cost no more than that.
class UnionSweep {
  public:
    void clear() { edges_.clear(); }
    /// From (x0, y0) to (x1, y1) within the unit square. From its left to its right, in x, the
    /// count rises by `rise` where the edge runs towards greater y, and falls by it otherwise.
    void add(double x0, double y0, double x1, double y1, int rise);
    std::size_t size() const { return edges_.size(); }
    /// The union of what has been added since clear(); the result is valid until the next call.
    const std::vector<Strip>& covered();

  private:
    struct Edge {
        double x0, y0, x1, y1;  ///< y0 < y1
        double slope;           ///< dx/dy
        int rise;               ///< of the count from left to right
        int sign = 0;           ///< of the strip it is bounding now
        double since = 0.0;     ///< where that strip begins
        double at(double y) const;
    };
    /// An edge within the current slab, x at the slab's ends.
    struct Crossing {
        double bottom, top;
        std::uint32_t edge;
    };
    using Row = std::vector<Crossing>;

    void enter(std::uint32_t edge, double y);
    void slab(double y0, double y1);
    int pass(const Crossing& crossing, int count, double y);
    int subdivide(Row::iterator begin, Row::iterator end, int count, double y0, double y1);
    void bound(Edge& edge, int sign, double y);

    std::vector<Edge> edges_;
    Edge rightSide_{1.0, 0.0, 1.0, 1.0, 0.0, 0};  ///< the square's
    std::vector<std::uint32_t> byStart_;
    std::vector<double> ordinates_, lowestAbove_, cuts_;
    Row row_, part_;
    std::vector<Strip> strips_;
};

}  // namespace penumbra
