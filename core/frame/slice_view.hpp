#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/frame/frame.hpp"

namespace penumbra {

/// How SliceView::fit cuts.
struct SliceSettings {
    int slices = 16;
    int mapSize = 512;          ///< texels across: one of them is left as a margin
    bool orthographic = false;  ///< project along the light's normal instead of from a point
    double copFactor = 1.0;     ///< scales the centre of projection's distance
    bool quantiles = false;     ///< boundaries follow where the casters' area is
    bool snap = true;           ///< planes at the deepest caster of a slice, not at its boundary
};

/// The space between a light and the receivers that the camera sees, cut into slices parallel to
/// the light, as one frustum from a centre of projection behind it (Eisemann, Decoret 2006, 3.4).
/// Light coordinates are centred on the light, x along axisU, y along axisV, z away from it. The
/// frustum holds every way between a receiver and the light from the first slice's plane on: no
/// kernel leaves the texture.
///
/// The paper puts the centre of projection so far behind the light that the frustum through the
/// light's own rectangle just holds the scene; farther away the scene would jut out, nearer the
/// frustum would be wider than the scene. A receiver at (x, z) beyond half extent h bounds it by
/// h z / (|x| - h). Light and scene need not have one shape: here that distance is the longer one
/// of both axes, and the other axis is widened by as much as its receivers need. Since no kernel
/// lies above the first plane, the centre may be nearer, too, down to the light's own centre, where
/// flattening a slice moves no caster off the ray on which the light's centre sees it.
///
/// The part between the last boundary and the farthest receiver has no texture: what lies there
/// can shadow nobody, for a slice does not shadow what it contains.
struct SliceView {
    glm::dvec3 centre{0.0};  ///< the light's, relative to Scene::origin
    glm::dvec3 axisX{1, 0, 0}, axisY{0, 1, 0}, axisZ{0, 0, 1};
    bool orthographic = false;
    double copM = 0.0;                     ///< metres from the light back to the centre
    glm::dvec2 scale{1.0}, offset{0.0};    ///< uv = xy * shrink(z) * scale + offset
    double farM = 1.0;                     ///< depth of the farthest receiver
    std::vector<double> boundariesM{0.0};  ///< slices + 1 depths, ascending
    std::vector<double> planesM;           ///< of slices: where their contents are projected to

    /// Throws Unsupported where a receiver is beyond 70 degrees as seen from the light's rim.
    static SliceView fit(const Frame& frame, const SliceSettings& settings);

    double shrink(double zM) const { return orthographic ? 1.0 : 1.0 / (zM + copM); }
    /// Clip space for positions relative to Scene::origin: what is behind the light is clipped.
    glm::mat4 clipFromWorld() const;
    /// Extents in uv of the light seen on plane `planeM` from a receiver at depth `zM` (eq. 4).
    glm::dvec2 kernelUv(const AreaLight& light, double zM, double planeM) const;
};

}  // namespace penumbra
