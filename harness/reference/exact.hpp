#pragma once

#include <cstddef>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "core/scene/area_light.hpp"
#include "core/scene/material.hpp"
#include "core/trace/tracer.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {

struct ExactOptions {
    /// Pixels with more outline edges on the light than this are traced instead. A closed body has
    /// only its silhouette there however finely it is meshed; what counts is clutter: the cost
    /// grows with the edges times how many of them one line across the light meets.
    std::size_t maxEdges = 4096;
    ReferenceOptions fallback;  ///< for pixels above `maxEdges`
};

struct ExactStats {
    std::size_t exactPixels = 0;
    std::size_t tracedPixels = 0;  ///< above ExactOptions::maxEdges: those with rays > 0
};

/// The alpha-masked material of a triangle, whose outline is no polygon; null if there is none.
const Material* firstMasked(const Geometry& geometry, const std::vector<Material>& materials);
/// Throws InputError if a triangle's material is alpha-masked.
void refuseMasked(const Geometry& geometry, const std::vector<Material>& materials);

/// Visibility without noise: every triangle between the point and the light is cut to that range,
/// projected onto the light, and the area of the union of all of them is what the point does not
/// see. The coupled irradiance is Lambert's integral over the same polygons.
///
/// Answers for the points and triangles that traceReference answers for, the last 1e-4 of the way
/// to the light left out. The point is lifted off its surface just clear of the rounding of its own
/// coordinates (rays need some three times as much); else errors are those of double, about 1e-12
/// of the light. `standardError` and `rays` are 0 but for the traced pixels. A light of no width
/// takes the limit of a narrow one; a point light is seen or not. Parallel; the result does not
/// depend on the number of threads or the order of triangles. Throws InputError if a triangle's
/// material is alpha-masked.
Reference exactReference(const Tracer& tracer, const std::vector<Material>& materials,
                         const GBuffer& gbuffer, const AreaLight& light,
                         const ExactOptions& options = {}, const Progress& progress = {},
                         ExactStats* stats = nullptr);

}  // namespace penumbra
