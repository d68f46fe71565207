#pragma once

#include <compare>
#include <cstddef>
#include <memory>

#include "core/scene/scene.hpp"

namespace penumbra {

/// What a study changes about a scene; all else stays.
struct Variation {
    double lightScale = 1.0;  ///< of both sides of the light, about its centre; 0 or more
    int subdivisions = 0;     ///< times that every triangle is cut in four: 4^n as many triangles

    bool operator==(const Variation&) const = default;
    auto operator<=>(const Variation&) const = default;
};

/// Every triangle cut in four at its edges' middles, `times` times. The surface stays where it is,
/// to half an ulp, and closed where it was closed: an edge's middle is the same float from both
/// sides. Normals and texture coordinates are interpolated. Throws InputError beyond
/// kMostTriangles.
std::shared_ptr<const Geometry> subdivided(std::shared_ptr<const Geometry> geometry, int times);

/// The most that a subdivided scene may have: some 300 MiB of vertices and tree.
inline constexpr std::size_t kMostTriangles = 4'000'000;

/// `scene` under `variation`; the scene itself where that changes nothing.
std::shared_ptr<const Scene> varied(std::shared_ptr<const Scene> scene, const Variation& variation);

}  // namespace penumbra
