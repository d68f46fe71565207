#include "core/scene/loaded_scene.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace penumbra::scene_detail {
namespace {

constexpr std::size_t kGrain = 16384;  // vertices or triangles per task

/// Writes one caster's positions, normals and indices into its part of `out`.
void write(const AssetPrimitive& in, const glm::dmat4& world, const glm::dvec3& origin,
           const Part& part, Geometry& out) {
    const glm::dmat3 linear(world);
    const glm::dvec3 offset = glm::dvec3(world[3]) - origin;
    const bool mirrored = glm::determinant(linear) < 0.0;
    // Normals go with the inverse transpose. The cofactors are that times the determinant, and
    // exist for flattening matrices too.
    glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                         glm::cross(linear[0], linear[1]));
    if (mirrored) cofactors *= -1.0;
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, in.positions.size(), kGrain), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                const std::size_t v = part.firstVertex + i;
                out.positions[v] = glm::vec3(linear * glm::dvec3(in.positions[i]) + offset);
                const glm::dvec3 normal = cofactors * glm::dvec3(in.normals[i]);
                const double length = glm::length(normal);
                out.normals[v] = length > 0.0 ? glm::vec3(normal / length) : glm::vec3(0, 1, 0);
            }
        });
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, in.indices.size() / 3, kGrain),
                      [&](const auto& range) {
                          for (std::size_t t = range.begin(); t < range.end(); ++t) {
                              const std::uint32_t* corner = &in.indices[3 * t];
                              std::uint32_t* written = &out.indices[part.firstIndex + 3 * t];
                              written[0] = part.firstVertex + corner[0];
                              // A mirroring matrix turns the front side over; glTF keeps it
                              // (section 3.7.4).
                              written[1] = part.firstVertex + corner[mirrored ? 2 : 1];
                              written[2] = part.firstVertex + corner[mirrored ? 1 : 2];
                          }
                      });
}

}  // namespace

std::vector<glm::dmat4> worldMatrices(const std::vector<AssetNode>& nodes,
                                      const std::vector<NodeTrack>& tracks, double timeS) {
    std::vector<Transform> transforms;
    transforms.reserve(nodes.size());
    for (const AssetNode& node : nodes) transforms.push_back(node.transform);
    for (const NodeTrack& track : tracks) {
        transforms[track.node].set(track.property, track.curve.at(timeS));
    }
    std::vector<glm::dmat4> world(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        world[i] = nodes[i].hasMatrix ? nodes[i].matrix : transforms[i].matrix();
        if (nodes[i].parent >= 0) world[i] = world[nodes[i].parent] * world[i];
    }
    return world;
}

void LoadedScene::place(std::vector<AssetPrimitive> primitives, std::vector<Caster> casters,
                        std::vector<Pose> poses, std::vector<FrameState> frames) {
    primitives_ = std::move(primitives);
    casters_ = std::move(casters);
    poses_ = std::move(poses);
    frames_ = std::move(frames);
    others_.resize(poses_.size());

    const auto geometry = std::make_shared<Geometry>();
    std::uint32_t vertices = 0, indices = 0;
    for (const Caster& caster : casters_) {
        const AssetPrimitive& in = primitives_[caster.primitive];
        const auto vertexCount = static_cast<std::uint32_t>(in.positions.size());
        const auto indexCount = static_cast<std::uint32_t>(in.indices.size());
        geometry->parts.push_back(
            {caster.name, vertices, vertexCount, indices, indexCount, in.material, caster.moves});
        geometry->uvs.insert(geometry->uvs.end(), in.uvs.begin(), in.uvs.end());
        vertices += vertexCount;
        indices += indexCount;
    }
    geometry->positions.resize(vertices);
    geometry->normals.resize(vertices);
    geometry->indices.resize(indices);
    for (std::size_t i = 0; i < casters_.size(); ++i) {
        write(primitives_[casters_[i].primitive], poses_[0][i], origin, geometry->parts[i],
              *geometry);
    }
    first_ = geometry;
}

SceneFrame LoadedScene::frame(int index) const {
    const FrameState& state = frames_.at(index);
    return {state.timeS, geometryOf(state.pose), state.light, state.camera};
}

std::shared_ptr<const Geometry> LoadedScene::geometryOf(std::size_t pose) const {
    if (pose == 0) return first_;
    {
        const std::lock_guard lock(mutex_);
        if (std::shared_ptr<const Geometry> known = others_[pose].lock()) return known;
    }
    // Made outside the lock: a thread that waits inside parallel_for may pick up a task that asks
    // for a frame itself.
    const auto made = std::make_shared<Geometry>(*first_);
    for (std::size_t i = 0; i < casters_.size(); ++i) {
        if (!casters_[i].moves) continue;
        write(primitives_[casters_[i].primitive], poses_[pose][i], origin, made->parts[i], *made);
    }
    const std::lock_guard lock(mutex_);
    if (std::shared_ptr<const Geometry> known = others_[pose].lock()) return known;
    others_[pose] = made;
    return made;
}

}  // namespace penumbra::scene_detail
