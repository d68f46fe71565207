#include "core/sampling/light_refinement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace penumbra {

void LightRefinement::run(LightTree undivided, const Limits& limits, const Judge& judge) {
    tree_ = std::move(undivided);
    limits_ = limits;
    denied_ = 0;
    if (limits_.reuse && tree_.extent() == extent_) replay();
    std::vector<LightTree::Leaf> superfluous;
    std::vector<std::size_t> level(tree_.leaves().size());
    std::iota(level.begin(), level.end(), std::size_t{0});
    for (int known = 0; !level.empty();) {
        std::vector<Part> parts;
        for (const std::size_t index : level) {
            if (!tree_.canSplit(tree_.leaves()[index])) continue;
            if (limits_.centreTest && samples() < limits_.mostSamples) tree_.addCentre(index);
            parts.push_back({tree_.leaves()[index], 0.0, index});
        }
        const std::size_t leaves = parts.size();
        if (limits_.reuse && known == 0)
            for (const LightTree::Leaf& twig : tree_.inner())
                if (tree_.isTwig(twig)) parts.push_back({twig});
        judge(tree_, parts, known);
        known = samples();
        for (std::size_t i = leaves; i < parts.size(); ++i)
            if (parts[i].error < limits_.epsilon) superfluous.push_back(parts[i].leaf);
        parts.resize(leaves);
        level = split(std::move(parts));
    }
    if (limits_.reuse) remember(superfluous);
}

/// The previous run's splits again.
void LightRefinement::replay() {
    for (const LightTree::Leaf& part : before_) {
        const std::size_t leaf = tree_.find(part.low, part.depth);
        if (leaf == tree_.leaves().size() ||
            samples() + tree_.samplesIfSplit(leaf) > limits_.mostSamples)
            continue;
        if (limits_.centreTest) tree_.addCentre(leaf);
        tree_.split(leaf);
    }
}

/// This run's splits, but for those that it could have done without.
void LightRefinement::remember(std::span<const LightTree::Leaf> superfluous) {
    extent_ = tree_.extent();
    before_.clear();
    for (const LightTree::Leaf& part : tree_.inner()) {
        const bool dropped = std::ranges::any_of(superfluous, [&](const auto& twig) {
            return twig.low == part.low && twig.depth == part.depth && tree_.isTwig(part);
        });
        if (!dropped) before_.push_back(part);
    }
}

/// Splits what differs by epsilon or more; returns the new leaves.
std::vector<std::size_t> LightRefinement::split(std::vector<Part> parts) {
    std::erase_if(parts, [&](const Part& part) { return part.error < limits_.epsilon; });
    std::ranges::stable_sort(parts, std::ranges::greater{}, &Part::error);
    std::vector<std::size_t> level;
    for (const Part& part : parts) {
        if (samples() + tree_.samplesIfSplit(part.index) > limits_.mostSamples) {
            ++denied_;
            continue;
        }
        level.push_back(part.index);
        const std::size_t first = tree_.leaves().size();
        tree_.split(part.index);
        for (std::size_t i = first; i < tree_.leaves().size(); ++i) level.push_back(i);
    }
    return level;
}

std::string LightRefinement::summary() const {
    const auto deepest = std::ranges::count_if(
        tree_.leaves(), [&](const auto& leaf) { return !tree_.canSplit(leaf); });
    return fmt::format("{} maps; {} of {} parts at max_depth, {} refused by max_maps; tree {}",
                       samples(), deepest, tree_.leaves().size(), denied_, tree_.preorder());
}

}  // namespace penumbra
