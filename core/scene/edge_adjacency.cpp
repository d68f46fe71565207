#include "core/scene/edge_adjacency.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <unordered_map>

#include "core/error.hpp"
#include "core/scene/face_geometry.hpp"

namespace penumbra {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

class UnionFind {
  public:
    explicit UnionFind(std::size_t n) : parent_(n) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    std::uint32_t root(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }

  private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace

std::string MeshDefects::text() const {
    std::string text;
    const auto add = [&](std::size_t count, const char* what) {
        if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
    };
    add(openEdges, "open edges");
    add(nonManifoldEdges, "non-manifold edges");
    add(tJunctions, "T-junctions split");
    add(backToBack, "back-to-back triangles dropped");
    add(degenerate, "degenerate triangles dropped");
    return text;
}

class EdgeAdjacency::Builder {
  public:
    Builder(EdgeAdjacency& out, const Geometry& geometry, bool weld)
        : out_(out), geometry_(geometry), weld_(weld) {}

    void build() {
        requireFinite();
        makeVertices();
        makeFaces();
        findEdges();
        if (weld_) {
            if (dropWalls()) findEdges();
            if (splitOpenEdges()) groupHalfEdges();
        }
        for (const Edge& edge : out_.edges_) {
            out_.defects_.openEdges += edge.useCount == 1;
            out_.defects_.nonManifoldEdges += edge.useCount > 2;
        }
        orientAlike();
        findSolids();
        findPieces();
    }

  private:
    struct HalfEdge {
        std::uint32_t a, b;
        EdgeUse use;
    };

    glm::dvec3 at(std::uint32_t i) const { return glm::dvec3(geometry_.positions[i]); }

    void requireFinite() const {
        for (const glm::vec3& p : geometry_.positions)
            if (!std::isfinite(p.x + p.y + p.z))
                throw Unsupported("a vertex of the mesh is not finite: its edges have no place");
    }

    /// Which vertex stands for each: the first at its position.
    void makeVertices() {
        const std::size_t n = geometry_.positions.size();
        vertexOf_.resize(n);
        std::iota(vertexOf_.begin(), vertexOf_.end(), 0u);
        if (!weld_) return;
        std::vector<std::uint32_t> group(n, 0);
        for (std::size_t p = 0; p < geometry_.parts.size(); ++p)
            if (geometry_.parts[p].moves)
                std::fill_n(group.begin() + geometry_.parts[p].firstVertex,
                            geometry_.parts[p].vertexCount, static_cast<std::uint32_t>(p + 1));
        std::vector<std::uint32_t> order = vertexOf_;
        const auto key = [&](std::uint32_t i) {
            const glm::vec3& p = geometry_.positions[i];
            return std::tuple(p.x, p.y, p.z, group[i]);
        };
        std::ranges::sort(order, [&](std::uint32_t i, std::uint32_t j) {
            return std::tuple(key(i), i) < std::tuple(key(j), j);
        });
        for (std::size_t k = 1; k < n; ++k)
            if (key(order[k]) == key(order[k - 1])) vertexOf_[order[k]] = vertexOf_[order[k - 1]];
    }

    /// Faces with an area, each set of three vertices once; walls_ are those that were there from
    /// both sides.
    void makeFaces() {
        std::vector<std::pair<std::array<std::uint32_t, 3>, Face>> sorted;
        for (std::size_t i = 0; i + 2 < geometry_.indices.size(); i += 3) {
            Face face;
            for (std::size_t k = 0; k < 3; ++k)
                face.vertices[k] = vertexOf_[geometry_.indices[i + k]];
            const double area = glm::length(areaVector(geometry_, face.vertices));
            if (!(area > 0.0)) {
                ++out_.defects_.degenerate;
                continue;
            }
            std::array<std::uint32_t, 3> key = face.vertices;
            std::ranges::sort(key);
            sorted.emplace_back(key, face);
        }
        if (weld_)
            std::ranges::stable_sort(sorted, {}, [](const auto& entry) { return entry.first; });
        for (std::size_t i = 0; i < sorted.size();) {
            std::size_t end = i + 1;
            while (weld_ && end < sorted.size() && sorted[end].first == sorted[i].first) ++end;
            out_.faces_.push_back(sorted[i].second);
            walls_.push_back(end - i > 1);
            out_.defects_.backToBack += end - i - 1;
            i = end;
        }
    }

