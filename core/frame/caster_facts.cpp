#include "core/frame/caster_facts.hpp"

#include "core/frame/casters.hpp"

namespace penumbra {
namespace {

/// Of a body's radius: thinner is a sheet that is there from both sides, its volume rounding.
constexpr double kNoInside = 1e-5;

}  // namespace

CasterFacts CasterFacts::find(const Geometry& geometry, const std::vector<Material>& materials,
                              const Casters& bodies) {
    std::vector<Bounds> bounds(bodies.thicknessM.size());
    for (const std::uint32_t i : geometry.indices)
        bounds[bodies.ofVertex[i]].add(glm::dvec3(geometry.positions[i]));
    CasterFacts facts;
    for (const Part& part : geometry.parts) {
        PartFacts fact;
        fact.thin = materials[static_cast<std::size_t>(part.material)].masked;
        bool anyOut = false, anyIn = false;
        for (std::uint32_t i = part.firstIndex; i < part.firstIndex + part.indexCount; i += 3) {
            const std::uint32_t body = bodies.ofVertex[geometry.indices[i]];
            fact.thin = fact.thin || bodies.thicknessM[body] <= kNoInside * bounds[body].radius();
            (bodies.insideOut[body] ? anyIn : anyOut) = true;
            fact.bodies.add(bounds[body].lo);
            fact.bodies.add(bounds[body].hi);
        }
        fact.outward = fact.thin || anyIn == anyOut ? 0 : anyOut ? 1 : -1;
        facts.parts.push_back(fact);
    }
    return facts;
}

}  // namespace penumbra
