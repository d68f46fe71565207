#include "core/scene/edge_adjacency.hpp"

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <unordered_map>

#include "core/error.hpp"
#include "core/scene/face_geometry.hpp"
#include "core/scene/vertex_grid.hpp"

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
        tbb::parallel_sort(order, [&](std::uint32_t i, std::uint32_t j) {
            return std::tuple(key(i), i) < std::tuple(key(j), j);
        });
        for (std::size_t k = 1; k < n; ++k)
            if (key(order[k]) == key(order[k - 1])) vertexOf_[order[k]] = vertexOf_[order[k - 1]];
    }

    /// Faces with an area, each set of three vertices once; walls_ are those that were there from
    /// both sides.
    void makeFaces() {
        struct Triangle {
            std::array<std::uint32_t, 3> key;  ///< its vertices, sorted
            std::uint32_t first;               ///< of its indices
        };
        const auto verticesAt = [&](std::uint32_t first) {
            std::array<std::uint32_t, 3> vertices;
            for (std::uint32_t k = 0; k < 3; ++k)
                vertices[k] = vertexOf_[geometry_.indices[first + k]];
            return vertices;
        };
        std::vector<Triangle> sorted;
        sorted.reserve(geometry_.triangleCount());
        for (std::uint32_t i = 0; i + 2 < geometry_.indices.size(); i += 3) {
            std::array<std::uint32_t, 3> key = verticesAt(i);
            if (!(glm::length(areaVector(geometry_, key)) > 0.0)) {
                ++out_.defects_.degenerate;
                continue;
            }
            std::ranges::sort(key);
            sorted.push_back({key, i});
        }
        if (weld_)
            tbb::parallel_sort(sorted, [](const Triangle& l, const Triangle& r) {
                return std::tie(l.key, l.first) < std::tie(r.key, r.first);
            });
        out_.faces_.reserve(sorted.size());
        for (std::size_t i = 0; i < sorted.size();) {
            std::size_t end = i + 1;
            while (weld_ && end < sorted.size() && sorted[end].key == sorted[i].key) ++end;
            out_.faces_.push_back({.vertices = verticesAt(sorted[i].first)});
            walls_.push_back(end - i > 1);
            out_.defects_.backToBack += end - i - 1;
            i = end;
        }
    }

    void findEdges() {
        halfEdges_.reserve(3 * out_.faces_.size());
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t from = out_.faces_[f].vertices[k],
                                    to = out_.faces_[f].vertices[(k + 1) % 3];
                halfEdges_.push_back({std::min(from, to), std::max(from, to), {f, from < to}});
            }
        groupHalfEdges();
    }

    /// Uses halfEdges_ up.
    void groupHalfEdges() {
        const auto key = [](const HalfEdge& h) {
            return std::tuple(h.a, h.b, h.use.face, h.use.forward);
        };
        tbb::parallel_sort(halfEdges_,
                           [&](const HalfEdge& l, const HalfEdge& r) { return key(l) < key(r); });
        out_.edges_.clear();
        out_.uses_.clear();
        out_.uses_.reserve(halfEdges_.size());
        for (const HalfEdge& half : halfEdges_) {
            if (out_.edges_.empty() || out_.edges_.back().a != half.a ||
                out_.edges_.back().b != half.b)
                out_.edges_.push_back(
                    {half.a, half.b, static_cast<std::uint32_t>(out_.uses_.size()), 0});
            ++out_.edges_.back().useCount;
            out_.uses_.push_back(half.use);
        }
        halfEdges_ = {};
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
        const VertexGrid grid(geometry_, ends, length / static_cast<double>(open), extent);
        std::unordered_map<std::size_t, std::vector<std::pair<double, std::uint32_t>>> cuts;
        for (std::size_t e = 0; e < out_.edges_.size(); ++e) {
            const Edge& edge = out_.edges_[e];
            if (edge.useCount != 1) continue;
            auto inside = grid.inside(edge.a, edge.b);
            out_.defects_.tJunctions += inside.size();
            if (!inside.empty()) cuts.emplace(e, std::move(inside));
        }
        if (cuts.empty()) return false;
        halfEdges_.reserve(out_.uses_.size());
        for (std::size_t e = 0; e < out_.edges_.size(); ++e) {
            const Edge& edge = out_.edges_[e];
            for (const EdgeUse& use : usesOf(edge)) {
                std::uint32_t from = edge.a;
                const auto addUpTo = [&](std::uint32_t to) {
                    halfEdges_.push_back({std::min(from, to),
                                          std::max(from, to),
                                          {use.face, use.forward == (from < to)}});
                    from = to;
                };
                if (const auto cut = cuts.find(e); cut != cuts.end())
                    for (const auto& [t, vertex] : cut->second) addUpTo(vertex);
                addUpTo(edge.b);
            }
        }
        return true;
    }

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

    /// Sets Face::solid and turns solids' faces outward.
    void findSolids() {
        UnionFind connected(out_.faces_.size());
        for (const Edge& edge : out_.edges_)
            for (const EdgeUse& use : usesOf(edge)) connected.join(use.face, usesOf(edge)[0].face);
        struct Component {
            bool oriented = true;
            glm::dvec3 areaVector{0.0}, moment{0.0};
            double area = 0.0, volume = 0.0;
        };
        std::vector<std::uint32_t> numberOf(out_.faces_.size(), kNone);  // of roots
        std::vector<Component> components;
        const auto componentOf = [&](std::uint32_t face) -> Component& {
            std::uint32_t& number = numberOf[connected.root(face)];
            if (number == kNone) {
                number = static_cast<std::uint32_t>(components.size());
                components.emplace_back();
            }
            return components[number];
        };
        for (const Edge& edge : out_.edges_) {
            const auto forward = std::ranges::count_if(usesOf(edge), &EdgeUse::forward);
            if (edge.useCount > 1 && 2 * forward != edge.useCount)
                componentOf(usesOf(edge)[0].face).oriented = false;
        }
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f) {
            const Face& face = out_.faces_[f];
            Component& component = componentOf(f);
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
            const Component& component = componentOf(f);
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
        std::vector<std::uint32_t> numberOf(out_.faces_.size(), kNone);  // of roots
        for (std::uint32_t f = 0; f < out_.faces_.size(); ++f) {
            std::uint32_t& number = numberOf[joined.root(f)];
            if (number == kNone) number = out_.pieceCount_++;
            out_.faces_[f].piece = number;
        }
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
