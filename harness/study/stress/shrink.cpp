#include "harness/study/stress/shrink.hpp"

#include <cmath>
#include <vector>

namespace penumbra::stress {
namespace {

double rounded(double value, double step) {
    return std::round(value / step) * step;
}

glm::dvec3 rounded(const glm::dvec3& v, double step) {
    return {rounded(v.x, step), rounded(v.y, step), rounded(v.z, step)};
}

/// Every draw that is one step simpler than `draw`, the boldest first.
std::vector<Draw> simpler(const Draw& draw) {
    std::vector<Draw> list;
    const auto with = [&](const auto& change) {
        Draw next = draw;
        change(next);
        list.push_back(std::move(next));
    };
    for (std::size_t i = draw.scene.bodies.size(); i-- > 0;)
        if (draw.scene.bodies.size() > 1)
            with([&](Draw& d) {
                d.scene.bodies.erase(d.scene.bodies.begin() + static_cast<std::ptrdiff_t>(i));
            });
    with([](Draw& d) { d.scene.placement = {}; });
    with([](Draw& d) { d.scene.placement.offset = {}; });
    with([](Draw& d) { d.scene.placement.rotateDeg = {}; });
    with([](Draw& d) { d.scene.placement.scale = 1.0; });
    for (std::size_t i = 0; i < draw.assignments.size(); ++i)
        with([&](Draw& d) {
            d.assignments.erase(d.assignments.begin() + static_cast<std::ptrdiff_t>(i));
        });
    if (draw.size > 8) with([](Draw& d) { d.size /= 2; });
    for (const double step : {0.5, 0.1, 0.01}) {
        for (std::size_t i = 0; i < draw.scene.bodies.size(); ++i)
            with([&](Draw& d) {
                for (auto& [key, numbers] : d.scene.bodies[i].numbers)
                    for (double& n : numbers) n = rounded(n, step);
            });
        with([&](Draw& d) { d.scene.lightPosition = rounded(d.scene.lightPosition, step); });
        with([&](Draw& d) { d.scene.lightTarget = rounded(d.scene.lightTarget, step); });
        with([&](Draw& d) {
            for (int axis = 0; axis < 2; ++axis)
                if (const double r = rounded(d.scene.lightSize[axis], step); r > 0.0)
                    d.scene.lightSize[axis] = r;
        });
        with([&](Draw& d) { d.scene.cameraPosition = rounded(d.scene.cameraPosition, step); });
        with([&](Draw& d) { d.scene.cameraTarget = rounded(d.scene.cameraTarget, step); });
        with([&](Draw& d) { d.scene.fovYDeg = rounded(d.scene.fovYDeg, 100.0 * step); });
    }
    return list;
}

bool same(const Draw& a, const Draw& b) {
    return a.scene == b.scene && a.assignments == b.assignments && a.size == b.size;
}

}  // namespace

Draw shrink(Draw draw, const std::function<bool(const Draw&)>& fails, int attempts) {
    for (bool again = true; again;) {
        again = false;
        for (const Draw& next : simpler(draw)) {
            if (same(next, draw)) continue;
            if (attempts-- <= 0) return draw;
            if (!fails(next)) continue;
            draw = next;
            again = true;
            break;
        }
    }
    return draw;
}

}  // namespace penumbra::stress
