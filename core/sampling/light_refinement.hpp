#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/sampling/light_tree.hpp"

namespace penumbra {

/// Refines a LightTree level by level (Schwaerzler 2009, section 3.3): whoever judges makes the
/// maps of the samples that are new and says what each new part of the light differs by; parts that
/// differ by epsilon or more are split, those that differ most first. Knows neither maps nor
/// pixels.
class LightRefinement {
  public:
    struct Limits {
        double epsilon = 0.0;     ///< 0 splits all
        int mostSamples = 4;      ///< 4 at least
        bool centreTest = false;  ///< every part that can be split gets a sample amid it, too
        bool reuse = false;       ///< starts with the last call's splits, less what it could spare
    };
    /// A part of the light and what its maps differ by, in the unit of epsilon.
    struct Part {
        LightTree::Leaf leaf;
        double error = 0.0;
        std::size_t index = 0;  ///< among the tree's leaves, if it is one
    };
    /// Called once per level with the parts that are new, whose `error` is to be set, and how many
    /// of the tree's samples were there at the last call.
    using Judge = std::function<void(const LightTree& tree, std::span<Part> parts, int known)>;

    /// `undivided` is refined to where `limits` allow. With `reuse` also what was split but whose
    /// parts are whole is judged, and split no more next time where it differs by less.
    void run(LightTree undivided, const Limits& limits, const Judge& judge);

    const LightTree& tree() const { return tree_; }
    /// What the tree came to and what stopped it, and the tree itself, for a row's message: parts
    /// in preorder, + split (its parts follow, along u first), . not.
    std::string summary() const;

  private:
    int samples() const { return static_cast<int>(tree_.sampleCount()); }
    void replay();
    void remember(std::span<const LightTree::Leaf> superfluous);
    std::vector<std::size_t> split(std::vector<Part> parts);

    LightTree tree_;
    Limits limits_;
    std::vector<LightTree::Leaf> before_;  ///< what the previous run split, in its order
    glm::bvec2 extent_{false};             ///< of that run's light
    int denied_ = 0;
};

}  // namespace penumbra
