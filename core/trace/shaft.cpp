#include "core/trace/shaft.hpp"

#include <algorithm>
#include <numeric>

namespace penumbra {

namespace {

constexpr std::uint32_t kLeafTriangles = 6;

}  // namespace

Shaft::Shaft(const Bounds& points, const glm::dvec2& halfLight) : hull_(points) {
    hull_.add({-halfLight.x, -halfLight.y, 0.0});
    hull_.add({halfLight.x, halfLight.y, 0.0});
    for (int axis = 0; axis < 2; ++axis) {
        for (const int sign : {1, -1}) {
            // Mirrored for the upper side. The lowest line from the light's lower end to the box
            // ends at the box's far side where it runs inwards and at its near side where it runs
            // outwards.
            const double end = sign > 0 ? points.lo[axis] : -points.hi[axis];
            const double reach = end + halfLight[axis];
            const double z = reach >= 0.0 ? points.hi.z : points.lo.z;
            sides_[2 * axis + (sign < 0)] = {axis, {sign * z, -reach}, halfLight[axis] * z};
        }
    }
}

bool Shaft::misses(const Bounds& box) const {
    for (int axis = 0; axis < 3; ++axis)
        if (box.lo[axis] > hull_.hi[axis] || box.hi[axis] < hull_.lo[axis]) return true;
    return std::any_of(sides_.begin(), sides_.end(), [&](const Side& side) {
        const double across = side.slope.x > 0.0 ? box.hi[side.axis] : box.lo[side.axis];
        const double along = side.slope.y > 0.0 ? box.hi.z : box.lo.z;
        return side.slope.x * across + side.slope.y * along + side.offset < 0.0;
    });
}

bool Shaft::misses(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const {
    for (int axis = 0; axis < 3; ++axis)
        if (std::min({a[axis], b[axis], c[axis]}) > hull_.hi[axis] ||
            std::max({a[axis], b[axis], c[axis]}) < hull_.lo[axis])
            return true;
    return std::any_of(sides_.begin(), sides_.end(), [&](const Side& side) {
        return side.at(a) < 0.0 && side.at(b) < 0.0 && side.at(c) < 0.0;
    });
}

ShaftTree::ShaftTree(const std::vector<glm::dvec3>& vertices,
                     const std::vector<std::array<std::uint32_t, 3>>& triangles, std::uint32_t run)
    : vertices_(vertices), triangles_(triangles), run_(run) {
    const auto count = static_cast<std::uint32_t>(triangles.size());
    std::vector<Bounds> boxes((count + run - 1) / run);
    for (std::uint32_t t = 0; t < count; ++t)
        for (const std::uint32_t vertex : triangles[t]) boxes[t / run].add(vertices[vertex]);
    order_.resize(boxes.size());
    std::iota(order_.begin(), order_.end(), 0u);
    if (!order_.empty()) build(boxes, 0, static_cast<std::uint32_t>(order_.size()));
}

std::uint32_t ShaftTree::build(const std::vector<Bounds>& boxes, std::uint32_t first,
                               std::uint32_t count) {
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Bounds box, centres;
    for (std::uint32_t i = first; i < first + count; ++i) {
        const Bounds& one = boxes[order_[i]];
        box.add(one.lo);
        box.add(one.hi);
        centres.add(one.centre());
    }
    nodes_[index].box = box;
    if (count * run_ <= std::max(kLeafTriangles, run_)) {
        nodes_[index].first = first;
        nodes_[index].count = count;
        return index;
    }
    const glm::dvec3 size = centres.hi - centres.lo;
    const int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
    const auto key = [&](std::uint32_t run) { return boxes[run].lo[axis] + boxes[run].hi[axis]; };
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count,
                     [&](std::uint32_t l, std::uint32_t r) { return key(l) < key(r); });
    build(boxes, first, count / 2);
    const std::uint32_t right = build(boxes, first + count / 2, count - count / 2);
    nodes_[index].right = right;
    return index;
}

void ShaftTree::query(const Shaft& shaft, std::vector<std::uint32_t>& found) const {
    found.clear();
    const auto all = [](const auto&...) { return true; };
    visit(shaft, all, [&](std::uint32_t triangle) {
        found.push_back(triangle);
        return true;
    });
}

}  // namespace penumbra
