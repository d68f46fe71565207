#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/geometry.hpp"

namespace penumbra {

/// The bodies that a frame's triangles form: sets of triangles connected at shared places, whatever
/// parts, normals and texture coordinates say.
struct Casters {
    std::vector<std::uint32_t> ofVertex;  ///< caster that a vertex of the geometry belongs to
    /// Mean thickness of each, metres: twice its volume over its area, 0 where it has no inside
    /// because some edge has a triangle on one side only.
    std::vector<double> thicknessM;
    /// Whether the normals of its triangles, by the right-hand rule, point into it; means something
    /// where it has an inside.
    std::vector<char> insideOut;

    /// Of positions that are finite. O(n) in the triangles.
    static Casters find(const Geometry& geometry);
};

}  // namespace penumbra