    void findEdges() {
        halfEdges_.clear();
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t from = out_.faces_[f].vertices[k],
                                    to = out_.faces_[f].vertices[(k + 1) % 3];
                halfEdges_.push_back({std::min(from, to), std::max(from, to), {f, from < to}});
            }
        groupHalfEdges();
    }

    void groupHalfEdges() {
        std::ranges::sort(halfEdges_, {}, [](const HalfEdge& h) {
            return std::tuple(h.a, h.b, h.use.face, h.use.forward);
        });
        out_.edges_.clear();
        out_.uses_.clear();
        for (const HalfEdge& half : halfEdges_) {
            if (out_.edges_.empty() || out_.edges_.back().a != half.a ||
                out_.edges_.back().b != half.b)
                out_.edges_.push_back(
                    {half.a, half.b, static_cast<std::uint32_t>(out_.uses_.size()), 0});
            ++out_.edges_.back().useCount;
            out_.uses_.push_back(half.use);
        }
    }

    std::span<const EdgeUse> usesOf(const Edge& edge) const {
        return {out_.uses_.data() + edge.firstUse, edge.useCount};
    }

    /// Takes away the walls that the surface closes without: all edges of their rim have two other
    /// faces or more. Of the others, sheets drawn from both sides or faces that are there twice,
    /// one copy stays.
    bool dropWalls() {
        if (std::ranges::find(walls_, true) == walls_.end()) return false;
        UnionFind connected(walls_.size());
        for (const Edge& edge : out_.edges_) {
            std::uint32_t last = kNone;
            for (const EdgeUse& use : usesOf(edge))
                if (walls_[use.face]) {
                    if (last != kNone) connected.join(last, use.face);
                    last = use.face;
                }
        }
        std::vector<bool> partition(walls_.size(), false), needed(walls_.size(), false);
        for (const Edge& edge : out_.edges_) {
            std::size_t others = 0;
            std::uint32_t wall = kNone;
            for (const EdgeUse& use : usesOf(edge)) {
                others += !walls_[use.face];
                if (walls_[use.face]) wall = connected.root(use.face);
            }
            if (wall == kNone) continue;
            if (others >= 2)
                partition[wall] = true;
            else if (others == 1 || edge.useCount == 1)
                needed[wall] = true;
        }
        std::vector<Face> kept;
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f)
            if (!walls_[f] || needed[connected.root(f)] || !partition[connected.root(f)])
                kept.push_back(out_.faces_[f]);
            else
                ++out_.defects_.backToBack;
        const bool dropped = kept.size() < out_.faces_.size();
        out_.faces_ = std::move(kept);
        return dropped;
    }

    /// Cells of a grid over the ends of open edges, about as wide as such an edge is long.
    struct Grid {
        double cellM = 1.0;
        std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> vertices;
        static std::uint64_t key(const glm::ivec3& c) {
            const auto bits = [](int v) { return static_cast<std::uint64_t>(v) & 0x1fffffu; };
            return bits(c.x) << 42 | bits(c.y) << 21 | bits(c.z);
        }
        glm::ivec3 cell(const glm::dvec3& p) const { return {glm::floor(p / cellM)}; }
    };

