#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/frame/frame.hpp"

namespace penumbra {

/// One frustum of a light view. Its frame is orthonormal: z away from the light, x and y across.
/// A point is at tangent coordinates t = (x/z, y/z); the tile covers [tangentLo, tangentHi], whose
/// lower corner is texture coordinate (0,0).
struct LightTile {
    glm::dvec3 axisX{1, 0, 0}, axisY{0, 1, 0}, axisZ{0, 0, 1};
    glm::dvec2 tangentLo{-1}, tangentHi{1};
    double nearM =
        0.01;  ///< depth at which the stored s = nearM / z is 1; nearer casters clamp to it

    glm::dvec2 tangentSize() const { return tangentHi - tangentLo; }
};

/// The scene as seen from the light's centre, fitted to the receivers that the camera sees. Tile 0
/// looks along the light's normal, x along axisU, its image plane parallel to the light, as PCSS
/// needs. Where receivers lie more than 70 degrees off the normal one frustum would waste its
/// texels on the rim: then the half space in front of the light is covered by five tiles (the front
/// and the sides of a half cube, told apart by the dominant axis), each fitted to its own
/// receivers.
///
/// Shadow maps store s = nearM / z with reversed depth: 0 at infinity, 1 at nearM and closer. s is
/// affine in texture coordinates over any plane, which makes the receiver-plane depth bias exact,
/// and it has the same relative precision at any distance.
struct LightView {
    glm::dvec3 centre{0.0};  ///< the light's, relative to Scene::origin
    std::vector<LightTile> tiles;

    static constexpr double kMaxTangent = 2.7474774194546216;  ///< tan 70 degrees

    /// `guardM`: metres by which a kernel may reach sideways from a receiver at the receiver's own
    /// depth; every tile is widened so that such a kernel stays inside it, and by one texel of a
    /// map of `mapSize` texels across.
    static LightView fit(const Frame& frame, glm::dvec2 guardM, int mapSize);

    /// Clip-space matrix of one tile for positions relative to Scene::origin, for glClipControl
    /// ZERO_TO_ONE with reversed depth: ndc.z = nearM / z.
    glm::mat4 clipFromWorld(std::size_t tile) const;
};

}  // namespace penumbra
