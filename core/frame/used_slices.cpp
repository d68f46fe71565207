#include "core/frame/used_slices.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace penumbra {
namespace {

/// Depths on the GPU are floats: what lies on a boundary may be drawn to either side of it.
double roundingM(const SliceView& view) {
    return 1e-5 * view.farM;
}

/// Sides of the frustum that a point is beyond, and the light's plane.
unsigned beyond(const SliceView& view, const glm::dvec3& p) {
    constexpr double kRounding = 1e-5;  // of the texture
    const double w = view.orthographic ? 1.0 : p.z + view.copM;
    const glm::dvec2 uv = glm::dvec2(p) * view.scale + view.offset * w;
    const double margin = kRounding * w;
    return unsigned{uv.x < -margin} | unsigned{uv.x > w + margin} << 1 |
           unsigned{uv.y < -margin} << 2 | unsigned{uv.y > w + margin} << 3 |
           unsigned{p.z < 0.0} << 4;
}

}  // namespace

SliceSet slicesWithCasters(const SliceView& view, const Geometry& geometry) {
    const glm::dmat3 axes = glm::transpose(glm::dmat3(view.axisX, view.axisY, view.axisZ));
    const auto ofTriangle = [&](std::size_t t) {
        unsigned outside = ~0u;
        double nearM = std::numeric_limits<double>::infinity(), farM = -nearM;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec3 p =
                axes * (glm::dvec3(geometry.positions[geometry.indices[3 * t + k]]) - view.centre);
            nearM = std::min(nearM, p.z);
            farM = std::max(farM, p.z);
            outside &= beyond(view, p);
        }
        SliceSet slices = 0;
        if (outside) return slices;
        // What is nearer than the first boundary by rounding belongs to the first slice.
        for (std::size_t k = 0; k < view.planesM.size(); ++k)
            if (nearM <= view.boundariesM[k + 1] + roundingM(view) &&
                (k == 0 || farM >= view.boundariesM[k] - roundingM(view)))
                slices |= SliceSet{1} << k;
        return slices;
    };
    constexpr std::size_t kGrain = 4096;
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, geometry.triangleCount(), kGrain), SliceSet{0},
        [&](const tbb::blocked_range<std::size_t>& range, SliceSet slices) {
            for (std::size_t t = range.begin(); t < range.end(); ++t) slices |= ofTriangle(t);
            return slices;
        },
        std::bit_or<>());
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