    bool splitOpenEdges() {
        std::vector<std::uint32_t> ends;
        double length = 0.0, extent = 0.0;
        std::size_t open = 0;
        for (const Edge& edge : out_.edges_)
            if (edge.useCount == 1) {
                ++open;
                length += glm::distance(at(edge.a), at(edge.b));
                for (const std::uint32_t v : {edge.a, edge.b}) {
                    ends.push_back(v);
                    const glm::dvec3 p = glm::abs(at(v));
                    extent = std::max({extent, p.x, p.y, p.z});
                }
            }
        if (open == 0) return false;
        std::ranges::sort(ends);
        ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
        Grid grid;
        // Twenty bits hold each coordinate of a cell.
        grid.cellM = std::max(length / static_cast<double>(open), extent * 0x1p-19);
        for (const std::uint32_t v : ends) grid.vertices[Grid::key(grid.cell(at(v)))].push_back(v);
        // Rounding of float positions, thrice over.
        const double toleranceM = 3.0 * 0x1p-24 * extent;

        std::vector<HalfEdge> result;
        bool split = false;
        for (const Edge& edge : out_.edges_) {
            std::vector<std::pair<double, std::uint32_t>> inside;
            if (edge.useCount == 1) inside = verticesInside(edge, grid, toleranceM);
            split |= !inside.empty();
            out_.defects_.tJunctions += inside.size();
            for (const EdgeUse& use : usesOf(edge)) {
                std::uint32_t from = edge.a;
                inside.emplace_back(1.0, edge.b);
                for (const auto& [t, to] : inside) {
                    result.push_back({std::min(from, to),
                                      std::max(from, to),
                                      {use.face, use.forward == (from < to)}});
                    from = to;
                }
                inside.pop_back();
            }
        }
        if (split) halfEdges_ = std::move(result);
        return split;
    }

    /// Those of the grid strictly inside the edge, in order from a, with where they are on it.
    std::vector<std::pair<double, std::uint32_t>> verticesInside(const Edge& edge, const Grid& grid,
                                                                 double toleranceM) const {
        const glm::dvec3 a = at(edge.a), along = at(edge.b) - a;
        const double lengthM = glm::length(along);
        std::vector<std::pair<double, std::uint32_t>> inside;
        const auto consider = [&](std::uint32_t v) {
            if (v == edge.a || v == edge.b) return;
            const glm::dvec3 from = at(v) - a;
            const double t = glm::dot(from, along) / (lengthM * lengthM);
            if (t * lengthM > toleranceM && (1.0 - t) * lengthM > toleranceM &&
                glm::length(from - t * along) <= toleranceM)
                inside.emplace_back(t, v);
        };
        // Bit by bit, no longer than a cell: each touches eight cells at most.
        const int bits = static_cast<int>(std::ceil(lengthM / grid.cellM));
        for (int i = 0; i < bits; ++i) {
            const glm::dvec3 p = a + along * (static_cast<double>(i) / bits),
                             q = a + along * ((i + 1.0) / bits);
            const glm::ivec3 lo = grid.cell(glm::min(p, q) - toleranceM),
                             hi = grid.cell(glm::max(p, q) + toleranceM);
            for (int z = lo.z; z <= hi.z; ++z)
                for (int y = lo.y; y <= hi.y; ++y)
                    for (int x = lo.x; x <= hi.x; ++x)
                        if (const auto found = grid.vertices.find(Grid::key({x, y, z}));
                            found != grid.vertices.end())
                            std::ranges::for_each(found->second, consider);
        }
        std::ranges::sort(inside);
        inside.erase(std::unique(inside.begin(), inside.end()), inside.end());
        return inside;
    }

