#include "core/sampling/light_tree.hpp"

#include <algorithm>
#include <cmath>

namespace penumbra {

LightTree::LightTree(glm::bvec2 extent, int maxDepth) : extent_(extent), maxDepth_(maxDepth) {
    leaves_.push_back(leafAt(glm::ivec2(0), 0));
}

int LightTree::sampleAt(glm::ivec2 place) {
    const auto [entry, added] =
        indices_.try_emplace({place.x, place.y}, static_cast<int>(samples_.size()));
    if (added) samples_.push_back(place);
    return entry->second;
}

glm::ivec2 LightTree::place(const Leaf& leaf, int corner) const {
    const glm::ivec2 beyond(extent_.x ? corner & 1 : 0, extent_.y ? corner >> 1 : 0);
    return leaf.low + beyond * steps(leaf.depth);
}

LightTree::Leaf LightTree::leafAt(glm::ivec2 low, int depth) {
    Leaf leaf{low, depth};
    for (int corner = 0; corner < 4; ++corner)
        leaf.corners[static_cast<std::size_t>(corner)] = sampleAt(place(leaf, corner));
    return leaf;
}

void LightTree::split(std::size_t index) {
    const Leaf whole = inner_.emplace_back(leaves_[index]);
    const int half = steps(whole.depth + 1);
    bool first = true;
    for (int y = 0; y <= (extent_.y ? 1 : 0); ++y)
        for (int x = 0; x <= (extent_.x ? 1 : 0); ++x) {
            const Leaf part = leafAt(whole.low + half * glm::ivec2(x, y), whole.depth + 1);
            if (first)
                leaves_[index] = part;
            else
                leaves_.push_back(part);
            first = false;
        }
}

std::size_t LightTree::find(glm::ivec2 low, int depth) const {
    const auto found = std::ranges::find_if(
        leaves_, [&](const Leaf& leaf) { return leaf.low == low && leaf.depth == depth; });
    return static_cast<std::size_t>(found - leaves_.begin());
}

bool LightTree::isTwig(const Leaf& inner) const {
    const int half = steps(inner.depth + 1);
    for (int y = 0; y <= (extent_.y ? 1 : 0); ++y)
        for (int x = 0; x <= (extent_.x ? 1 : 0); ++x)
            if (find(inner.low + half * glm::ivec2(x, y), inner.depth + 1) == leaves_.size())
                return false;
    return true;
}

int LightTree::samplesIfSplit(std::size_t index) const {
    const Leaf& leaf = leaves_[index];
    const int half = steps(leaf.depth + 1);
    int added = 0;
    for (int y = 0; y <= (extent_.y ? 2 : 0); ++y)
        for (int x = 0; x <= (extent_.x ? 2 : 0); ++x)
            added += !indices_.contains({leaf.low.x + x * half, leaf.low.y + y * half});
    return added;
}

void LightTree::addCentre(std::size_t index) {
    Leaf& leaf = leaves_[index];
    leaf.centre = sampleAt(leaf.low + steps(leaf.depth + 1) *
                                          glm::ivec2(extent_.x ? 1 : 0, extent_.y ? 1 : 0));
}

glm::dvec2 LightTree::position(std::size_t sample) const {
    const glm::dvec2 st = glm::dvec2(samples_[sample]) / static_cast<double>(steps(0));
    return {extent_.x ? 2.0 * st.x - 1.0 : 0.0, extent_.y ? 2.0 * st.y - 1.0 : 0.0};
}

double LightTree::area(const Leaf& leaf) const {
    return std::exp2(-(extent_.x + extent_.y) * leaf.depth);
}

int LightTree::deepest() const {
    return std::ranges::max(leaves_, {}, &Leaf::depth).depth;
}

std::vector<double> LightTree::weights(LightTreeWeights kind) const {
    if (kind == LightTreeWeights::equal)
        return std::vector<double>(sampleCount(), 1.0 / static_cast<double>(sampleCount()));
    const int axes = extent_.x + extent_.y;
    std::vector<double> weights(sampleCount(), 0.0);
    if (kind == LightTreeWeights::leafArea) {
        for (const Leaf& leaf : leaves_) {
            // A sample amid a leaf stands for half of it: the mean of the trapezoidal and the
            // midpoint rule, in whole multiples of the deepest leaf's corners.
            const double whole = area(leaf);
            const double shared = leaf.centre >= 0 ? 0.5 * whole : whole;
            for (const int corner : leaf.corners)
                weights[static_cast<std::size_t>(corner)] += shared / 4.0;
            if (leaf.centre >= 0) weights[static_cast<std::size_t>(leaf.centre)] += whole - shared;
        }
        return weights;
    }
    std::vector<int> depths(sampleCount(), 0);
    const auto incident = [&](int sample, int depth) {
        int& deepest = depths[static_cast<std::size_t>(sample)];
        deepest = std::max(deepest, depth);
    };
    for (const Leaf& leaf : leaves_) {
        for (const int corner : leaf.corners) incident(corner, leaf.depth);
        if (leaf.centre >= 0) incident(leaf.centre, leaf.depth + 1);
    }
    for (std::size_t i = 0; i < weights.size(); ++i)
        weights[i] = std::pow(std::exp2(depths[i]) + 1.0, -axes);
    return weights;
}

}  // namespace penumbra
