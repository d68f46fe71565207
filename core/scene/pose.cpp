#include "core/scene/pose.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

namespace penumbra::scene_detail {
namespace {

/// The inverse transpose up to a positive factor. The cofactors are that times the determinant, and
/// exist for flattening matrices too.
glm::dmat3 normalMatrixOf(const glm::dmat3& linear) {
    const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                               glm::cross(linear[0], linear[1]));
    return glm::determinant(linear) < 0.0 ? cofactors * -1.0 : cofactors;
}

/// No vector gets longer by more.
double scaleOf(const glm::dmat4& matrix) {
    const double x = glm::length(glm::dvec3(matrix[0])), y = glm::length(glm::dvec3(matrix[1])),
                 z = glm::length(glm::dvec3(matrix[2]));
    return std::sqrt(x * x + y * y + z * z);
}

}  // namespace

std::vector<glm::dmat4> worldMatrices(const std::vector<AssetNode>& nodes,
                                      const std::vector<NodeTrack>& tracks, double timeS) {
    std::vector<Transform> transforms;
    transforms.reserve(nodes.size());
    for (const AssetNode& node : nodes) transforms.push_back(node.transform);
    for (const NodeTrack& track : tracks) {
        if (track.property == NodeProperty::weight) continue;
        transforms[track.node].set(track.property, track.curve.at(timeS));
    }
    std::vector<glm::dmat4> world(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        world[i] = nodes[i].hasMatrix ? nodes[i].matrix : transforms[i].matrix();
        if (nodes[i].parent >= 0) world[i] = world[nodes[i].parent] * world[i];
    }
    return world;
}

std::size_t Pose::hash() const {
    std::size_t hash = 14695981039346656037u;  // FNV-1a over 64-bit words
    const auto mix = [&](double value) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        hash = (hash ^ (value == 0.0 ? 0 : bits)) * 1099511628211u;
    };
    for (const glm::dmat4& matrix : matrices) {
        for (int k = 0; k < 16; ++k) mix(matrix[k / 4][k % 4]);
    }
    for (const double weight : weights) mix(weight);
    return hash;
}

PoseLayout::PoseLayout(const Asset& asset) {
    std::map<std::pair<int, int>, std::size_t> known;
    std::size_t matrices = 0, weights = 0;
    for (const Placement& placement : asset.placements) {
        const auto [at, isNew] =
            known.try_emplace(std::pair(placement.node, placement.skin), sources_.size());
        if (isNew) {
            const PoseRange range{
                matrices, placement.skin < 0 ? 1 : asset.skins[placement.skin].joints.size(),
                weights, asset.nodes[placement.node].weights.size()};
            matrices += range.matrixCount;
            weights += range.weightCount;
            sources_.push_back({placement.node, placement.skin, range});
        }
        ranges_.push_back(sources_[at->second].range);
    }
}

std::size_t PoseLayout::bytes() const {
    std::size_t bytes = 0;
    for (const Source& source : sources_) {
        bytes += source.range.matrixCount * sizeof(glm::dmat4) +
                 source.range.weightCount * sizeof(double);
    }
    return bytes;
}

Pose PoseLayout::at(const Asset& asset, const std::vector<NodeTrack>& tracks,
                    const std::vector<glm::dmat4>& world, double timeS) const {
    Pose pose;
    std::vector<std::size_t> firstWeight(asset.nodes.size(), SIZE_MAX);
    for (const Source& source : sources_) {
        if (source.skin < 0) {
            pose.matrices.push_back(world[source.node]);
        } else {
            const AssetSkin& skin = asset.skins[source.skin];
            for (std::size_t k = 0; k < skin.joints.size(); ++k) {
                pose.matrices.push_back(world[skin.joints[k]] * skin.inverseBind[k]);
            }
        }
        const std::vector<double>& weights = asset.nodes[source.node].weights;
        firstWeight[source.node] = pose.weights.size();
        pose.weights.insert(pose.weights.end(), weights.begin(), weights.end());
    }
    for (const NodeTrack& track : tracks) {
        if (track.property != NodeProperty::weight || firstWeight[track.node] == SIZE_MAX) continue;
        const auto target = static_cast<std::size_t>(track.target);
        pose.weights[firstWeight[track.node] + target] = track.curve.at(timeS).x;
    }
    return pose;
}

