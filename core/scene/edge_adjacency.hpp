#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/scene/geometry.hpp"

namespace penumbra {

/// What a mesh has instead of the closed two-manifold that silhouette methods ask for, counted
/// after welding.
struct MeshDefects {
    std::size_t openEdges = 0;         ///< of one face only
    std::size_t nonManifoldEdges = 0;  ///< of three or more faces
    std::size_t tJunctions = 0;        ///< vertices inside an open edge, which was split there
    std::size_t backToBack = 0;        ///< triangles dropped: walls inside solids, second sides
    std::size_t degenerate = 0;        ///< triangles dropped for want of area
    bool operator==(const MeshDefects&) const = default;
    /// "12 open edges, 3 T-junctions split"; empty where nothing is wrong.
    std::string text() const;
};

/// An edge that may be part of a silhouette, as one frame has it. Positions are metres relative to
/// Scene::origin; planes are (n, n.p) with unit n by the right-hand rule over the face's vertices.
///
/// Seen from C, face i faces it where n.C > n.p (exactly edge-on counts as facing away, for all of
/// the face's edges alike, as all of them hold the same plane) and lies on the side
///     s_i = (facing ? -1 : 1) (forward_i ? 1 : -1)
/// of the plane through C, a and b, 1 being the side that cross(a - C, b - C) points to. The edge
/// is a silhouette where all its faces lie on one side.
struct OutlineEdge {
    glm::vec3 a{0.0f}, b{0.0f};
    /// Unit; outward over the surface at a and b: the mean, by angle, of the normals of the faces
    /// that share the vertex, outward where they bound a solid, or of the directions away from the
    /// surface where it ends. 0 where they cancel.
    glm::vec3 stretchA{0.0f}, stretchB{0.0f};
    std::array<glm::vec4, 2> planes{};  ///< the second of an open edge is the first
    std::array<bool, 2> forward{};      ///< the face runs from a to b
    std::uint32_t piece = 0;            ///< EdgeAdjacency::pieceCount
};

/// Which faces meet at which edges of a frame's casters, made once per mesh; what depends on where
/// vertices are follows moving casters frame by frame.
///
/// Vertices at one position become one (parts that move are welded to themselves only, for they may
/// touch others by chance). Triangles on the same three vertices become one; where such a wall lies
/// within solids (the surface closes without it) it goes altogether. An open edge is split at
/// vertices that lie inside it. Faces that run the other way round than their neighbours are
/// turned. What is left of defects is sound all the same: an open edge is a
/// silhouette from everywhere; of three or more faces only the two beside the widest gap matter,
/// and none if no gap exceeds half a turn. Edges that can be no silhouette are left out: between
/// coplanar faces and, on closed solids, in hollows.
///
/// A *solid* is a connected set of faces that are oriented alike and enclose something: their
/// summed area vectors are at most kSolid of their area, which a teapot without its lid is and a
/// leaf or a bowl is not. It is closed where they are at most kClosed. Everything else is a
/// *sheet*.
class EdgeAdjacency {
  public:
    EdgeAdjacency() = default;
    /// O(n log n) in triangles, of which the logarithm is a sort's. `weld` false takes vertices for
    /// one only where the mesh shares their index, keeps duplicates and splits nothing. Throws
    /// Unsupported where a vertex is not finite.
    explicit EdgeAdjacency(const Geometry& geometry, bool weld = true);

    /// Whether this is the adjacency of `geometry`: of the same triangles and, but for parts that
    /// move, the same positions.
    bool describes(const Geometry& geometry) const;

    const MeshDefects& defects() const { return defects_; }
    std::size_t edgeCount() const { return edges_.size(); }  ///< those left out included
    /// Connected sets of faces, cut apart in hollows: pieces that are, most of them, convex.
    std::uint32_t pieceCount() const { return pieceCount_; }

    /// The edges of a frame that describes() holds for.
    std::vector<OutlineEdge> outlineEdges(const Geometry& geometry) const;

    /// A face on vertices of `Geometry::positions`; those of solids run counterclockwise seen from
    /// outside.
    struct Face {
        std::array<std::uint32_t, 3> vertices{};
        std::uint32_t piece = 0;
        bool solid = false, closed = false;
    };
    const std::vector<Face>& faces() const { return faces_; }

    static constexpr double kSolid = 0.3, kClosed = 0.01;

  private:
    struct EdgeUse {  ///< one face's side on an edge
        std::uint32_t face = 0;
        bool forward = true;  ///< the face runs from the lesser vertex to the greater
    };
    struct Edge {
        std::uint32_t a = 0, b = 0;  ///< a < b
        std::uint32_t firstUse = 0, useCount = 0;
    };
    class Builder;

    /// Whether two faces of a solid meet at less than half a turn of air: no silhouette from
    /// anywhere, for the solid itself hides it.
    bool hollow(const Geometry& geometry, const Edge& edge) const;
    /// The two uses that decide where the edge is a silhouette; none where it never is.
    std::array<std::uint32_t, 2> outermost(const Geometry& geometry, const Edge& edge) const;

    std::vector<Face> faces_;
    std::vector<Edge> edges_;
    std::vector<EdgeUse> uses_;
    MeshDefects defects_;
    std::uint32_t pieceCount_ = 0;
    std::vector<std::uint32_t> sourceIndices_;
    std::vector<glm::vec3> sourcePositions_;
};

}  // namespace penumbra
