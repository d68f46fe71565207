#include "core/frame/used_slices.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <limits>

namespace penumbra {
namespace {

/// Depths on the GPU are floats: what lies on a boundary may be drawn to either side of it.
double roundingM(const SliceView& view) {
    return 1e-5 * view.farM;
}

constexpr double kRounding = 1e-5;  // of the texture

/// A point's place in the texture times its distance w from the centre of projection.
glm::dvec3 projected(const SliceView& view, const glm::dvec3& p) {
    const double w = view.orthographic ? 1.0 : p.z + view.copM;
    return {glm::dvec2(p) * view.scale + view.offset * w, w};
}

/// Sides of the frustum that a point is beyond, and the light's plane.
unsigned beyond(const glm::dvec3& at, double depthM) {
    const double w = at.z, margin = kRounding * w;
    return unsigned{at.x < -margin} | unsigned{at.x > w + margin} << 1 |
           unsigned{at.y < -margin} << 2 | unsigned{at.y > w + margin} << 3 |
           unsigned{depthM < 0.0} << 4;
}

void join(DrawnSlices& all, const DrawnSlices& more) {
    all.slices |= more.slices;
    all.uvLo = glm::min(all.uvLo, more.uvLo);
    all.uvHi = glm::max(all.uvHi, more.uvHi);
}

}  // namespace

DrawnSlices slicesWithCasters(const SliceView& view, const Geometry& geometry) {
    const glm::dmat3 axes = glm::transpose(glm::dmat3(view.axisX, view.axisY, view.axisZ));
    const auto ofTriangle = [&](std::size_t t) {
        unsigned outside = ~0u;
        DrawnSlices drawn;
        glm::dvec2 lo(1.0), hi(0.0);
        double nearM = std::numeric_limits<double>::infinity(), farM = -nearM;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec3 p =
                axes * (glm::dvec3(geometry.positions[geometry.indices[3 * t + k]]) - view.centre);
            nearM = std::min(nearM, p.z);
            farM = std::max(farM, p.z);
            const glm::dvec3 at = projected(view, p);
            outside &= beyond(at, p.z);
            // Behind the centre of projection there is no place: anywhere.
            const bool inFront = at.z > 0.0;
            lo = glm::min(lo, inFront ? glm::dvec2(at) / at.z : glm::dvec2(0.0));
            hi = glm::max(hi, inFront ? glm::dvec2(at) / at.z : glm::dvec2(1.0));
        }
        if (outside) return drawn;
        // What is nearer than the first boundary by rounding belongs to the first slice.
        for (std::size_t k = 0; k < view.planesM.size(); ++k)
            if (nearM <= view.boundariesM[k + 1] + roundingM(view) &&
                (k == 0 || farM >= view.boundariesM[k] - roundingM(view)))
                drawn.slices |= SliceSet{1} << k;
        if (drawn.slices != 0) {
            drawn.uvLo = glm::clamp(lo - kRounding, 0.0, 1.0);
            drawn.uvHi = glm::clamp(hi + kRounding, 0.0, 1.0);
        }
        return drawn;
    };
    constexpr std::size_t kGrain = 4096;
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, geometry.triangleCount(), kGrain), DrawnSlices{},
        [&](const tbb::blocked_range<std::size_t>& range, DrawnSlices all) {
            for (std::size_t t = range.begin(); t < range.end(); ++t) join(all, ofTriangle(t));
            return all;
        },
        [](DrawnSlices all, const DrawnSlices& more) {
            join(all, more);
            return all;
        });
}

SliceSet slicesBegunBetween(const SliceView& view, double fromM, double toM) {
    SliceSet slices = 0;
    for (std::size_t k = 1; k < view.planesM.size(); ++k)
        if (view.boundariesM[k] > fromM - roundingM(view) &&
            view.boundariesM[k] < toM + roundingM(view))
            slices |= SliceSet{1} << k;
    return slices;
}

}  // namespace penumbra
