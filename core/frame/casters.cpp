#include "core/frame/casters.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/sampling/sampling.hpp"

namespace penumbra {
namespace {

using Ids = std::vector<std::uint32_t>;

constexpr std::uint32_t kNone = ~0u;

/// The first vertex at each vertex's place; by a hash table, for sorting places takes longer than
/// all else here.
Ids welded(const std::vector<glm::vec3>& positions) {
    const std::size_t mask = std::bit_ceil(2 * positions.size() + 1) - 1;
    Ids slots(mask + 1, kNone), first(positions.size());
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        const glm::vec3 p = positions[i] + 0.0f;  // -0 and 0 are one place
        std::size_t slot =
            hash(std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                 std::bit_cast<std::uint32_t>(p.z));
        for (slot &= mask; slots[slot] != kNone && positions[slots[slot]] != p;)
            slot = (slot + 1) & mask;
        if (slots[slot] == kNone) slots[slot] = i;
        first[i] = slots[slot];
    }
    return first;
}

std::uint32_t root(Ids& parent, std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

/// A vertex of each edge that does not have as many triangles running one way as the other.
Ids verticesOfOpenEdges(const Geometry& geometry, const Ids& place) {
    // Edges by their lesser vertex, of which each has a few only: counted, then put in place.
    struct Side {
        std::uint32_t greater;
        int direction;
    };
    const auto eachSide = [&](const auto& use) {
        for (std::size_t i = 0; i < geometry.indices.size(); i += 3)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = place[geometry.indices[i + k]],
                                    b = place[geometry.indices[i + (k + 1) % 3]];
                if (a != b) use(std::min(a, b), Side{std::max(a, b), a < b ? 1 : -1});
            }
    };
    Ids end(place.size() + 1, 0);
    eachSide([&](std::uint32_t lesser, const Side&) { ++end[lesser + 1]; });
    std::partial_sum(end.begin(), end.end(), end.begin());
    std::vector<Side> sides(end.back());
    Ids next(end.begin(), end.end() - 1);
    eachSide([&](std::uint32_t lesser, const Side& side) { sides[next[lesser]++] = side; });
    Ids open;
    for (std::uint32_t v = 0; v < place.size(); ++v) {
        const auto from = sides.begin() + end[v], to = sides.begin() + end[v + 1];
        std::sort(from, to, [](const Side& l, const Side& r) { return l.greater < r.greater; });
        for (auto i = from; i != to;) {
            const std::uint32_t greater = i->greater;
            int balance = 0;
            for (; i != to && i->greater == greater; ++i) balance += i->direction;
            if (balance != 0) open.push_back(v);
        }
    }
    return open;
}

}  // namespace

Casters Casters::find(const Geometry& geometry) {
    const Ids place = welded(geometry.positions);
    Ids parent = place;
    for (std::size_t i = 0; i < geometry.indices.size(); i += 3)
        for (std::size_t k : {1u, 2u})
            parent[root(parent, geometry.indices[i + k])] = root(parent, geometry.indices[i]);

    Casters casters;
    Ids number(place.size(), kNone);
    for (std::uint32_t i = 0; i < place.size(); ++i) {
        std::uint32_t& n = number[root(parent, i)];
        if (n == kNone) {
            n = static_cast<std::uint32_t>(casters.thicknessM.size());
            casters.thicknessM.push_back(0.0);
        }
        casters.ofVertex.push_back(n);
    }

    std::vector<double> volume(casters.thicknessM.size()), area(casters.thicknessM.size());
    std::vector<char> open(casters.thicknessM.size());
    Ids reference(casters.thicknessM.size(), kNone);
    for (std::size_t i = 0; i < geometry.indices.size(); i += 3) {
        const std::uint32_t* corner = &geometry.indices[i];
        const std::uint32_t caster = casters.ofVertex[corner[0]];
        if (reference[caster] == kNone) reference[caster] = corner[0];
        // Relative to a vertex of the body, where small volumes keep their digits.
        const glm::dvec3 from(geometry.positions[reference[caster]]);
        const auto at = [&](int k) { return glm::dvec3(geometry.positions[corner[k]]) - from; };
        volume[caster] += glm::dot(at(0), glm::cross(at(1), at(2))) / 6.0;
        area[caster] += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
    }
    for (const std::uint32_t vertex : verticesOfOpenEdges(geometry, place))
        open[casters.ofVertex[vertex]] = 1;
    casters.insideOut.resize(casters.thicknessM.size());
    for (std::size_t c = 0; c < casters.thicknessM.size(); ++c) {
        if (!open[c] && area[c] > 0.0) casters.thicknessM[c] = 2.0 * std::abs(volume[c]) / area[c];
        casters.insideOut[c] = volume[c] < 0.0;
    }
    return casters;
}

}  // namespace penumbra
