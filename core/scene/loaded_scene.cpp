#include "core/scene/loaded_scene.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <span>

namespace penumbra::scene_detail {
namespace {

constexpr std::size_t kGrain = 16384;  // vertices or triangles per task

/// Of a triangle with vertices of its own, from where they are.
void writeFlatNormal(const std::uint32_t* triangle, Geometry& out) {
    const auto corner = [&](int k) { return glm::dvec3(out.positions[triangle[k]]); };
    const glm::dvec3 area = glm::cross(corner(1) - corner(0), corner(2) - corner(0));
    const double length = glm::length(area);
    const glm::vec3 normal = length > 0.0 ? glm::vec3(area / length) : glm::vec3(0, 1, 0);
    for (int k = 0; k < 3; ++k) out.normals[triangle[k]] = normal;
}

/// Writes one copy of a primitive: its vertices from `firstVertex` on, its indices from
/// `firstIndex` on.
void writeCopy(const AssetPrimitive& in, const VertexPlacer& placer, std::uint32_t firstVertex,
               std::uint32_t firstIndex, Geometry& out) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, in.positions.size(), kGrain),
                      [&](const auto& range) {
                          for (std::size_t i = range.begin(); i < range.end(); ++i) {
                              out.positions[firstVertex + i] = glm::vec3(placer.position(i));
                              out.normals[firstVertex + i] = glm::vec3(placer.normal(i));
                          }
                      });
    const bool mirrored = placer.mirrored();
    const bool ownNormals = in.flat && in.deforms();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, in.indices.size() / 3, kGrain),
                      [&](const auto& range) {
                          for (std::size_t t = range.begin(); t < range.end(); ++t) {
                              const std::uint32_t* corner = &in.indices[3 * t];
                              std::uint32_t* written = &out.indices[firstIndex + 3 * t];
                              written[0] = firstVertex + corner[0];
                              // A mirroring matrix turns the front side over; glTF keeps it
                              // (section 3.7.4).
                              written[1] = firstVertex + corner[mirrored ? 2 : 1];
                              written[2] = firstVertex + corner[mirrored ? 1 : 2];
                              if (ownNormals) writeFlatNormal(written, out);
                          }
                      });
}

}  // namespace

void LoadedScene::write(std::size_t index, const Pose& pose, Geometry& out) const {
    const Caster& caster = casters_[index];
    const AssetPrimitive& in = primitives_[caster.primitive];
    const std::span<const glm::dmat4> matrices = caster.range.matricesOf(pose);
    std::uint32_t firstVertex = out.parts[index].firstVertex;
    std::uint32_t firstIndex = out.parts[index].firstIndex;
    for (const glm::dmat4& instance : caster.instances) {
        const glm::dmat4 rigid = matrices[0] * instance;
        const VertexPlacer placer(in, in.influences > 0 ? matrices : std::span(&rigid, 1),
                                  caster.range.weightsOf(pose), origin);
        writeCopy(in, placer, firstVertex, firstIndex, out);
        firstVertex += static_cast<std::uint32_t>(in.positions.size());
        firstIndex += static_cast<std::uint32_t>(in.indices.size());
    }
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
        const std::size_t copies = caster.instances.size();
        const auto vertexCount = static_cast<std::uint32_t>(copies * in.positions.size());
        const auto indexCount = static_cast<std::uint32_t>(copies * in.indices.size());
        geometry->parts.push_back(
            {caster.name, vertices, vertexCount, indices, indexCount, in.material, caster.moves});
        for (std::size_t copy = 0; copy < copies; ++copy) {
            geometry->uvs.insert(geometry->uvs.end(), in.uvs.begin(), in.uvs.end());
        }
        vertices += vertexCount;
        indices += indexCount;
    }
    geometry->positions.resize(vertices);
    geometry->normals.resize(vertices);
    geometry->indices.resize(indices);
    for (std::size_t i = 0; i < casters_.size(); ++i) {
        write(i, poses_[0], *geometry);
    }
    first_ = geometry;
    if (poses_.size() > 1) return;
    // Nothing is written a second time.
    primitives_ = {};
    casters_ = {};
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
        if (casters_[i].moves) write(i, poses_[pose], *made);
    }
    const std::lock_guard lock(mutex_);
    if (std::shared_ptr<const Geometry> known = others_[pose].lock()) return known;
    others_[pose] = made;
    return made;
}

}  // namespace penumbra::scene_detail
