#include "core/trace/shaft.hpp"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <numeric>

namespace penumbra {

namespace {

constexpr std::uint32_t kLeafTriangles = 6;
constexpr std::uint32_t kParallelRuns = 4096;  ///< fewer are one task

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
    tbb::parallel_for(std::size_t{0}, boxes.size(), [&](std::size_t i) {
        const auto first = static_cast<std::uint32_t>(i) * run;
        for (std::uint32_t t = first; t < std::min(count, first + run); ++t)
            for (const std::uint32_t vertex : triangles[t]) boxes[i].add(vertices[vertex]);
    });
    order_.resize(boxes.size());
    std::iota(order_.begin(), order_.end(), 0u);
    if (order_.empty()) return;
    const auto runs = static_cast<std::uint32_t>(order_.size());
    NodeCounts counts;
    nodes_.resize(countNodes(runs, counts));
    build(boxes, counts, 0, 0, runs);
}

bool ShaftTree::isLeaf(std::uint32_t count) const {
    return count * run_ <= std::max(kLeafTriangles, run_);
}

std::uint32_t ShaftTree::countNodes(std::uint32_t count, NodeCounts& counts) const {
    if (isLeaf(count)) return 1;
    // Halves differ by one at most, so that each level has two counts.
    if (const auto known = counts.find(count); known != counts.end()) return known->second;
    const std::uint32_t nodes =
        1 + countNodes(count / 2, counts) + countNodes(count - count / 2, counts);
    counts.emplace(count, nodes);
    return nodes;
}

void ShaftTree::build(const std::vector<Bounds>& boxes, const NodeCounts& counts,
                      std::uint32_t index, std::uint32_t first, std::uint32_t count) {
    Bounds box, centres;
    for (std::uint32_t i = first; i < first + count; ++i) {
        const Bounds& one = boxes[order_[i]];
        box.add(one.lo);
        box.add(one.hi);
        centres.add(one.centre());
    }
    Node& node = nodes_[index];
    node.box = box;
    if (isLeaf(count)) {
        node.first = first;
        node.count = count;
        return;
    }
    const glm::dvec3 size = centres.hi - centres.lo;
    const int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
    const auto key = [&](std::uint32_t run) { return boxes[run].lo[axis] + boxes[run].hi[axis]; };
    const auto begin = order_.begin() + first;
    const std::uint32_t half = count / 2;
    std::nth_element(begin, begin + half, begin + count,
                     [&](std::uint32_t l, std::uint32_t r) { return key(l) < key(r); });
    node.right = index + 1 + (isLeaf(half) ? 1 : counts.at(half));
    const auto left = [&] { build(boxes, counts, index + 1, first, half); };
    const auto right = [&] { build(boxes, counts, node.right, first + half, count - half); };
    if (count > kParallelRuns) {
        tbb::parallel_invoke(left, right);
    } else {
        left();
        right();
    }
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
