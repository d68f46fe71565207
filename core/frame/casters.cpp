#include "core/frame/casters.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace penumbra {
namespace {

using Ids = std::vector<std::uint32_t>;

/// The first vertex at each vertex's place.
Ids welded(const std::vector<glm::vec3>& positions) {
    Ids order(positions.size()), first(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t i) {
        const glm::vec3& p = positions[i];
        return std::tuple(p.x, p.y, p.z);
    };
    std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] =
            i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
    return first;
}

std::uint32_t root(Ids& parent, std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

}  // namespace

Casters Casters::find(const Geometry& geometry) {
    const Ids place = welded(geometry.positions);
    Ids parent = place;
    for (std::size_t i = 0; i < geometry.indices.size(); i += 3)
        for (std::size_t k : {1u, 2u})
            parent[root(parent, geometry.indices[i + k])] = root(parent, geometry.indices[i]);

    Casters casters;
    Ids number(place.size(), ~0u);
    for (std::uint32_t i = 0; i < place.size(); ++i) {
        std::uint32_t& n = number[root(parent, i)];
        if (n == ~0u) {
            n = static_cast<std::uint32_t>(casters.thicknessM.size());
            casters.thicknessM.push_back(0.0);
        }
        casters.ofVertex.push_back(n);
    }

    struct Edge {
        std::uint64_t ends;
        int direction;
    };
    std::vector<Edge> edges;
    std::vector<double> volume(casters.thicknessM.size()), area(casters.thicknessM.size());
    std::vector<char> open(casters.thicknessM.size());
    Ids reference(casters.thicknessM.size(), ~0u);
    for (std::size_t i = 0; i < geometry.indices.size(); i += 3) {
        const std::uint32_t* corner = &geometry.indices[i];
        const std::uint32_t caster = casters.ofVertex[corner[0]];
        if (reference[caster] == ~0u) reference[caster] = corner[0];
        // Relative to a vertex of the body, where small volumes keep their digits.
        const glm::dvec3 from(geometry.positions[reference[caster]]);
        const auto at = [&](int k) { return glm::dvec3(geometry.positions[corner[k]]) - from; };
        volume[caster] += glm::dot(at(0), glm::cross(at(1), at(2))) / 6.0;
        area[caster] += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint64_t a = place[corner[k]], b = place[corner[(k + 1) % 3]];
            if (a != b) edges.push_back({std::min(a, b) << 32 | std::max(a, b), a < b ? 1 : -1});
        }
    }
    std::ranges::sort(edges, {}, &Edge::ends);
    for (std::size_t i = 0; i < edges.size();) {
        const std::uint64_t ends = edges[i].ends;
        int balance = 0;
        for (; i < edges.size() && edges[i].ends == ends; ++i) balance += edges[i].direction;
        if (balance != 0) open[casters.ofVertex[ends >> 32]] = 1;
    }
    for (std::size_t c = 0; c < casters.thicknessM.size(); ++c)
        if (!open[c] && area[c] > 0.0) casters.thicknessM[c] = 2.0 * std::abs(volume[c]) / area[c];
    return casters;
}

}  // namespace penumbra
