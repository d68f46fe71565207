#include "core/frame/light_bounds.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cmath>

namespace penumbra {
namespace {

void include(SideBounds& b, const glm::dvec3& l) {
    const glm::dvec2 t(l.x / l.z, l.y / l.z);
    b.tangentLo = glm::min(b.tangentLo, t);
    b.tangentHi = glm::max(b.tangentHi, t);
    b.receiverNearM = std::min(b.receiverNearM, l.z);
    b.receiverFarM = std::max(b.receiverFarM, l.z);
}

void merge(TangentBounds& a, const TangentBounds& b) {
    a.lo = glm::min(a.lo, b.lo);
    a.hi = glm::max(a.hi, b.hi);
}

void merge(SideBounds& a, const SideBounds& b) {
    a.tangentLo = glm::min(a.tangentLo, b.tangentLo);
    a.tangentHi = glm::max(a.tangentHi, b.tangentHi);
    a.receiverNearM = std::min(a.receiverNearM, b.receiverNearM);
    a.receiverFarM = std::max(a.receiverFarM, b.receiverFarM);
    a.casterNearM = std::min(a.casterNearM, b.casterNearM);
}

std::size_t dominantSide(const glm::dvec3& l) {
    const double ax = std::abs(l.x), ay = std::abs(l.y);
    if (std::max(ax, ay) <= l.z) return 0;
    if (ax >= ay) return l.x > 0 ? 1 : 2;
    return l.y > 0 ? 3 : 4;
}

using Axes = std::array<glm::dvec3, 3>;

glm::dvec3 inAxes(const Axes& axes, const glm::dvec3& p) {
    return {glm::dot(axes[0], p), glm::dot(axes[1], p), glm::dot(axes[2], p)};
}

}  // namespace

LightBounds united(LightBounds a, const LightBounds& b) {
    merge(a.whole, b.whole);
    for (std::size_t i = 0; i < a.sides.size(); ++i) merge(a.sides[i], b.sides[i]);
    for (std::size_t i = 0; i < a.fromCorners.size(); ++i)
        merge(a.fromCorners[i], b.fromCorners[i]);
    a.acrossLo = glm::min(a.acrossLo, b.acrossLo);
    a.acrossHi = glm::max(a.acrossHi, b.acrossHi);
    a.receivers.insert(a.receivers.end(), b.receivers.begin(), b.receivers.end());
    return a;
}

Axes lightSideAxes(const AreaLight& light, std::size_t side) {
    const glm::dvec3 u = light.axisU, v = light.axisV, n = light.normal();
    switch (side) {
        case 0:
            return {u, v, n};
        case 1:
            return {v, n, u};
        case 2:
            return {n, v, -u};
        case 3:
            return {n, u, v};
        default:
            return {u, n, -v};
    }
}

LightBounds boundLight(const AreaLight& light, const GBuffer& gbuffer, const Geometry& geometry) {
    std::array<Axes, 5> axes;
    for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = lightSideAxes(light, i);
    using Range = tbb::blocked_range<std::size_t>;
    LightBounds receivers = tbb::parallel_reduce(
        Range(0, gbuffer.size(), 8192), LightBounds{},
        [&](const Range& range, LightBounds b) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                if (!isAsked(gbuffer.mask[i])) continue;
                const glm::dvec3 p = glm::dvec3(gbuffer.position[i]) - light.centre;
                const glm::dvec3 l = inAxes(axes[0], p);
                b.acrossLo = glm::min(b.acrossLo, glm::dvec2(l));
                b.acrossHi = glm::max(b.acrossHi, glm::dvec2(l));
                if (l.z <= 0.0) continue;
                include(b.whole, l);
                const glm::dvec2 across(l), corner(light.halfU, light.halfV);
                const glm::dvec2 low = (across + corner) / l.z, high = (across - corner) / l.z;
                merge(b.fromCorners[0], {low, low});
                merge(b.fromCorners[1], {high, high});
                const std::size_t side = dominantSide(l);
                include(b.sides[side], inAxes(axes[side], p));
            }
            return b;
        },
        united);
    const LightBounds casters = tbb::parallel_reduce(
        Range(0, geometry.positions.size(), 8192), LightBounds{},
        [&](const Range& range, LightBounds b) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                const glm::dvec3 p = glm::dvec3(geometry.positions[i]) - light.centre;
                for (std::size_t s = 0; s < axes.size(); ++s) {
                    const double z = glm::dot(axes[s][2], p);
                    if (z > 0.0) b.sides[s].casterNearM = std::min(b.sides[s].casterNearM, z);
                }
                b.whole.casterNearM = b.sides[0].casterNearM;
            }
            return b;
        },
        united);
    constexpr std::size_t kReceivers = 20000;
    const std::size_t stride = 1 + gbuffer.size() / kReceivers;
    for (std::size_t i = 0; i < gbuffer.size(); i += stride)
        if (isAsked(gbuffer.mask[i])) receivers.receivers.push_back(gbuffer.position[i]);
    return united(std::move(receivers), casters);
}

}  // namespace penumbra
