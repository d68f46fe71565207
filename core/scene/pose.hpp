#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "core/scene/asset.hpp"

namespace penumbra::scene_detail {

/// World matrices of all nodes at a time; later tracks override earlier ones.
std::vector<glm::dmat4> worldMatrices(const std::vector<AssetNode>& nodes,
                                      const std::vector<NodeTrack>& tracks, double timeS);

/// What all placements need of one time to be placed: matrices and morph weights, laid out by
/// PoseLayout.
struct Pose {
    std::vector<glm::dmat4> matrices;
    std::vector<double> weights;
    bool operator==(const Pose&) const = default;
    std::size_t hash() const;
};

/// Where in a Pose a placement finds its own: one matrix, or one for each joint of its skin.
struct PoseRange {
    std::size_t firstMatrix = 0, matrixCount = 0;
    std::size_t firstWeight = 0, weightCount = 0;

    std::span<const glm::dmat4> matricesOf(const Pose& pose) const {
        return std::span(pose.matrices).subspan(firstMatrix, matrixCount);
    }
    std::span<const double> weightsOf(const Pose& pose) const {
        return std::span(pose.weights).subspan(firstWeight, weightCount);
    }
};

/// The ranges of all placements of an asset; those of one node and skin share one.
class PoseLayout {
  public:
    explicit PoseLayout(const Asset& asset);

    const PoseRange& rangeOf(std::size_t placement) const { return ranges_[placement]; }
    /// Memory of one pose.
    std::size_t bytes() const;
    /// The pose of all placements; `world` is that of the nodes at `timeS`.
    Pose at(const Asset& asset, const std::vector<NodeTrack>& tracks,
            const std::vector<glm::dmat4>& world, double timeS) const;

  private:
    struct Source {
        int node, skin;
        PoseRange range;
    };
    std::vector<Source> sources_;
    std::vector<PoseRange> ranges_;  ///< per placement
};

/// How far from the origin of the world a primitive's vertices can be, whatever the pose.
class PrimitiveReach {
  public:
    PrimitiveReach(const AssetPrimitive& primitive, std::span<const glm::dmat4> instances);

    /// Metres, at most some four times too many. The spans are as for VertexPlacer.
    double in(std::span<const glm::dmat4> matrices, std::span<const double> weights) const;

  private:
    double rest_ = 0.0;                  ///< greatest length of a position
    std::vector<double> targets_;        ///< greatest length of a displacement
    double scale_ = 0.0, offset_ = 0.0;  ///< of the instances
};

/// A primitive's vertices where a pose puts them, relative to `origin`, in double: morph targets
/// first, then the skin's blended matrix (glTF 2.0, section 3.7.3.3) or the node's.
class VertexPlacer {
  public:
    /// `matrices`: one, or one per joint of a skinned primitive. All outlive this.
    VertexPlacer(const AssetPrimitive& primitive, std::span<const glm::dmat4> matrices,
                 std::span<const double> weights, const glm::dvec3& origin);

    glm::dvec3 position(std::size_t vertex) const;
    /// Unit, or (0, 1, 0) where it vanishes. Normals go with the inverse transpose.
    glm::dvec3 normal(std::size_t vertex) const;
    /// Whether fronts turn over. A skin's is told by its first joint.
    bool mirrored() const { return mirrored_; }

  private:
    struct Affine {
        glm::dmat3 linear;
        glm::dvec3 offset;
    };
    Affine blended(std::size_t vertex) const;

    const AssetPrimitive& primitive_;
    std::span<const glm::dmat4> matrices_;
    std::span<const double> weights_;
    glm::dvec3 origin_;
    Affine rigid_;
    glm::dmat3 normalMatrix_;  ///< of rigid_
    bool mirrored_;
};

}  // namespace penumbra::scene_detail
