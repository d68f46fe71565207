#include "core/frame/shadow_casters.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "core/trace/shaft.hpp"

namespace penumbra {
namespace {

/// Holds all receivers of `bounds`, and what is `marginM` beside them, in light space.
Bounds boxOf(const SideBounds& bounds, double marginM) {
    Bounds box;
    for (const double z : {bounds.receiverNearM, bounds.receiverFarM}) {
        box.add({bounds.tangentLo * z, z});
        box.add({bounds.tangentHi * z, z});
    }
    // Positions are floats.
    const double around = marginM + 1e-5 * bounds.receiverFarM;
    box.lo -= around;
    box.hi += around;
    box.lo.z = std::max(box.lo.z, 1e-6 * bounds.receiverFarM);
    return box;
}

/// Whether the light is outside of `box` for sure.
bool isOutside(const AreaLight& light, const glm::dvec2& half, const Bounds& box) {
    const glm::dvec3 reach = half.x * glm::abs(light.axisU) + half.y * glm::abs(light.axisV);
    return glm::any(glm::greaterThan(light.centre - reach, box.hi)) ||
           glm::any(glm::lessThan(light.centre + reach, box.lo));
}

/// Whether the triangle, its normal times `outward`, is turned away from every point of the light.
bool isTurnedAway(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double outward,
                  const glm::dvec2& half) {
    const glm::dvec3 normal = outward * glm::cross(b - a, c - a);
    return std::abs(normal.x) * half.x + std::abs(normal.y) * half.y <= glm::dot(normal, a);
}

/// The triangles of `all` for which `kept` is set.
Geometry copyOf(const Geometry& all, const std::vector<char>& kept) {
    constexpr std::uint32_t kUnused = ~0u;
    std::vector<std::uint32_t> copyOfVertex(all.positions.size(), kUnused);
    Geometry some;
    for (const Part& part : all.parts) {
        Part copy = part;
        copy.firstVertex = static_cast<std::uint32_t>(some.positions.size());
        copy.firstIndex = static_cast<std::uint32_t>(some.indices.size());
        for (std::uint32_t i = part.firstIndex; i < part.firstIndex + part.indexCount; ++i) {
            if (!kept[i / 3]) continue;
            const std::uint32_t vertex = all.indices[i];
            std::uint32_t& mine = copyOfVertex[vertex];
            if (mine == kUnused) {
                mine = static_cast<std::uint32_t>(some.positions.size());
                some.positions.push_back(all.positions[vertex]);
                some.normals.push_back(all.normals[vertex]);
                some.uvs.push_back(all.uvs[vertex]);
            }
            some.indices.push_back(mine);
        }
        copy.vertexCount = static_cast<std::uint32_t>(some.positions.size()) - copy.firstVertex;
        copy.indexCount = static_cast<std::uint32_t>(some.indices.size()) - copy.firstIndex;
        some.parts.push_back(copy);
    }
    return some;
}

}  // namespace

Geometry shadowCasters(const Frame& frame, const CasterChoice& choice) {
    const Geometry& all = *frame.geometry;
    const SideBounds& receivers = frame.lightBounds.whole;
    std::vector<char> kept(all.triangleCount());
    if (receivers.empty()) return copyOf(all, kept);
    const LightSpace space(frame.light);
    const glm::dvec2 half =
        choice.wholeLight ? glm::dvec2(frame.light.halfU, frame.light.halfV) : glm::dvec2(0.0);
    const Shaft shaft(boxOf(receivers, choice.marginM), half);
    for (std::size_t p = 0; p < all.parts.size(); ++p) {
        const Part& part = all.parts[p];
        const PartFacts& facts = frame.casterFacts.parts[p];
        if (choice.onlyCasting && !facts.casts) continue;
        if (choice.onlyInTheWay && !facts.inTheWay) continue;
        const double outward = isOutside(frame.light, half, facts.bodies) ? facts.outward : 0;
        tbb::parallel_for(
            tbb::blocked_range<std::uint32_t>(part.firstIndex / 3,
                                              (part.firstIndex + part.indexCount) / 3, 4096),
            [&](const auto& range) {
                for (std::uint32_t t = range.begin(); t < range.end(); ++t) {
                    const auto at = [&](std::uint32_t corner) {
                        return space.point(glm::dvec3(all.positions[all.indices[3 * t + corner]]));
                    };
                    const glm::dvec3 a = at(0), b = at(1), c = at(2);
                    kept[t] = !shaft.misses(a, b, c) &&
                              !(outward != 0.0 && isTurnedAway(a, b, c, outward, half));
                }
            });
    }
    return copyOf(all, kept);
}

}  // namespace penumbra
