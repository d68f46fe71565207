// What of EdgeAdjacency depends on where the vertices are: which edges may be silhouettes, and how
// they stretch.

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/scene/edge_adjacency.hpp"
#include "core/scene/face_geometry.hpp"

namespace penumbra {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

}  // namespace

bool EdgeAdjacency::hollow(const Geometry& geometry, const Edge& edge) const {
    const Face& face = faces_[uses_[edge.firstUse].face];
    const Face& other = faces_[uses_[edge.firstUse + 1].face];
    if (!face.closed || edge.useCount != 2) return false;
    const glm::dvec3 into = intoFace(geometry, edge.a, edge.b, other.vertices);
    return !flat(into, intoFace(geometry, edge.a, edge.b, face.vertices)) &&
           glm::dot(into, areaVector(geometry, face.vertices)) > 0.0;
}

std::array<std::uint32_t, 2> EdgeAdjacency::outermost(const Geometry& geometry,
                                                      const Edge& edge) const {
    constexpr std::array<std::uint32_t, 2> kNever = {kNone, kNone};
    const auto into = [&](std::uint32_t use) {
        return intoFace(geometry, edge.a, edge.b, faces_[uses_[use].face].vertices);
    };
    const std::uint32_t first = edge.firstUse;
    if (edge.useCount == 1) return {first, first};
    if (edge.useCount == 2) {
        if (hollow(geometry, edge) || flat(into(first), into(first + 1))) return kNever;
        return {first, first + 1};
    }
    // Angles of the faces around the edge; they lie on one side of some plane through it only if
    // a gap exceeds half a turn, and then the two beside that gap decide.
    const glm::dvec3 along = glm::normalize(glm::dvec3(geometry.positions[edge.b]) -
                                            glm::dvec3(geometry.positions[edge.a]));
    const glm::dvec3 x = into(first), y = glm::cross(along, x);
    std::vector<std::pair<double, std::uint32_t>> angles;
    for (std::uint32_t use = first; use < first + edge.useCount; ++use)
        angles.emplace_back(std::atan2(glm::dot(into(use), y), glm::dot(into(use), x)), use);
    std::ranges::sort(angles);
    for (std::size_t i = 0; i < angles.size(); ++i) {
        const std::size_t next = (i + 1) % angles.size();
        const double gap =
            angles[next].first - angles[i].first + (next == 0 ? 2.0 * std::numbers::pi : 0.0);
        if (gap > std::numbers::pi + 1e-5) return {angles[i].second, angles[next].second};
    }
    return kNever;
}

std::vector<OutlineEdge> EdgeAdjacency::outlineEdges(const Geometry& geometry) const {
    std::vector<glm::dvec3> normals(faces_.size());
    std::vector<glm::dvec3> outward(geometry.positions.size(), glm::dvec3(0.0));
    // By the angle that a face takes of the vertex, however it is cut into triangles; added up in
    // the faces' order, that of angles which a block of them has at once.
    constexpr std::size_t kBlock = 1 << 16;
    std::vector<std::array<double, 3>> angles(std::min(kBlock, faces_.size()));
    for (std::size_t begin = 0; begin < faces_.size(); begin += kBlock) {
        const std::size_t end = std::min(begin + kBlock, faces_.size());
        tbb::parallel_for(begin, end, [&](std::size_t f) {
            const auto& v = faces_[f].vertices;
            normals[f] = glm::normalize(areaVector(geometry, v));
            for (std::size_t k = 0; k < 3; ++k) {
                const glm::dvec3 p(geometry.positions[v[k]]);
                const glm::dvec3 u = glm::dvec3(geometry.positions[v[(k + 1) % 3]]) - p,
                                 w = glm::dvec3(geometry.positions[v[(k + 2) % 3]]) - p;
                angles[f - begin][k] = std::atan2(glm::length(glm::cross(u, w)), glm::dot(u, w));
            }
        });
        for (std::size_t f = begin; f < end; ++f)
            for (std::size_t k = 0; k < 3; ++k)
                outward[faces_[f].vertices[k]] += angles[f - begin][k] * normals[f];
    }
    // Where a surface ends, away from it.
    std::vector<glm::dvec3> away(geometry.positions.size(), glm::dvec3(0.0));
    for (const Edge& edge : edges_)
        if (edge.useCount == 1) {
            const glm::dvec3 direction =
                -intoFace(geometry, edge.a, edge.b, faces_[uses_[edge.firstUse].face].vertices);
            away[edge.a] += direction;
            away[edge.b] += direction;
        }
    const auto stretch = [&](std::uint32_t v) {
        const glm::dvec3 sum = away[v] != glm::dvec3(0.0) ? away[v] : outward[v];
        const double length = glm::length(sum);
        // Rounding of unit normals that cancel.
        return length > 1e-6 ? glm::vec3(sum / length) : glm::vec3(0.0f);
    };

    std::vector<std::array<std::uint32_t, 2>> usesOf(edges_.size());
    tbb::parallel_for(std::size_t{0}, edges_.size(),
                      [&](std::size_t e) { usesOf[e] = outermost(geometry, edges_[e]); });
    std::vector<std::uint32_t> listed;
    for (std::uint32_t e = 0; e < edges_.size(); ++e)
        if (usesOf[e][0] != kNone) listed.push_back(e);
    std::vector<OutlineEdge> outline(listed.size());
    tbb::parallel_for(std::size_t{0}, outline.size(), [&](std::size_t i) {
        const Edge& edge = edges_[listed[i]];
        const std::array<std::uint32_t, 2>& uses = usesOf[listed[i]];
        OutlineEdge& out = outline[i];
        out.a = geometry.positions[edge.a];
        out.b = geometry.positions[edge.b];
        out.stretchA = stretch(edge.a);
        out.stretchB = stretch(edge.b);
        out.piece = faces_[uses_[uses[0]].face].piece;
        for (std::size_t k = 0; k < 2; ++k) {
            const EdgeUse& use = uses_[uses[k]];
            const glm::dvec3 p(geometry.positions[faces_[use.face].vertices[0]]);
            out.planes[k] = glm::vec4(normals[use.face], glm::dot(normals[use.face], p));
            out.forward[k] = use.forward;
        }
    });
    return outline;
}

}  // namespace penumbra
