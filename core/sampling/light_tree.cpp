#include "core/sampling/light_tree.hpp"

#include <algorithm>
#include <cmath>

namespace penumbra {

LightTree::LightTree(glm::bvec2 extent, int maxDepth, std::optional<int> rimDepth)
    : extent_(extent), maxDepth_(maxDepth), rim_(rimDepth ? std::exp2(-1 - *rimDepth) : 0.0) {
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
    // From the middle, so that both sides are rounded alike.
    const glm::dvec2 st =
        (2.0 * glm::dvec2(samples_[sample]) / static_cast<double>(steps(0)) - 1.0) /
        (1.0 + 2.0 * rim_);
    return {extent_.x ? st.x : 0.0, extent_.y ? st.y : 0.0};
}

double LightTree::area(const Leaf& leaf) const {
    return std::exp2(-(extent_.x + extent_.y) * leaf.depth);
}

/// Half of a leaf along an axis, and the rim beyond it where it is outermost; in widths of the
/// lattice.
double LightTree::halfWithRim(const Leaf& leaf, int axis, bool high) const {
    const int end = high ? leaf.low[axis] + steps(leaf.depth) : leaf.low[axis];
    return std::exp2(-leaf.depth - 1) + (end == (high ? steps(0) : 0) ? rim_ : 0.0);
}

double LightTree::leafAreaUnit() const {
    const int axes = extent_.x + extent_.y;
    // A leaf's quarter, an eighth with a sample amid it; the rim halves a leaf at most as often as
    // its own depth is beyond the tree's.
    const double step =
        rim_ > 0.0 ? std::min(std::exp2(-deepest()), 2.0 * rim_) : std::exp2(-deepest());
    return std::pow(step / 2.0, axes) / 2.0 / std::pow(1.0 + 2.0 * rim_, axes);
}

std::string LightTree::preorder() const {
    std::string text;
    preorder(glm::ivec2(0), 0, text);
    return text;
}

void LightTree::preorder(glm::ivec2 low, int depth, std::string& text) const {
    const bool leaf = find(low, depth) < leaves_.size();
    text += leaf ? '.' : '+';
    if (leaf) return;
    const int half = steps(depth + 1);
    for (int y = 0; y <= (extent_.y ? 1 : 0); ++y)
        for (int x = 0; x <= (extent_.x ? 1 : 0); ++x)
            preorder(low + half * glm::ivec2(x, y), depth + 1, text);
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
        const double whole = std::pow(1.0 + 2.0 * rim_, axes);
        for (const Leaf& leaf : leaves_) {
            // A sample amid a leaf stands for half of it: the mean of the trapezoidal and the
            // midpoint rule, in whole multiples of the deepest leaf's corners.
            const double amid = leaf.centre >= 0 ? 0.5 * area(leaf) : 0.0;
            for (int corner = 0; corner < 4; ++corner) {
                double share = 1.0;
                for (int axis = 0; axis < 2; ++axis) {
                    const bool high = axis == 0 ? corner & 1 : corner >> 1;
                    share *= extent_[axis] ? halfWithRim(leaf, axis, high) : 0.5;
                }
                weights[static_cast<std::size_t>(leaf.corners[static_cast<std::size_t>(corner)])] +=
                    (share - 0.25 * amid) / whole;
            }
            if (leaf.centre >= 0) weights[static_cast<std::size_t>(leaf.centre)] += amid / whole;
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

std::vector<float> unitWeights(const LightTree& tree, LightTreeWeights kind) {
    const std::vector<double> weights = tree.weights(kind);
    const bool areas = kind == LightTreeWeights::leafArea;
    const double unit = areas ? tree.leafAreaUnit() : *std::ranges::min_element(weights);
    std::vector<float> scaled;
    for (const double weight : weights) {
        const double units = weight / unit;
        scaled.push_back(static_cast<float>(areas ? std::round(units) : units));
    }
    return scaled;
}

}  // namespace penumbra