PrimitiveReach::PrimitiveReach(const AssetPrimitive& primitive,
                               std::span<const glm::dmat4> instances) {
    const auto greatest = [](const std::vector<glm::vec3>& vectors) {
        double length = 0.0;
        for (const glm::vec3& v : vectors) length = std::max(length, glm::length(glm::dvec3(v)));
        return length;
    };
    rest_ = greatest(primitive.positions);
    for (const MorphTarget& target : primitive.targets) {
        targets_.push_back(greatest(target.positions));
    }
    for (const glm::dmat4& instance : instances) {
        scale_ = std::max(scale_, scaleOf(instance));
        offset_ = std::max(offset_, glm::length(glm::dvec3(instance[3])));
    }
}

double PrimitiveReach::in(std::span<const glm::dmat4> matrices,
                          std::span<const double> weights) const {
    double local = rest_;
    for (std::size_t t = 0; t < targets_.size(); ++t) local += std::abs(weights[t]) * targets_[t];
    const double placed = scale_ * local + offset_;
    double reach = 0.0;
    for (const glm::dmat4& matrix : matrices) {
        const double each = scaleOf(matrix) * placed + glm::length(glm::dvec3(matrix[3]));
        reach = each > reach || std::isnan(each) ? each : reach;
    }
    return reach;
}

VertexPlacer::VertexPlacer(const AssetPrimitive& primitive, std::span<const glm::dmat4> matrices,
                           std::span<const double> weights, const glm::dvec3& origin)
    : primitive_(primitive),
      matrices_(matrices),
      weights_(weights),
      origin_(origin),
      rigid_{glm::dmat3(matrices[0]), glm::dvec3(matrices[0][3]) - origin},
      normalMatrix_(normalMatrixOf(rigid_.linear)),
      mirrored_(glm::determinant(rigid_.linear) < 0.0) {}

VertexPlacer::Affine VertexPlacer::blended(std::size_t vertex) const {
    glm::dmat4 sum(0.0);
    const auto influences = static_cast<std::size_t>(primitive_.influences);
    for (std::size_t k = influences * vertex; k < influences * (vertex + 1); ++k) {
        sum += static_cast<double>(primitive_.jointWeights[k]) * matrices_[primitive_.joints[k]];
    }
    return {glm::dmat3(sum), glm::dvec3(sum[3]) - origin_};
}

glm::dvec3 VertexPlacer::position(std::size_t vertex) const {
    glm::dvec3 local(primitive_.positions[vertex]);
    for (std::size_t t = 0; t < primitive_.targets.size(); ++t) {
        const MorphTarget& target = primitive_.targets[t];
        if (!target.positions.empty()) {
            local += weights_[t] * glm::dvec3(target.positions[vertex]);
        }
    }
    if (primitive_.influences == 0) return rigid_.linear * local + rigid_.offset;
    const Affine matrix = blended(vertex);
    return matrix.linear * local + matrix.offset;
}

glm::dvec3 VertexPlacer::normal(std::size_t vertex) const {
    glm::dvec3 local(primitive_.normals[vertex]);
    for (std::size_t t = 0; t < primitive_.targets.size(); ++t) {
        const MorphTarget& target = primitive_.targets[t];
        if (!target.normals.empty()) local += weights_[t] * glm::dvec3(target.normals[vertex]);
    }
    const glm::dvec3 normal = primitive_.influences == 0
                                  ? normalMatrix_ * local
                                  : normalMatrixOf(blended(vertex).linear) * local;
    const double length = glm::length(normal);
    return length > 0.0 ? normal / length : glm::dvec3(0, 1, 0);
}

}  // namespace penumbra::scene_detail
