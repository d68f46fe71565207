#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "core/scene/area_light.hpp"
#include "core/scene/geometry.hpp"

namespace penumbra {

/// What of a frame lies in front of one side of the light, in tangent coordinates t = (x/z, y/z) of
/// that side's frame. Empty where no receiver is.
struct SideBounds {
    glm::dvec2 tangentLo{1e300}, tangentHi{-1e300};  ///< of the receivers
    double receiverNearM = 1e300, receiverFarM = 0;  ///< depths z of the receivers
    double casterNearM = 1e300;                      ///< least positive depth of any vertex
    bool empty() const { return receiverFarM <= 0.0; }
    bool operator==(const SideBounds&) const = default;
};

/// Receivers in tangent coordinates of the light normal's frame, as seen from one point of the
/// light.
struct TangentBounds {
    glm::dvec2 lo{1e300}, hi{-1e300};
    bool operator==(const TangentBounds&) const = default;
};

/// The receivers that the camera sees (scored and horizon pixels) and the casters as seen from the
/// light's centre, shared by every method that fits a light view: of one frame, or of all frames
/// (united) where neither light nor casters move.
struct LightBounds {
    SideBounds whole;                 ///< all receivers in the frame of the light's normal
    std::array<SideBounds, 5> sides;  ///< split by dominant axis: front, +u, -u, +v, -v
    /// `whole`'s tangents as seen from the corners -u -v and +u +v of the light instead of its
    /// centre.
    std::array<TangentBounds, 2> fromCorners;
    glm::dvec2 acrossLo{1e300}, acrossHi{-1e300};  ///< metres along the light's u and v
    /// Some ten thousand of the receivers of each frame, relative to the scene's centre.
    std::vector<glm::vec3> receivers;
    bool operator==(const LightBounds&) const = default;
};

/// Of the receivers and casters of both.
LightBounds united(LightBounds a, const LightBounds& b);

LightBounds boundLight(const AreaLight& light, const GBuffer& gbuffer, const Geometry& geometry);

/// Orthonormal right-handed axes (x, y, z) of side `side` of the half cube around the light's
/// normal, z pointing away from the light: 0 along the normal with x along axisU, 1..4 along +u -u
/// +v -v.
std::array<glm::dvec3, 3> lightSideAxes(const AreaLight& light, std::size_t side);

}  // namespace penumbra
