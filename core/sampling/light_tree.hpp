#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace penumbra {

/// How much each sample of a LightTree counts.
enum class LightTreeWeights {
    leafArea,    ///< every leaf shares its area among its samples: the trapezoidal rule; the rim
                 ///< outside the outermost samples is theirs
    localDepth,  ///< Schwaerzler 2009, eqs 5 and 6, d the depth of the deepest leaf at the sample
    equal,
};

/// Where a light is sampled by the recursive subdivision of Schwaerzler 2009, sections 3.3.1 and
/// 3.3.5: a leaf has samples at its corners (the two ends of a linear light's) and is split in two
/// along every axis that has extent. Samples lie on a lattice of 2^maxDepth steps along such an
/// axis and are shared: each is listed once, however many leaves meet there.
///
/// The paper's lattice goes from rim to rim, whose samples stand for less of the light than others
/// and so are wasted in part. With a rim depth d the lattice is drawn in so that, were the tree d
/// deep everywhere, samples would be the centres of (2^d + 1)^2 equal cells.
class LightTree {
  public:
    struct Leaf {
        glm::ivec2 low;   ///< lattice coordinates of its least corner
        int depth = 0;    ///< 0: the whole light
        int centre = -1;  ///< index of the sample amid it, where it has one
        /// Indices of its samples at low, +u, +v, +u +v; along an axis without extent both are one.
        std::array<int, 4> corners{};
    };

    LightTree() = default;
    /// The undivided light with its corners. `extent`: which axes have extent, one at least;
    /// `maxDepth` 0 to 14; `rimDepth` 0 to 14, none: corners are the light's.
    LightTree(glm::bvec2 extent, int maxDepth, std::optional<int> rimDepth = {});

    /// Replaces leaf `index` by its 2 or 4 parts: the first takes its place, the others come last.
    /// A leaf of the greatest depth is not to be split.
    void split(std::size_t index);
    /// How many samples split(index) would add.
    int samplesIfSplit(std::size_t index) const;
    /// Gives a leaf a sample amid it, which its parts share as a corner. For leaves that can be
    /// split.
    void addCentre(std::size_t index);

    const std::vector<Leaf>& leaves() const { return leaves_; }
    /// What has been split, as it was, in the order in which it was.
    const std::vector<Leaf>& inner() const { return inner_; }
    /// Index of the leaf of `depth` at `low`; leaves().size() where there is none.
    std::size_t find(glm::ivec2 low, int depth) const;
    /// Whether all parts of `inner` are leaves.
    bool isTwig(const Leaf& inner) const;
    bool canSplit(const Leaf& leaf) const { return leaf.depth < maxDepth_; }
    /// Samples in the order in which they were added.
    std::size_t sampleCount() const { return samples_.size(); }
    /// In [-1,1] along the light's axes; 0 along one without extent.
    glm::dvec2 position(std::size_t sample) const;
    glm::bvec2 extent() const { return extent_; }
    double area(const Leaf& leaf) const;  ///< its share of the light, or of the lattice on it
    int deepest() const;                  ///< depth of the deepest leaf
    /// What all weights of leafArea are whole multiples of.
    double leafAreaUnit() const;
    /// The leaves as they nest: + what is split, its parts following along u first, . a leaf.
    std::string preorder() const;

    /// One weight per sample, none negative. Those of leafArea sum to 1; those of localDepth do if
    /// all leaves are equally deep, and are to be normalised otherwise; equal ones are 1/n.
    std::vector<double> weights(LightTreeWeights kind) const;

  private:
    int sampleAt(glm::ivec2 place);
    glm::ivec2 place(const Leaf& leaf, int corner) const;
    Leaf leafAt(glm::ivec2 low, int depth);
    int steps(int depth) const { return 1 << (maxDepth_ - depth); }
    double halfWithRim(const Leaf& leaf, int axis, bool high) const;
    void preorder(glm::ivec2 low, int depth, std::string& text) const;

    glm::bvec2 extent_{true};
    int maxDepth_ = 0;
    double rim_ = 0.0;  ///< beyond the outermost samples, in widths of the lattice
    std::vector<Leaf> leaves_, inner_;
    std::vector<glm::ivec2> samples_;  ///< lattice coordinates
    std::map<std::pair<int, int>, int> indices_;
};

/// The tree's weights, scaled so that leaf areas are whole numbers and equals 1, whose sums in
/// float are exact.
std::vector<float> unitWeights(const LightTree& tree, LightTreeWeights kind);

}  // namespace penumbra
