#pragma once

#include <vector>

#include "core/frame/casters.hpp"
#include "core/scene/geometry.hpp"
#include "core/scene/material.hpp"

namespace penumbra {

/// What shadows need to know of one Part.
struct PartFacts {
    /// Some body of its has no inside (Casters::thicknessM is next to nothing), or its material is
    /// cut out by alpha.
    bool thin = true;
    /// It may block a ray from a scored or horizon pixel's point to the light. Where it does not,
    /// no visibility changes without it. What a filter makes of a map may: a part that shadows
    /// nothing is often a receiver. Leave it out of a map only where the plan has no
    /// Effect::self_shadow.
    bool casts = true;
    /// It casts, or may block a ray that a map's texel stands for, which ends beside the point
    /// (CasterFacts::besideTangent). Where it does not, no comparison of such a ray finds it
    /// (MapParts::compared).
    bool inTheWay = true;
    /// The way from all of its triangles' normals, by the right-hand rule, out of the bodies they
    /// bound: 1 along them, -1 against them; 0 where the part is thin or they do not agree.
    int outward = 0;
    Bounds bodies;  ///< of all bodies that the part is of
    bool operator==(const PartFacts&) const = default;
};

/// What a frame's triangles are to its shadows.
struct CasterFacts {
    std::vector<PartFacts> parts;  ///< one for each Part of the frame's Geometry, in its order
    /// Rays that were looked at for PartFacts::inTheWay end up to so far beside the point along
    /// each of the light's sides, and are nearer to the light by as much as the farther of them,
    /// which is what a bias does; over the point's distance from the light's plane.
    double besideTangent = 0.0;
    bool operator==(const CasterFacts&) const = default;

    /// Which parts are thin; every part counts as casting. `bodies` are the geometry's.
    static CasterFacts find(const Geometry& geometry, const std::vector<Material>& materials,
                            const Casters& bodies);
};

}  // namespace penumbra