    /// Sets Face::solid and turns solids' faces outward.
    /// Turns faces so that neighbours across an edge of two are oriented alike, by the larger
    /// area's way round; one-sided surfaces, which have no such orientation, stay as they are.
    void orientAlike() {
        // Each face twice: 2 f as it is, 2 f + 1 turned. What is joined is turned together.
        UnionFind ways(2 * out_.faces_.size());
        bool alike = true;
        for (const Edge& edge : out_.edges_) {
            const std::span<const EdgeUse> uses = usesOf(edge);
            if (uses.size() != 2) continue;
            const bool against = uses[0].forward == uses[1].forward;
            alike = alike && !against;
            for (const std::uint32_t turned : {0u, 1u})
                ways.join(2 * uses[0].face + turned,
                          2 * uses[1].face + (against ? 1 - turned : turned));
        }
        if (alike) return;
        std::vector<double> area(2 * out_.faces_.size(), 0.0);
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f)
            area[ways.root(2 * f)] += glm::length(areaVector(geometry_, out_.faces_[f].vertices));
        std::vector<bool> turned(out_.faces_.size());
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f) {
            const std::uint32_t stays = ways.root(2 * f), turns = ways.root(2 * f + 1);
            turned[f] = std::pair(area[turns], turns) > std::pair(area[stays], stays);
            if (turned[f]) std::swap(out_.faces_[f].vertices[1], out_.faces_[f].vertices[2]);
        }
        for (EdgeUse& use : out_.uses_) use.forward = use.forward != turned[use.face];
    }

    void findSolids() {
        UnionFind connected(out_.faces_.size());
        for (const Edge& edge : out_.edges_)
            for (const EdgeUse& use : usesOf(edge)) connected.join(use.face, usesOf(edge)[0].face);
        struct Component {
            bool oriented = true;
            glm::dvec3 areaVector{0.0}, moment{0.0};
            double area = 0.0, volume = 0.0;
        };
        std::vector<Component> components(out_.faces_.size());
        for (const Edge& edge : out_.edges_) {
            const auto forward = std::ranges::count_if(usesOf(edge), &EdgeUse::forward);
            if (edge.useCount > 1 && 2 * forward != edge.useCount)
                components[connected.root(usesOf(edge)[0].face)].oriented = false;
        }
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f) {
            const Face& face = out_.faces_[f];
            Component& component = components[connected.root(f)];
            const glm::dvec3 area = areaVector(geometry_, face.vertices);
            component.areaVector += area;
            component.area += glm::length(area);
            const glm::dvec3 p = at(face.vertices[0]);
            component.moment += glm::length(area) * p;
            component.volume += glm::dot(area, p);
        }
        // About the middle of what is not quite closed.
        for (Component& c : components)
            if (c.area > 0.0) c.volume -= glm::dot(c.areaVector, c.moment / c.area);
        inwards_.assign(out_.faces_.size(), false);
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f) {
            const Component& component = components[connected.root(f)];
            Face& face = out_.faces_[f];
            const double openness = glm::length(component.areaVector) / component.area;
            face.solid = component.oriented && component.volume != 0.0 && openness <= kSolid;
            face.closed = face.solid && openness <= kClosed;
            inwards_[f] = face.solid && component.volume < 0.0;
            if (inwards_[f]) std::swap(face.vertices[1], face.vertices[2]);
        }
        for (EdgeUse& use : out_.uses_) use.forward = use.forward != inwards_[use.face];
    }

    void findPieces() {
        UnionFind joined(out_.faces_.size());
        for (const Edge& edge : out_.edges_) {
            const std::span<const EdgeUse> uses = usesOf(edge);
            if (uses.size() == 2 && !out_.hollow(geometry_, edge))
                joined.join(uses[0].face, uses[1].face);
        }
        std::unordered_map<std::uint32_t, std::uint32_t> numbers;
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f)
            out_.faces_[f].piece =
                numbers.emplace(joined.root(f), static_cast<std::uint32_t>(numbers.size()))
                    .first->second;
        out_.pieceCount_ = static_cast<std::uint32_t>(numbers.size());
    }

    EdgeAdjacency& out_;
    const Geometry& geometry_;
    const bool weld_;
    std::vector<std::uint32_t> vertexOf_;
    std::vector<HalfEdge> halfEdges_;
    std::vector<bool> walls_, inwards_;
};

EdgeAdjacency::EdgeAdjacency(const Geometry& geometry, bool weld)
    : sourceIndices_(geometry.indices), sourcePositions_(geometry.positions) {
    Builder(*this, geometry, weld).build();
}

bool EdgeAdjacency::describes(const Geometry& geometry) const {
    if (geometry.indices != sourceIndices_ || geometry.positions.size() != sourcePositions_.size())
        return false;
    return std::ranges::all_of(geometry.parts, [&](const Part& part) {
        const auto first = static_cast<std::ptrdiff_t>(part.firstVertex);
        return part.moves || std::equal(geometry.positions.begin() + first,
                                        geometry.positions.begin() + first + part.vertexCount,
                                        sourcePositions_.begin() + first);
    });
}

}  // namespace penumbra
